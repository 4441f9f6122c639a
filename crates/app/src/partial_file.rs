//! Unfinished files, and what killed programs leave of them.
//!
//! An unfinished file is locked while its program runs; the system releases the lock when the
//! program ends, however it ends. So an unfinished file that another program can lock is a
//! leftover, and two programs in one folder never remove each other's files.

use std::fs::{self, File, TryLockError};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use crate::file_id::FileId;

/// An unfinished file, removed when dropped unless it was renamed.
#[derive(Debug)]
pub(crate) struct PartialFile {
    file: File,
    path: PathBuf,
    is_finished: bool,
}

/// How many names are tried.
const ATTEMPTS: u32 = 100;

impl PartialFile {
    /// Creates an empty one in a folder, and locks it.
    pub(crate) fn in_folder(folder: &Path) -> io::Result<Self> {
        for attempt in 0..ATTEMPTS {
            let path = folder.join(format!(".kinetree-{}-{attempt}.part", std::process::id()));
            let file = match File::options().write(true).create_new(true).open(&path) {
                Ok(file) => file,
                // Another thread's, or that of a killed program with the same process id.
                Err(error) if error.kind() == io::ErrorKind::AlreadyExists => continue,
                Err(error) => return Err(error),
            };
            let is_locked = match file.try_lock() {
                Ok(()) => true,
                // On a file system without locks no other program can lock it either.
                Err(TryLockError::Error(_)) => true,
                Err(TryLockError::WouldBlock) => false,
            };
            // Another program may have removed it as a leftover before it was locked.
            if is_locked && FileId::of_path(&path).ok() == FileId::of_open(&file, &path).ok() {
                return Ok(Self { file, path, is_finished: false });
            }
        }
        Err(io::Error::other("its folder is full of unfinished files"))
    }

    /// Writes all bytes.
    pub(crate) fn write(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.file.write_all(bytes)?;
        self.file.flush()
    }

    /// Renames it to `path`. If a file is there, it is replaced, and its permissions are kept.
    pub(crate) fn rename_to(mut self, path: &Path) -> io::Result<()> {
        if let Ok(replaced) = fs::metadata(path) {
            self.file.set_permissions(replaced.permissions())?;
        }
        fs::rename(&self.path, path)?;
        self.is_finished = true;
        Ok(())
    }
}

impl Drop for PartialFile {
    fn drop(&mut self) {
        if !self.is_finished {
            // If it cannot be removed, the earlier failure is the one to report.
            let _ = fs::remove_file(&self.path);
        }
    }
}

/// Removes the unfinished files of ended programs from a folder. One that cannot be removed stays;
/// it does no harm.
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

/// The process id in the name of an unfinished file.
fn process_of(name: &str) -> Option<u32> {
    let (process, attempt) = name.strip_prefix(".kinetree-")?.strip_suffix(".part")?.split_once('-')?;
    attempt.parse::<u32>().ok().and(process.parse().ok())
}

/// Whether a process with this id runs on this system. For programs on other machines, only the
/// lock tells.
fn is_running(process: u32) -> bool {
    process == std::process::id() || Path::new(&format!("/proc/{process}")).exists()
}

fn remove_unlocked(path: &Path) -> io::Result<()> {
    let file = File::options().write(true).open(path)?;
    if file.try_lock().is_ok() && FileId::of_path(path)? == FileId::of_open(&file, path)? {
        // No other program uses it: its creator, if it still runs, does not hold the lock.
        fs::remove_file(path)?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Not a valid process id: on Linux the limit is 4,194,304.
    const GONE: u32 = 999_999_999;

    #[test]
    fn leftovers_are_removed_and_files_in_use_stay() {
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
        let ours = PartialFile::in_folder(directory.path()).unwrap();

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
        let [mut one, two] = [0, 1].map(|_| PartialFile::in_folder(directory.path()).unwrap());
        assert_ne!(one.path, two.path);
        one.write(b"whole").unwrap();
        one.rename_to(&directory.path().join("a")).unwrap();
        drop(two);
        let names: Vec<_> = fs::read_dir(directory.path()).unwrap().map(|entry| entry.unwrap().file_name()).collect();
        assert_eq!(names, ["a"]);
    }
}
