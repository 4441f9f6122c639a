//! Identifies files, so that two paths or open files can be recognised as the same file.

use std::fs::{self, File};
use std::io;
use std::path::Path;

/// The identity of a file: its device and inode; on systems other than Unix its canonical path.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct FileId(Id);

#[cfg(unix)]
type Id = (u64, u64);
#[cfg(not(unix))]
type Id = std::path::PathBuf;

impl FileId {
    /// The file that a path leads to; symbolic links are followed.
    #[cfg(unix)]
    pub(crate) fn of_path(path: &Path) -> io::Result<Self> {
        fs::metadata(path).map(|metadata| Self::of_metadata(&metadata))
    }

    #[cfg(not(unix))]
    pub(crate) fn of_path(path: &Path) -> io::Result<Self> {
        fs::canonicalize(path).map(Self)
    }

    /// An open file. `path` is where it was opened, which may lead to another file by now.
    #[cfg(unix)]
    pub(crate) fn of_open(file: &File, _path: &Path) -> io::Result<Self> {
        file.metadata().map(|metadata| Self::of_metadata(&metadata))
    }

    #[cfg(not(unix))]
    pub(crate) fn of_open(_file: &File, path: &Path) -> io::Result<Self> {
        Self::of_path(path)
    }

    #[cfg(unix)]
    fn of_metadata(metadata: &fs::Metadata) -> Self {
        use std::os::unix::fs::MetadataExt;
        Self((metadata.dev(), metadata.ino()))
    }

    /// One of this program's standard streams, if the system tells.
    #[cfg(unix)]
    pub(crate) fn of_stream(stream: &impl std::os::fd::AsFd) -> Option<Self> {
        let file = File::from(stream.as_fd().try_clone_to_owned().ok()?);
        file.metadata().ok().map(|metadata| Self::of_metadata(&metadata))
    }

    #[cfg(not(unix))]
    pub(crate) fn of_stream<T>(_stream: &T) -> Option<Self> {
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_is_the_same_under_every_name() {
        let directory = tempfile::tempdir().unwrap();
        let [one, other] = ["one", "other"].map(|name| directory.path().join(name));
        fs::write(&one, b"same").unwrap();
        fs::write(&other, b"same").unwrap();
        let of = |path: &Path| FileId::of_path(path).unwrap();
        assert_ne!(of(&one), of(&other));
        assert_eq!(of(&one), of(&directory.path().join(".").join("one")));
        assert_eq!(of(&one), FileId::of_open(&File::open(&one).unwrap(), &one).unwrap());
        #[cfg(unix)]
        {
            let [hard, soft] = ["hard", "soft"].map(|name| directory.path().join(name));
            fs::hard_link(&one, &hard).unwrap();
            std::os::unix::fs::symlink("one", &soft).unwrap();
            assert_eq!([of(&hard), of(&soft)], [of(&one), of(&one)]);
        }
    }
}
