//! What can be wrong with a file, said in one line.

use std::fmt;
use std::io;
use std::path::{Path, PathBuf};

use kinetree::EditError;

/// A file that could not be loaded. Its message is one line that names the file and what is wrong
/// with it.
#[derive(Debug, thiserror::Error)]
#[error("{}: {problem}", one_line(.file))]
pub struct LoadError {
    file: PathBuf,
    problem: Problem,
}

impl LoadError {
    pub(crate) fn new(file: &Path, problem: Problem) -> Self {
        Self { file: file.to_path_buf(), problem }
    }

    /// The file that was to be loaded.
    pub fn file(&self) -> &Path {
        &self.file
    }

    /// What is wrong with it.
    pub fn problem(&self) -> &Problem {
        &self.problem
    }
}

/// What is wrong with a file.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Problem {
    /// The file itself.
    #[error("cannot be read: {0}")]
    Unreadable(io::Error),
    /// A file that it refers to.
    #[error("refers to {uri}, which cannot be read: {error}")]
    Missing {
        /// As written in the file.
        uri: Quoted,
        /// The reason.
        error: io::Error,
    },
    /// A URI that is neither a relative path nor data, or is malformed.
    #[error("refers to {uri}, which {reason}")]
    Uri {
        /// As written in the file.
        uri: Quoted,
        /// A clause about it.
        reason: &'static str,
    },
    /// The container format of a `.glb` file: its header and its chunks.
    #[error("is not a whole binary glTF 2.0 file: {0}")]
    Container(&'static str),
    /// The JSON is broken, or is not that of a glTF file.
    #[error("has JSON that is not glTF 2.0: {0}")]
    Json(Quoted),
    /// It requires an extension that is not supported.
    #[error("requires the extension {0}, which is not supported")]
    Extension(Quoted),
    /// A reference from one item to another that is not there.
    #[error("{from} refers to {kind} {index}, but there are {count}")]
    NoSuch {
        /// The item that has the reference.
        from: Item,
        /// What kind of item is referred to.
        kind: &'static str,
        /// Which one.
        index: usize,
        /// How many the file has.
        count: usize,
    },
    /// An item that breaks a rule.
    #[error("{item} {reason}")]
    Invalid {
        /// The item.
        item: Item,
        /// A clause about it.
        reason: String,
    },
    /// It would take far more memory than its size can justify.
    #[error("asks for more data than a file of its size can hold, first in {0}")]
    TooLarge(Item),
    /// The file has no such animation.
    #[error("has no animation {asked}: it has {}", known_clips(.known, *.count))]
    NoClip {
        /// The index or name.
        asked: String,
        /// How many it has.
        count: usize,
        /// The first of them, such as `0 "walk"`.
        known: Vec<String>,
    },
    /// The node that it was to be inserted below.
    #[error("cannot be inserted below a node: {0}")]
    Parent(EditError),
    /// The library refused an edit that the file asks for.
    #[error("{item} cannot become part of a scene: {error}")]
    Refused {
        /// The item.
        item: Item,
        /// The reason.
        error: EditError,
    },
}

/// One thing in a file, such as `mesh 3 "body"`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Item {
    /// In the singular, as the specification calls it.
    pub kind: &'static str,
    /// Its index in the array of the file.
    pub index: usize,
    /// As written in the file.
    pub name: Option<String>,
}

impl Item {
    pub(crate) fn new(kind: &'static str, index: usize) -> Self {
        Self { kind, index, name: None }
    }

    pub(crate) fn named(kind: &'static str, index: usize, name: Option<&str>) -> Self {
        Self { kind, index, name: name.map(shortened) }
    }

    pub(crate) fn invalid(&self, reason: impl Into<String>) -> Problem {
        Problem::Invalid { item: self.clone(), reason: reason.into() }
    }
}

impl fmt::Display for Item {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} {}", self.kind, self.index)?;
        match &self.name {
            Some(name) => write!(f, " {}", Quoted::new(name)),
            None => Ok(()),
        }
    }
}

/// Text from a file, quoted, without control characters, and shortened, so that it fits into one
/// line.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Quoted(String);

impl Quoted {
    const LONGEST: usize = 160;

    pub(crate) fn new(text: &str) -> Self {
        Self(format!("{:?}", shortened(text)))
    }

    /// Without the quotation marks.
    pub(crate) fn bare(text: &str) -> Self {
        Self(shortened(text).chars().map(|c| if c.is_control() { ' ' } else { c }).collect())
    }
}

impl fmt::Display for Quoted {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

fn shortened(text: &str) -> String {
    match text.char_indices().nth(Quoted::LONGEST) {
        Some((end, _)) => format!("{}...", &text[..end]),
        None => text.to_owned(),
    }
}

fn known_clips(known: &[String], count: usize) -> String {
    let more = if known.len() < count { format!(" and {} more", count - known.len()) } else { String::new() };
    if count == 0 { "none".to_owned() } else { format!("{count}: {}{more}", known.join(", ")) }
}

fn one_line(path: &Path) -> String {
    path.display().to_string().chars().map(|c| if c.is_control() { '?' } else { c }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_message_is_one_line_whatever_the_names_hold() {
        let item = Item::named("mesh", 3, Some(&"two\nlines".repeat(100)));
        let text = LoadError::new(Path::new("odd\nname.glb"), item.invalid("is broken")).to_string();
        assert!(!text.contains('\n'), "{text}");
        assert!(text.len() < 300, "{text}");
        assert!(text.starts_with("odd?name.glb: mesh 3 \"two\\nlines"), "{text}");
    }
}
