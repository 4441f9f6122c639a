//! What is read: a file on disk, or one in memory.

use std::fmt;
use std::path::{Path, PathBuf};

/// Where a file comes from.
#[derive(Clone, Copy)]
#[non_exhaustive]
pub enum Source<'a> {
    /// A file on disk, with the files next to it that it refers to.
    Path(&'a Path),
    /// The contents of a `.glb` or `.gltf` file.
    Bytes {
        /// What messages call it.
        name: &'a str,
        /// The whole file.
        bytes: &'a [u8],
        /// Where the files are that it refers to; `None` if such references are refused.
        folder: Option<&'a Path>,
    },
}

impl<'a> Source<'a> {
    /// What messages call it.
    pub(crate) fn name(&self) -> &'a Path {
        match *self {
            Self::Path(path) => path,
            Self::Bytes { name, .. } => Path::new(name),
        }
    }
}

/// In short: of a file in memory, how long it is.
impl fmt::Debug for Source<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Path(path) => f.debug_tuple("Path").field(path).finish(),
            Self::Bytes { name, bytes, folder } => f
                .debug_struct("Bytes")
                .field("name", name)
                .field("bytes", &bytes.len())
                .field("folder", folder)
                .finish(),
        }
    }
}

/// A path.
impl<'a> From<&'a str> for Source<'a> {
    fn from(path: &'a str) -> Self {
        Self::Path(Path::new(path))
    }
}

impl<'a> From<&'a Path> for Source<'a> {
    fn from(path: &'a Path) -> Self {
        Self::Path(path)
    }
}

impl<'a> From<&'a PathBuf> for Source<'a> {
    fn from(path: &'a PathBuf) -> Self {
        Self::Path(path)
    }
}

/// A file that refers to no others.
impl<'a> From<&'a [u8]> for Source<'a> {
    fn from(bytes: &'a [u8]) -> Self {
        Self::Bytes { name: "a file in memory", bytes, folder: None }
    }
}
