//! Files that are not finished, and what is left of them when a program was killed.
//!
//! A draft is locked as long as its program lives: the system lets go of the lock when the program
//! ends, however it ends. So a draft that can be locked by another program is a leftover, and no
//! two programs in one folder take each other's away.

use std::fs::{self, File, TryLockError};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use crate::file_id::FileId;

/// A file that is not finished, and is gone when it never will be.
#[derive(Debug)]
pub(crate) struct Draft {
    file: File,
    path: PathBuf,
    is_finished: bool,
}

/// How many names are tried before giving up.
const ATTEMPTS: u32 = 100;

impl Draft {
    /// An empty one in a folder, locked.
    pub(crate) fn in_folder(folder: &Path) -> io::Result<Self> {
        for attempt in 0..ATTEMPTS {
            let path = folder.join(format!(".kinetree-{}-{attempt}.part", std::process::id()));
            let file = match File::options().write(true).create_new(true).open(&path) {
                Ok(file) => file,
                // Of another thread, or of a program with the same number that was killed.
                Err(error) if error.kind() == io::ErrorKind::AlreadyExists => continue,
                Err(error) => return Err(error),
            };
            let is_locked = match file.try_lock() {
                Ok(()) => true,
                // A file system without locks: then no other program can lock it either.
                Err(TryLockError::Error(_)) => true,
                Err(TryLockError::WouldBlock) => false,
            };
            // Another program may have taken it for a leftover before it was locked.
            if is_locked && FileId::of_path(&path).ok() == FileId::of_open(&file, &path).ok() {
                return Ok(Self { file, path, is_finished: false });
            }
        }
        Err(io::Error::other("its folder is full of unfinished files"))
    }

    /// Fills it.
    pub(crate) fn write(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.file.write_all(bytes)?;
        self.file.flush()
    }

    /// Takes the place of a file, and its permissions, or becomes a new one.
    pub(crate) fn become_file(mut self, path: &Path) -> io::Result<()> {
        if let Ok(replaced) = fs::metadata(path) {
            self.file.set_permissions(replaced.permissions())?;
        }
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

/// Removes the drafts in a folder whose programs are gone. One that cannot be removed stays: it is
/// in nobody's way.
pub(crate) fn remove_leftovers(folder: &Path) {
    let Ok(entries) = fs::read_dir(folder) else { return };
    for entry in entries.flatten() {
        let is_file = entry.file_type().is_ok_and(|kind| kind.is_file());
        let process = entry.file_name().to_str().and_then(process_of);
        if is_file && process.is_some_and(|process| !is_running(process)) {
            let _ = remove_unlocked(&entry.path());
        }
    }
}

/// The number of the program that a draft of this name belongs to.
fn process_of(name: &str) -> Option<u32> {
    let (process, attempt) = name.strip_prefix(".kinetree-")?.strip_suffix(".part")?.split_once('-')?;
    attempt.parse::<u32>().ok().and(process.parse().ok())
}

/// Whether a program of this number is known to run on this system. Of another machine's programs
/// only the lock tells.
fn is_running(process: u32) -> bool {
    process == std::process::id() || Path::new(&format!("/proc/{process}")).exists()
}

fn remove_unlocked(path: &Path) -> io::Result<()> {
    let file = File::options().write(true).open(path)?;
    if file.try_lock().is_ok() && FileId::of_path(path)? == FileId::of_open(&file, path)? {
        // Nobody else touches it: its maker, if there still is one, has not got the lock.
        fs::remove_file(path)?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// No process has a number as large as this: on Linux, 4,194,304 is the limit.
    const GONE: u32 = 999_999_999;

    #[test]
    fn a_leftover_goes_and_what_somebody_works_on_stays() {
        let directory = tempfile::tempdir().unwrap();
        let at = |name: &str| directory.path().join(name);
        let leftover = at(&format!(".kinetree-{GONE}-0.part"));
        fs::write(&leftover, b"half a pict").unwrap();
        // As a program on another machine would hold it.
        let held = at(&format!(".kinetree-{GONE}-1.part"));
        let lock = File::create(&held).unwrap();
        lock.lock().unwrap();
        let unrelated =
            [".kinetree-x-0.part", ".kinetree-1.part", "kinetree-999999999-0.part", ".kinetree-999999999-0"];
        unrelated.iter().for_each(|name| fs::write(at(name), b"").unwrap());
        let running = at(&format!(".kinetree-{}-7.part", std::process::id()));
        fs::write(&running, b"by a program that runs").unwrap();
        let ours = Draft::in_folder(directory.path()).unwrap();

        remove_leftovers(directory.path());
        assert!(!leftover.exists());
        assert!(held.exists() && running.exists() && ours.path.exists());
        assert!(unrelated.iter().all(|name| at(name).exists()));
        drop(lock);
        remove_leftovers(directory.path());
        assert!(!held.exists());
    }

    #[test]
    fn drafts_of_one_folder_are_apart_and_go_when_they_are_dropped() {
        let directory = tempfile::tempdir().unwrap();
        let [mut one, two] = [0, 1].map(|_| Draft::in_folder(directory.path()).unwrap());
        assert_ne!(one.path, two.path);
        one.write(b"whole").unwrap();
        one.become_file(&directory.path().join("a")).unwrap();
        drop(two);
        let names: Vec<_> = fs::read_dir(directory.path()).unwrap().map(|entry| entry.unwrap().file_name()).collect();
        assert_eq!(names, ["a"]);
    }
}
