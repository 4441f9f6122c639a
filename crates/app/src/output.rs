//! What leaves the program: pictures as files that appear whole, text on the two streams.

use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use image::codecs::png::PngEncoder;
use image::{ExtendedColorType, ImageEncoder};
use serde::Serialize;

use crate::args::Common;
use crate::failure::Failure;

/// Text on standard output. Who has closed it wants no more, which is no failure.
pub(crate) fn say(text: &str) -> Result<(), Failure> {
    let mut stdout = io::stdout().lock();
    match stdout.write_all(text.as_bytes()).and_then(|()| stdout.write_all(b"\n")).and_then(|()| stdout.flush()) {
        Err(error) if error.kind() != io::ErrorKind::BrokenPipe => {
            Err(Failure::work(format!("standard output: cannot be written: {error}")))
        }
        _ => Ok(()),
    }
}

/// What a command has found: as JSON where that is asked for, else in words, unless it is to be quiet.
pub(crate) fn report(figures: &impl Serialize, words: impl FnOnce() -> String, common: &Common) -> Result<(), Failure> {
    if common.json {
        let json = serde_json::to_string_pretty(figures);
        say(&json.map_err(|error| Failure::work(format!("the figures cannot be written: {error}")))?)
    } else if common.quiet {
        Ok(())
    } else {
        say(&words())
    }
}

/// A line on standard error. When even that is closed there is nobody left to tell.
pub(crate) fn remark(line: &str) {
    let _ = writeln!(io::stderr(), "{line}");
}

/// A PNG file of eight-bit sRGB, three bytes per pixel, row by row from the top.
pub(crate) fn png(srgb: &[u8], [width, height]: [u32; 2]) -> Result<Vec<u8>, image::ImageError> {
    let mut bytes = Vec::new();
    PngEncoder::new(&mut bytes).write_image(srgb, width, height, ExtendedColorType::Rgb8)?;
    Ok(bytes)
}

/// Makes the directories that a file will need, and finds out early when it cannot be written.
pub(crate) fn prepare(path: &Path) -> Result<(), Failure> {
    let failure = |error: io::Error| Failure::work(format!("{}: cannot be written: {error}", path.display()));
    if let Some(directory) = directory_of(path) {
        fs::create_dir_all(directory).map_err(failure)?;
    }
    if path.is_dir() { Err(failure(io::ErrorKind::IsADirectory.into())) } else { Ok(()) }
}

/// Writes a file that appears whole or not at all: it is written beside its place and then renamed.
pub(crate) fn write_whole(path: &Path, bytes: &[u8]) -> Result<(), Failure> {
    let write = || {
        let mut draft = Draft::beside(path)?;
        draft.file.write_all(bytes)?;
        draft.become_file(path)
    };
    write().map_err(|error: io::Error| Failure::work(format!("{}: cannot be written: {error}", path.display())))
}

/// A file that is not finished, and is gone when it never will be.
struct Draft {
    file: File,
    path: PathBuf,
    is_finished: bool,
}

impl Draft {
    fn beside(path: &Path) -> io::Result<Self> {
        let directory = directory_of(path).unwrap_or(Path::new("."));
        let mut attempt = 0_u32;
        loop {
            let path = directory.join(format!(".kinetree-{}-{attempt}.part", std::process::id()));
            match File::options().write(true).create_new(true).open(&path) {
                Ok(file) => return Ok(Self { file, path, is_finished: false }),
                // Somebody with the same number left one behind.
                Err(error) if error.kind() == io::ErrorKind::AlreadyExists && attempt < 100 => attempt += 1,
                Err(error) => return Err(error),
            }
        }
    }

    fn become_file(mut self, path: &Path) -> io::Result<()> {
        self.file.flush()?;
        fs::rename(&self.path, path)?;
        self.is_finished = true;
        Ok(())
    }
}

impl Drop for Draft {
    fn drop(&mut self) {
        if !self.is_finished {
            // If it cannot be removed, the failure that led here is the one to be told.
            let _ = fs::remove_file(&self.path);
        }
    }
}

fn directory_of(path: &Path) -> Option<&Path> {
    path.parent().filter(|directory| !directory.as_os_str().is_empty())
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

    #[test]
    fn a_file_appears_whole_and_alone() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("deep/er/a.png");
        prepare(&path).unwrap();
        write_whole(&path, b"first").unwrap();
        write_whole(&path, b"second").unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"second");
        assert_eq!(names_in(path.parent().unwrap()), ["a.png"]);
    }

    #[test]
    fn nothing_is_left_of_a_file_that_could_not_take_its_place() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("taken.png");
        fs::create_dir_all(path.join("full")).unwrap();
        assert!(prepare(&path).is_err());
        assert!(write_whole(&path, b"bytes").is_err());
        assert_eq!(names_in(directory.path()), ["taken.png"]);
    }
}
