//! All measurements of a run, as a child process hands them to its parent.

use serde::{Deserialize, Serialize};

use super::row::Row;

/// Figures of a tree.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct TreeNote {
    /// The name of the case.
    pub(crate) case: String,
    /// The name of the engine.
    pub(crate) engine: String,
    /// Triangles of the scene.
    pub(crate) triangles: usize,
    /// Bytes of the finished tree.
    pub(crate) bytes: usize,
    /// As `Facts::cost` of the engine.
    pub(crate) cost: Option<f32>,
    /// Summed area of the intersections of sibling boxes, over the root's.
    pub(crate) overlap: Option<f32>,
}

impl TreeNote {
    /// Whether cost and overlap are those of a binary tree, by another formula than Embree's.
    pub(crate) fn is_binary(&self) -> bool {
        self.engine.starts_with("tinybvh")
    }

    /// The figures in one line.
    pub(crate) fn sentence(&self) -> String {
        let number = |number: Option<f32>| number.map_or_else(|| "-".to_owned(), |number| format!("{number:.3}"));
        let each = self.bytes as f64 / self.triangles.max(1) as f64;
        let binary = if self.is_binary() { " (of the binary tree that it begins with)" } else { "" };
        let (cost, overlap) = (number(self.cost), number(self.overlap));
        format!("{:<28} its tree: {each:.1} bytes/triangle, cost {cost}, overlap {overlap}{binary}", self.engine)
    }
}

/// All measurements, and whether the answers were right.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub(crate) struct Record {
    /// Rows in the order in which they were measured.
    pub(crate) rows: Vec<Row>,
    /// One tree for each engine and case.
    pub(crate) trees: Vec<TreeNote>,
    /// Whether kinetree gave a wrong answer.
    pub(crate) kinetree_is_wrong: bool,
    /// Whether any engine gave a wrong answer away from edges of triangles.
    pub(crate) some_engine_differs: bool,
    /// The log.
    pub(crate) text: String,
}

impl Record {
    /// Adds the measurements of process number `process`.
    pub(crate) fn join(&mut self, other: Self, process: usize) {
        for row in other.rows {
            match self.rows.iter_mut().find(|known| known.is_same(&row)) {
                Some(known) => known.join(row, process),
                None => {
                    let mut row = row;
                    row.times.splice(0..0, vec![Vec::new(); process]);
                    row.walls.splice(0..0, vec![Vec::new(); process]);
                    self.rows.push(row);
                }
            }
        }
        for tree in other.trees {
            if !self.trees.iter().any(|known| (&known.case, &known.engine) == (&tree.case, &tree.engine)) {
                self.trees.push(tree);
            }
        }
        self.kinetree_is_wrong |= other.kinetree_is_wrong;
        self.some_engine_differs |= other.some_engine_differs;
        if self.text.is_empty() {
            self.text = other.text;
        }
    }

    /// The tree of an engine in a case.
    pub(crate) fn tree(&self, case: &str, engine: &str) -> Option<&TreeNote> {
        self.trees.iter().find(|tree| tree.case == case && tree.engine == engine)
    }
}

#[cfg(test)]
mod tests {
    use super::super::row::example;
    use super::*;
    use crate::engine::Class;

    #[test]
    fn processes_are_joined_row_by_row_through_json() {
        let run =
            |times: &[f64]| Record { rows: vec![example("kinetree", Class::Fast, true, times)], ..Record::default() };
        let mut all = Record::default();
        for (process, times) in [[1.0, 2.0], [3.0, 4.0]].iter().enumerate() {
            let text = serde_json::to_string(&run(times)).unwrap();
            all.join(serde_json::from_str(&text).unwrap(), process);
        }
        assert_eq!(all.rows.len(), 1);
        assert_eq!(all.rows[0].times, [[1.0, 2.0], [3.0, 4.0]]);
        all.join(Record { rows: vec![example("late", Class::Fast, true, &[5.0])], ..Record::default() }, 2);
        assert_eq!(all.rows[1].times, [vec![], vec![], vec![5.0]]);
    }
}
