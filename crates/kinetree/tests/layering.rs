//! A module uses what stands before it in `lib.rs`, never what stands after.

use std::fs;
use std::path::{Path, PathBuf};

#[path = "common/paths.rs"]
mod paths;

use paths::{homes_of_exports, names_from_root, tokens, without_tests};

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

fn source_folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("src")
}

/// The modules that a file lies in: `wide/refit/mod.rs` is `["wide", "refit"]`, and `wide/mesh.rs`
/// is `["wide", "mesh"]`.
fn module_of(file: &Path) -> Vec<String> {
    let inside = file.strip_prefix(source_folder()).unwrap().with_extension("");
    let mut names: Vec<String> = inside.iter().map(|name| name.to_str().unwrap().to_owned()).collect();
    if names.last().is_some_and(|name| name == "mod") {
        names.pop();
    }
    names
}

#[test]
fn modules_use_only_what_stands_before_them() {
    let library = fs::read_to_string(source_folder().join("lib.rs")).unwrap();
    let library = tokens(&library);
    let layers: Vec<&str> =
        library.windows(3).filter(|three| three[0] == "mod" && three[2] == ";").map(|three| three[1]).collect();
    let homes = homes_of_exports(&library);
    for known in ["geometry", "tree", "build", "update", "traverse", "query", "scene"] {
        assert!(layers.contains(&known), "`{known}` is a module of lib.rs");
    }
    assert_eq!((homes.get("Mesh"), homes.get("Ray")), (Some(&"scene"), Some(&"geometry")));

    let files: Vec<(PathBuf, String)> =
        sources(&source_folder()).into_iter().map(|file| (file.clone(), fs::read_to_string(file).unwrap())).collect();
    // Modules in files of their own that only tests have.
    let of_tests: Vec<Vec<String>> = files
        .iter()
        .flat_map(|(file, text)| {
            let modules = without_tests(&tokens(text)).1.into_iter().map(str::to_owned);
            modules.map(|name| [module_of(file), vec![name]].concat()).collect::<Vec<_>>()
        })
        .collect();
    let (mut checked, mut uses) = (0, 0);
    for (file, text) in &files {
        let module = module_of(file);
        let Some(height) = layers.iter().position(|name| *name == module[0]) else { continue };
        if of_tests.contains(&module) {
            continue;
        }
        let (code, _) = without_tests(&tokens(text));
        for name in names_from_root(&code, module.len()) {
            let home = homes.get(name).copied().unwrap_or(name);
            let used = layers.iter().position(|layer| *layer == home);
            let used = used.unwrap_or_else(|| panic!("{}: what is `crate::{name}`?", file.display()));
            assert!(used <= height, "{} uses `{home}`, which stands after `{}`", file.display(), module[0]);
            uses += 1;
        }
        checked += 1;
    }
    assert!(checked > 100 && uses > 200, "only {checked} files and {uses} paths were looked at");
}

#[test]
fn paths_are_seen_however_they_are_written() {
    let cases: [(&str, usize, &[&str]); 9] = [
        ("use crate::scene::Mesh;", 2, &["scene"]),
        ("use crate::{geometry::{Aabb, Ray}, scene, wide::*};", 2, &["geometry", "scene", "wide"]),
        ("fn f(x: &crate :: scene::Mesh) { crate\n::query::f() }", 1, &["scene", "query"]),
        ("use super::scene::Mesh; use super::super::query;", 1, &["scene"]),
        ("use super::scene::Mesh; use super::super::query;", 2, &["query"]),
        ("use super::{super::{scene, tree::Bvh}, here};", 2, &["scene", "tree"]),
        ("pub(crate) fn f() {} pub(super) struct S;", 1, &[]),
        (
            "/// As [`crate::scene`].\n// use crate::query;\n/* /* crate::wide */ */ const S: &str = \"crate::scene\";",
            1,
            &[],
        ),
        (
            "const C: [char; 2] = ['\"', '\\'']; fn f<'a>(x: &'a str) { r#\"\" crate::x \"#; crate::scene::g(x) }",
            1,
            &["scene"],
        ),
    ];
    for (text, depth, expected) in cases {
        assert_eq!(names_from_root(&tokens(text), depth), expected, "{text}");
    }
    let text = "use crate::tree; #[cfg(test)] mod by_hand; #[cfg(test)] mod tests { use crate::scene; fn f() {} } use crate::wide;";
    let all = tokens(text);
    let (code, modules) = without_tests(&all);
    assert_eq!((names_from_root(&code, 1), modules), (vec!["tree", "wide"], vec!["by_hand"]));
}

#[test]
fn one_file_names_the_thread_pool_and_one_the_clock() {
    for (words, home) in [(&["rayon"][..], "threads.rs"), (&["Instant", "SystemTime"][..], "clock.rs")] {
        for file in sources(&source_folder()) {
            let text = fs::read_to_string(&file).unwrap();
            let named = tokens(&text).iter().any(|token| words.contains(token));
            assert_eq!(named, file.ends_with(home), "{words:?} in {}", file.display());
        }
    }
}

/// A function that is marked `inline` is compiled with the caller's crate, and so are the walks
/// that it calls: then optimising this crate alone, as the front page proposes for debug builds,
/// leaves them as slow as they were.
#[test]
fn what_is_asked_of_a_frame_is_compiled_in_this_crate() {
    for file in ["query/options.rs", "scene/snapshot.rs"] {
        let text = fs::read_to_string(source_folder().join(file)).unwrap();
        let tokens = tokens(&text);
        for (at, _) in tokens.iter().enumerate().filter(|(_, token)| **token == "inline") {
            let item = tokens[at..].iter().skip_while(|token| **token != "]").skip(1).take(3);
            let item: Vec<&str> = item.copied().collect();
            assert!(item[..2] != ["pub", "fn"], "{file}: `{}` is inline", item[2]);
        }
    }
}
