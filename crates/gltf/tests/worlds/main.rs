//! Whole files, written by the tests, loaded and looked at.

mod animation;
mod files;
mod geometry;
mod hostile;
mod insertion;
mod materials;
mod regressions;
mod scenes;
mod skins;
mod writer;
