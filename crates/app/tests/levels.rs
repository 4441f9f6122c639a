//! A picture is the same at every processor level and for any number of threads.

mod common;

use std::fs;
use std::process::Command;

use common::{Sandbox, errors_of};
use kinetree::simd::Level;

#[test]
fn a_picture_does_not_depend_on_the_level_nor_on_the_number_of_threads() {
    let sandbox = Sandbox::new();
    let mut pictures = Vec::new();
    for level in Level::available() {
        for threads in ["1", "2", "3"] {
            let name = format!("{}-{threads}.png", level.name());
            let output = Command::new(env!("CARGO_BIN_EXE_kinetree"))
                .args(["render", "--size", "64x36", "--spp", "2", "--time", "2", "--threads", threads, "--out"])
                .arg(sandbox.path(&name))
                .env("KINETREE_SIMD", level.name())
                .output()
                .unwrap();
            assert!(output.status.success(), "{name}: {}", errors_of(&output));
            pictures.push((fs::read(sandbox.path(&name)).unwrap(), name));
        }
    }
    let different: Vec<&str> =
        pictures.iter().filter(|(picture, _)| *picture != pictures[0].0).map(|(_, name)| name.as_str()).collect();
    assert!(different.is_empty(), "{different:?} are not as {}", pictures[0].1);
    sandbox.picture(&pictures[0].1, (64, 36));
}
