//! Downloads the libraries of other engines that are loaded at run time.

use std::io;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::failure::Failure;

/// A Python package that contains Embree 4.4 with its thread library.
const PACKAGE: &str = "embreex==4.4.0.post1";
/// The folder of the package that holds the libraries.
const LIBRARIES: &str = "embreex.libs/";

/// The folder for downloaded libraries: beside the build products of the workspace, wherever the
/// program is run.
pub(crate) fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../target/peers")
}

/// The downloaded library whose name begins with `start`, if there is one.
#[cfg_attr(not(feature = "embree"), allow(dead_code))]
pub(crate) fn find(start: &str) -> Option<PathBuf> {
    let entries = std::fs::read_dir(folder()).ok()?;
    let mut found: Vec<PathBuf> = entries.filter_map(|entry| entry.ok().map(|entry| entry.path())).collect();
    found.retain(|path| path.file_name().is_some_and(|name| name.to_string_lossy().starts_with(start)));
    found.sort();
    found.into_iter().next()
}

/// Downloads the package with `pip`, and unpacks its libraries into one folder, where Embree finds
/// its thread library.
///
/// # Errors
/// No `pip`, no network, no package for this system, or a folder that cannot be written.
pub(crate) fn fetch() -> Result<Vec<PathBuf>, Failure> {
    let (folder, wheels) = (folder(), folder().join("wheels"));
    std::fs::create_dir_all(&wheels)?;
    pip(&wheels)?;
    let wheel = std::fs::read_dir(&wheels)?
        .filter_map(|entry| entry.ok().map(|entry| entry.path()))
        .find(|path| path.extension().is_some_and(|extension| extension == "whl"))
        .ok_or("pip downloaded no wheel")?;
    let unpacked = unpack(&wheel, &folder)?;
    std::fs::remove_dir_all(&wheels)?;
    if unpacked.is_empty() { Err("the wheel holds no libraries".into()) } else { Ok(unpacked) }
}

fn pip(into: &Path) -> Result<(), Failure> {
    let arguments =
        ["-m", "pip", "download", "--no-deps", "--only-binary=:all:", "--disable-pip-version-check", PACKAGE, "--dest"];
    let status = Command::new("python3").args(arguments).arg(into).status();
    let status = status.map_err(|error| format!("python3, whose pip downloads it, cannot be run: {error}"))?;
    if status.success() { Ok(()) } else { Err(format!("pip could not download {PACKAGE}").into()) }
}

/// Unpacks the files of the package's library folder, without their folders.
fn unpack(wheel: &Path, into: &Path) -> Result<Vec<PathBuf>, Failure> {
    let mut archive = zip::ZipArchive::new(io::BufReader::new(std::fs::File::open(wheel)?))?;
    let mut unpacked = Vec::new();
    for index in 0..archive.len() {
        let mut file = archive.by_index(index)?;
        let Some(path) = file.enclosed_name().filter(|path| path.starts_with(LIBRARIES)) else { continue };
        let Some(name) = path.file_name().filter(|_| file.is_file()) else { continue };
        let target = into.join(name);
        io::copy(&mut file, &mut std::fs::File::create(&target)?)?;
        unpacked.push(target);
    }
    Ok(unpacked)
}
