//! A module uses what stands before it in `lib.rs`, never what stands after.

use std::fs;
use std::path::{Path, PathBuf};

fn sources(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            found.extend(sources(&path));
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            found.push(path);
        }
    }
    found
}

/// What comes before the tests of a file, which may use everything.
fn without_tests(text: &str) -> &str {
    text.split("#[cfg(test)]\nmod tests {").next().unwrap_or(text)
}

#[test]
fn modules_use_only_what_stands_before_them() {
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let library = fs::read_to_string(source.join("lib.rs")).unwrap();
    let layers: Vec<&str> = library
        .lines()
        .filter_map(|line| line.strip_prefix("pub mod ").or(line.strip_prefix("mod ")))
        .map(|name| name.trim_end_matches(';'))
        .collect();
    for known in ["geometry", "tree", "build", "update", "traverse", "query", "scene"] {
        assert!(layers.contains(&known), "`{known}` is a module of lib.rs");
    }
    let mut checked = 0;
    for file in sources(&source) {
        let inside = file.strip_prefix(&source).unwrap().components().next().unwrap();
        let layer = inside.as_os_str().to_str().unwrap().trim_end_matches(".rs");
        let Some(height) = layers.iter().position(|name| *name == layer) else { continue };
        let is_test = file.file_stem().is_some_and(|stem| stem == "tests");
        let text = fs::read_to_string(&file).unwrap();
        for above in layers[height + 1..].iter().filter(|_| !is_test) {
            let uses = without_tests(&text).contains(&format!("crate::{above}"));
            assert!(!uses, "{} uses `{above}`, which stands after `{layer}`", file.display());
        }
        checked += 1;
    }
    assert!(checked > 30, "only {checked} files were looked at");
}

#[test]
fn one_file_names_the_thread_pool_and_one_the_clock() {
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    for (word, home) in [("rayon::", "threads.rs"), ("time::Instant", "clock.rs")] {
        for file in sources(&source) {
            let named = fs::read_to_string(&file).unwrap().contains(word);
            assert_eq!(named, file.ends_with(home), "`{word}` in {}", file.display());
        }
    }
}
