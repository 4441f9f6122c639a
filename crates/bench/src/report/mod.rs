//! What was measured, as rows for programs, a table for readers, and a chart.

mod chart;
mod row;
mod table;

pub(crate) use chart::chart;
pub(crate) use row::{Metric, Row};
pub(crate) use table::{means, table};
