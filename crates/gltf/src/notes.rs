//! What was ignored or repaired, in few enough lines to be read.

use std::collections::BTreeMap;

use crate::error::Item;

/// Collects lines, of which those beyond a bound are only counted.
#[derive(Default)]
pub(crate) struct Notes {
    lines: Vec<String>,
    /// Keyed by what is ignored: extensions and properties, each of which gets one line.
    ignored: BTreeMap<String, Ignored>,
    left_out: usize,
}

/// Something that is ignored.
struct Ignored {
    /// What follows from that, a clause.
    consequence: &'static str,
    /// The first that has it; `None` if only the file as a whole says so.
    first: Option<Item>,
    /// How many have it.
    count: usize,
}

impl Notes {
    /// How many lines of each kind are kept; the others are counted.
    const MOST: usize = 100;

    /// Adds a line, which is only formatted if there is room for it.
    pub(crate) fn add(&mut self, line: impl FnOnce() -> String) {
        if self.lines.len() < Self::MOST {
            self.lines.push(line());
        } else {
            self.left_out += 1;
        }
    }

    /// Notes that an extension or a property is ignored: in an item that has it, or in the file as
    /// a whole.
    pub(crate) fn ignored(&mut self, what: &str, consequence: &'static str, of: Option<&Item>) {
        if !self.ignored.contains_key(what) {
            if self.ignored.len() == Self::MOST {
                self.left_out += 1;
                return;
            }
            self.ignored.insert(what.to_owned(), Ignored { consequence, first: None, count: 0 });
        }
        if let (Some(ignored), Some(item)) = (self.ignored.get_mut(what), of) {
            ignored.first.get_or_insert_with(|| item.clone());
            ignored.count += 1;
        }
    }

    pub(crate) fn into_lines(mut self) -> Vec<String> {
        for (what, Ignored { consequence, first, count }) in self.ignored {
            let at = match (first, count) {
                (None, _) => String::new(),
                (Some(item), 1) => format!(" at {item}"),
                (Some(item), _) => format!(" at {count} {}, first at {item}", plural(item.kind)),
            };
            self.lines.push(format!("{what} is ignored{at}: {consequence}"));
        }
        if self.left_out > 0 {
            self.lines.push(format!("and {} more", self.left_out));
        }
        self.lines
    }
}

fn plural(kind: &str) -> String {
    if kind.ends_with("sh") { format!("{kind}es") } else { format!("{kind}s") }
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

    #[test]
    fn what_is_ignored_gets_one_line_however_often_it_is_noted() {
        let mut notes = Notes::default();
        notes.ignored("sheen", "nothing has a sheen", None);
        for i in 3..10 {
            notes.ignored("sheen", "nothing has a sheen", Some(&Item::new("mesh", i)));
        }
        notes.ignored("metalness", "nothing is a metal", Some(&Item::new("material", 1)));
        let wanted = [
            "metalness is ignored at material 1: nothing is a metal",
            "sheen is ignored at 7 meshes, first at mesh 3: nothing has a sheen",
        ];
        assert_eq!(notes.into_lines(), wanted);

        let mut notes = Notes::default();
        (0..1_000_000).for_each(|i| notes.ignored(&i.to_string(), "nothing follows", None));
        assert_eq!(notes.into_lines().len(), Notes::MOST + 1);
    }
}
