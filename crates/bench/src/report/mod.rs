//! The results: rows for programs, tables for readers, and a chart.

mod chart;
mod derived;
mod goal;
mod goals;
mod json;
mod record;
mod row;
mod table;

pub(crate) use chart::chart;
pub(crate) use goals::{UNINDEXED, goals};
pub(crate) use json::json;
pub(crate) use record::{Record, TreeNote};
pub(crate) use row::{GROWTH, Metric, PerRay, Row, Unit, WrongAnswers};
pub(crate) use table::table;
