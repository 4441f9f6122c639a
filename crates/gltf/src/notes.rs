//! What was ignored or repaired, in few enough lines to be read.

/// Collects remarks; beyond a bound it only counts them.
#[derive(Default)]
pub(crate) struct Notes {
    lines: Vec<String>,
    left_out: usize,
}

impl Notes {
    /// More than anybody reads.
    const MOST: usize = 100;

    /// Takes a remark, which is only written out when there is room for it.
    pub(crate) fn add(&mut self, line: impl FnOnce() -> String) {
        if self.lines.len() < Self::MOST {
            self.lines.push(line());
        } else {
            self.left_out += 1;
        }
    }

    pub(crate) fn into_lines(mut self) -> Vec<String> {
        if self.left_out > 0 {
            self.lines.push(format!("and {} more", self.left_out));
        }
        self.lines
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn many_notes_are_counted_and_not_kept() {
        let mut notes = Notes::default();
        (0..1_000_000).for_each(|i| notes.add(|| i.to_string()));
        let lines = notes.into_lines();
        assert_eq!(lines.len(), Notes::MOST + 1);
        assert_eq!(lines.last().map(String::as_str), Some("and 999900 more"));
    }
}
