//! Rows as JSON, for programs that read results.

use serde::Serialize;

use super::row::{Metric, Row, Unit};
use crate::engine::Mode;
use crate::rays::RayKind;

/// The fields of a row in the JSON results.
#[derive(Serialize)]
struct Published<'a> {
    case: &'a str,
    /// The level that engines were forced to, as far as possible.
    level: &'a str,
    engine: &'a str,
    instructions: &'a str,
    metric: Metric,
    rays: Option<RayKind>,
    mode: Option<Mode>,
    robust: bool,
    threads: usize,
    unit: Unit,
    median: f64,
    min: f64,
    max: f64,
}

impl<'a> Published<'a> {
    fn of(row: &'a Row, level: &'a str) -> Self {
        let &Row { ref case, ref engine, ref instructions, metric, rays, mode, robust, threads, unit, .. } = row;
        let &Row { median, min, max, .. } = row;
        Self { case, level, engine, instructions, metric, rays, mode, robust, threads, unit, median, min, max }
    }
}

/// All rows of a run as a JSON array.
///
/// # Errors
/// Those of the serializer; rows contain nothing that it refuses.
pub(crate) fn json(rows: &[Row], level: &str) -> Result<String, serde_json::Error> {
    let rows: Vec<Published<'_>> = rows.iter().map(|row| Published::of(row, level)).collect();
    serde_json::to_string_pretty(&rows)
}

#[cfg(test)]
mod tests {
    use super::super::row::example;
    use super::*;
    use crate::engine::Class;

    #[test]
    fn a_row_has_the_fields_that_readers_of_results_rely_on() {
        let text = json(&[example("kinetree", Class::Fast, true, &[0.5, 0.25, 1.0])], "scalar").unwrap();
        let value: serde_json::Value = serde_json::from_str(&text).unwrap();
        let row = &value[0];
        let wanted = [
            ("case", serde_json::json!("race")),
            ("level", serde_json::json!("scalar")),
            ("engine", serde_json::json!("kinetree")),
            ("instructions", serde_json::json!("avx2")),
            ("metric", serde_json::json!("trace")),
            ("rays", serde_json::json!("primary")),
            ("mode", serde_json::json!("single")),
            ("robust", serde_json::json!(true)),
            ("threads", serde_json::json!(1)),
            ("unit", serde_json::json!("Mrays/s")),
            ("median", serde_json::json!(2.0)),
            ("min", serde_json::json!(1.0)),
            ("max", serde_json::json!(4.0)),
        ];
        for (field, value) in &wanted {
            assert_eq!(row[field], *value, "{field}");
        }
        assert_eq!(row.as_object().unwrap().len(), wanted.len());
    }
}
