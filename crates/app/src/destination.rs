//! Where bytes are written: to a file, which appears whole or not at all, or to a pipe or a device.

use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use crate::failure::Failure;
use crate::file_id::FileId;
use crate::partial_file::{PartialFile, remove_leftovers};

/// A path that can be written to.
#[derive(Debug)]
pub(crate) struct Destination {
    /// The path as given.
    name: PathBuf,
    kind: Kind,
}

#[derive(Debug)]
enum Kind {
    /// A file that may not exist yet, with all links resolved: the bytes are written beside it,
    /// then renamed.
    File(PathBuf),
    /// An opened pipe or device, or an open file that no longer has a name.
    Opened(File),
    /// This program's own standard output or error, under any name.
    Stream(Stream),
}

/// The standard streams of this program.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Stream {
    Output,
    Error,
}

impl Destination {
    /// Checks whether bytes can be written to a path. A pipe is opened, which blocks until a reader
    /// opens it. No file or folder is created.
    pub(crate) fn resolve(name: &Path) -> Result<Self, Failure> {
        let kind = Kind::resolve(name).map_err(|error| cannot_be_written(name, &error))?;
        Ok(Self { name: name.to_owned(), kind })
    }

    /// Whether this is standard output, so that nothing else must be printed there.
    pub(crate) fn is_standard_output(&self) -> bool {
        matches!(self.kind, Kind::Stream(Stream::Output))
    }

    /// Writes all bytes. A file appears whole or not at all; missing folders are created.
    pub(crate) fn write(self, bytes: &[u8]) -> Result<(), Failure> {
        let written = match self.kind {
            Kind::File(path) => write_whole(&path, bytes),
            Kind::Opened(mut file) => file.write_all(bytes).and_then(|()| file.flush()),
            Kind::Stream(Stream::Output) => write_to(io::stdout().lock(), bytes),
            Kind::Stream(Stream::Error) => write_to(io::stderr().lock(), bytes),
        };
        written.map_err(|error| cannot_be_written(&self.name, &error))
    }
}

impl Kind {
    fn resolve(name: &Path) -> io::Result<Self> {
        let metadata = match fs::metadata(name) {
            Ok(metadata) => metadata,
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Self::file(resolve_links(name)?),
            Err(error) => return Err(error),
        };
        if metadata.is_dir() {
            return Err(io::ErrorKind::IsADirectory.into());
        }
        if let Some(stream) = own_stream(name, &metadata) {
            return Ok(Self::Stream(stream));
        }
        if !metadata.is_file() {
            return File::options().write(true).open(name).map(Self::Opened);
        }
        let path = resolve_links(name)?;
        // Links in `/proc` name an open file that may have moved or been removed.
        if FileId::of_path(&path).ok() != FileId::of_path(name).ok() {
            return File::options().write(true).truncate(true).open(name).map(Self::Opened);
        }
        Self::file(path)
    }

    /// Checks whether a file can be created in the folder, or, if that is missing, in its nearest
    /// existing ancestor.
    fn file(path: PathBuf) -> io::Result<Self> {
        if path.file_name().is_none() || path.as_os_str().as_encoded_bytes().ends_with(b"/") {
            return Err(io::ErrorKind::IsADirectory.into());
        }
        let folder = folder_of(&path);
        let there = folder.ancestors().map(or_current).find(|folder| folder.exists()).unwrap_or(Path::new("."));
        if there == folder {
            remove_leftovers(folder);
        }
        drop(PartialFile::in_folder(there)?);
        Ok(Self::File(path))
    }
}

/// Whether a path is a pipe, a device, or one of this program's own streams, so that its extension
/// says nothing about the content.
pub(crate) fn is_stream(name: &Path) -> bool {
    fs::metadata(name)
        .is_ok_and(|metadata| !metadata.is_dir() && (!metadata.is_file() || own_stream(name, &metadata).is_some()))
}

/// Which of this program's own streams a path leads to. Devices are excluded: they can be opened
/// again.
fn own_stream(name: &Path, metadata: &fs::Metadata) -> Option<Stream> {
    if is_device(metadata) {
        return None;
    }
    let id = FileId::of_path(name).ok();
    let is = |stream: Option<FileId>| stream.is_some() && stream == id;
    if is(FileId::of_stream(&io::stdout())) {
        Some(Stream::Output)
    } else if is(FileId::of_stream(&io::stderr())) {
        Some(Stream::Error)
    } else {
        None
    }
}

#[cfg(unix)]
fn is_device(metadata: &fs::Metadata) -> bool {
    use std::os::unix::fs::FileTypeExt;
    metadata.file_type().is_char_device() || metadata.file_type().is_block_device()
}

#[cfg(not(unix))]
fn is_device(metadata: &fs::Metadata) -> bool {
    !metadata.is_file()
}

/// The path behind symbolic links, whether or not it exists.
fn resolve_links(path: &Path) -> io::Result<PathBuf> {
    /// The limit of Linux.
    const LINKS: usize = 40;
    let mut path = path.to_owned();
    for _ in 0..LINKS {
        match fs::read_link(&path) {
            Ok(target) => path = folder_of(&path).join(target),
            Err(_) => return Ok(path),
        }
    }
    Err(io::Error::other("too many symbolic links"))
}

fn write_whole(path: &Path, bytes: &[u8]) -> io::Result<()> {
    let folder = folder_of(path);
    fs::create_dir_all(folder)?;
    let mut partial = PartialFile::in_folder(folder)?;
    partial.write(bytes)?;
    partial.rename_to(path)
}

fn write_to(mut stream: impl Write, bytes: &[u8]) -> io::Result<()> {
    stream.write_all(bytes)?;
    stream.flush()
}

fn folder_of(path: &Path) -> &Path {
    or_current(path.parent().unwrap_or(Path::new("")))
}

fn or_current(folder: &Path) -> &Path {
    if folder.as_os_str().is_empty() { Path::new(".") } else { folder }
}

fn cannot_be_written(path: &Path, error: &io::Error) -> Failure {
    Failure::work(format!("{}: cannot be written: {error}", path.display()))
}

/// Files that a command reads, and must not overwrite.
#[derive(Debug, Default)]
pub(crate) struct Inputs(Vec<(PathBuf, FileId)>);

impl Inputs {
    /// Those of the paths that exist.
    pub(crate) fn of<'a>(paths: impl IntoIterator<Item = &'a Path>) -> Self {
        Self(paths.into_iter().filter_map(|path| Some((path.to_owned(), FileId::of_path(path).ok()?))).collect())
    }

    /// Fails if a path is one of these files, under any name.
    pub(crate) fn refuse_overwriting(&self, out: &Path) -> Result<(), Failure> {
        let Ok(id) = FileId::of_path(out) else { return Ok(()) };
        match self.0.iter().find(|(_, input)| *input == id) {
            None => Ok(()),
            Some((input, _)) => Err(Failure::arguments(format!(
                "{}: is the same file as {}, which is read: write to another one",
                out.display(),
                input.display()
            ))),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names_in(directory: &Path) -> Vec<String> {
        let mut names: Vec<String> =
            fs::read_dir(directory).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }

    fn write(path: &Path, bytes: &[u8]) -> Result<(), Failure> {
        Destination::resolve(path)?.write(bytes)
    }

    #[test]
    fn a_file_appears_whole_and_alone() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("deep/er/a.png");
        let destination = Destination::resolve(&path).unwrap();
        assert!(names_in(directory.path()).is_empty(), "looking leaves nothing");
        destination.write(b"first").unwrap();
        write(&path, b"second").unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"second");
        assert_eq!(names_in(path.parent().unwrap()), ["a.png"]);
    }

    #[test]
    fn nothing_is_left_of_a_file_that_could_not_take_its_place() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("taken.png");
        let destination = Destination::resolve(&path).unwrap();
        fs::create_dir_all(path.join("full")).unwrap();
        assert!(destination.write(b"bytes").is_err());
        assert!(Destination::resolve(&path).is_err() && Destination::resolve(&directory.path().join("new/")).is_err());
        assert_eq!(names_in(directory.path()), ["taken.png"]);
    }

    #[cfg(unix)]
    #[test]
    fn links_are_followed_and_what_they_lead_to_is_replaced() {
        use std::os::unix::fs::{PermissionsExt, symlink};
        let directory = tempfile::tempdir().unwrap();
        let at = |name: &str| directory.path().join(name);
        fs::create_dir(at("folder")).unwrap();
        fs::write(at("folder/real"), b"old").unwrap();
        fs::set_permissions(at("folder/real"), fs::Permissions::from_mode(0o640)).unwrap();
        symlink("folder/real", at("near")).unwrap();
        symlink(at("near"), at("far")).unwrap();
        symlink("folder/new", at("dangling")).unwrap();
        symlink("round", at("round")).unwrap();
        write(&at("far"), b"new").unwrap();
        write(&at("dangling"), b"made").unwrap();
        assert_eq!(fs::read(at("folder/real")).unwrap(), b"new");
        assert_eq!(fs::metadata(at("folder/real")).unwrap().permissions().mode() & 0o777, 0o640);
        assert_eq!(fs::read(at("folder/new")).unwrap(), b"made");
        for link in ["near", "far", "dangling"] {
            assert!(fs::symlink_metadata(at(link)).unwrap().is_symlink(), "{link}");
        }
        assert!(Destination::resolve(&at("round")).is_err());
        assert_eq!(names_in(&at("folder")), ["new", "real"]);
    }

    #[test]
    fn inputs_are_spared_under_every_name() {
        let directory = tempfile::tempdir().unwrap();
        let at = |name: &str| directory.path().join(name);
        fs::write(at("scene"), b"same").unwrap();
        fs::write(at("twin"), b"same").unwrap();
        fs::hard_link(at("scene"), at("hard")).unwrap();
        let inputs = Inputs::of([&*at("scene"), &*at("missing")]);
        assert!(inputs.refuse_overwriting(&at("twin")).is_ok() && inputs.refuse_overwriting(&at("missing")).is_ok());
        for same in ["scene", "./scene", "hard"] {
            let failure = inputs.refuse_overwriting(&at(same)).unwrap_err().to_string();
            assert!(failure.contains("same file as"), "{failure}");
        }
    }
}
