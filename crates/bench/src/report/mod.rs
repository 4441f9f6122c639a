//! What was measured, as rows for programs, tables for readers, and a chart.

mod chart;
mod derived;
mod goals;
mod record;
mod row;
mod table;
mod goal;

pub(crate) use chart::chart;
pub(crate) use goals::{UNINDEXED, goals};
pub(crate) use record::{Record, TreeNote};
pub(crate) use row::{Metric, PerRay, Row, Unit, WrongAnswers, json};
pub(crate) use table::table;

/// Names of the cases of growth begin so; the number of triangles follows.
pub(crate) const GROWTH: &str = "growth ";
