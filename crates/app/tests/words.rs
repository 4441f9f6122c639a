//! Names and phrases that were replaced stay away.
//!
//! `docs/glossary.md` ends with a table of them. They are looked for in every source file and
//! document of the repository and in the names of files, but not in the glossary and the changelog.

use std::collections::HashMap;
use std::fs;
use std::path::{Path, PathBuf};

/// A row of the table.
#[derive(Debug, PartialEq)]
enum Gone {
    /// A whole identifier, in this case.
    Name(String),
    /// Words that follow each other, in any case, whatever stands between them.
    Phrase(Vec<String>),
}

fn repository() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).ancestors().nth(2).unwrap().to_owned()
}

/// The rows of the table below the heading "Gone": `` `names` `` and "phrases" of the first column.
fn gone_in(glossary: &str) -> Vec<Gone> {
    let (_, section) = glossary.split_once("\n## Gone\n").expect("the glossary has a section \"Gone\"");
    let section = section.split("\n## ").next().unwrap();
    let rows = section.lines().filter(|line| line.starts_with('|')).skip(2);
    rows.flat_map(|row| {
        let column = row.split('|').nth(1).unwrap();
        let quoted = |mark| column.split(mark).skip(1).step_by(2);
        let names = quoted('`').map(|name| Gone::Name(name.to_owned()));
        let phrases = quoted('"').map(|phrase| Gone::Phrase(words_of(phrase).map(|(_, word)| word).collect()));
        names.chain(phrases).collect::<Vec<_>>()
    })
    .collect()
}

/// Identifiers, and where they begin.
fn names_of(text: &str) -> impl Iterator<Item = (usize, &str)> {
    let is_part = |letter: char| letter.is_alphanumeric() || letter == '_';
    let names = text.split(move |letter| !is_part(letter)).filter(|name| !name.is_empty());
    names.map(move |name| (name.as_ptr() as usize - text.as_ptr() as usize, name))
}

/// Words in lower case, and where they begin. Those that an identifier is made of count one by one.
fn words_of(text: &str) -> impl Iterator<Item = (usize, String)> {
    names_of(text).flat_map(|(at, name)| {
        let words = name.split('_').filter(|word| !word.is_empty());
        words
            .map(|word| (at + word.as_ptr() as usize - name.as_ptr() as usize, word.to_lowercase()))
            .collect::<Vec<_>>()
    })
}

/// What is in the text after all: the line, and the row of the table.
fn found_in<'a>(text: &str, gone: &'a [Gone]) -> Vec<(usize, &'a Gone)> {
    let line = |at| text[..at].matches('\n').count() + 1;
    let names: HashMap<&str, &Gone> = gone
        .iter()
        .filter_map(|row| match row {
            Gone::Name(name) => Some((name.as_str(), row)),
            Gone::Phrase(_) => None,
        })
        .collect();
    let mut found: Vec<_> = names_of(text).filter_map(|(at, name)| Some((line(at), *names.get(name)?))).collect();
    let words: Vec<(usize, String)> = words_of(text).collect();
    for row in gone {
        let Gone::Phrase(phrase) = row else { continue };
        let is_here = |window: &&[(usize, String)]| window.iter().zip(phrase).all(|((_, word), other)| word == other);
        found.extend(words.windows(phrase.len()).filter(is_here).map(|window| (line(window[0].0), row)));
    }
    found
}

/// Sources and documents below a folder.
fn sources(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        if path.is_dir() {
            if name != "target" && name != ".git" {
                sources(&path, found);
            }
        } else if folder.file_name().is_some_and(|folder| folder == ".ci")
            || ["rs", "md", "toml", "py"].iter().any(|kind| name.ends_with(&format!(".{kind}")))
        {
            found.push(path);
        }
    }
}

#[test]
fn what_is_gone_is_nowhere() {
    let repository = repository();
    let gone = gone_in(&fs::read_to_string(repository.join("docs/glossary.md")).unwrap());
    assert!(gone.len() > 50, "only {} rows were read", gone.len());
    let mut files = Vec::new();
    sources(&repository, &mut files);
    assert!(files.len() > 300, "only {} files were found", files.len());
    let mut found = Vec::new();
    for file in files {
        let name = file.strip_prefix(&repository).unwrap();
        if name == Path::new("docs/glossary.md") || name == Path::new("CHANGELOG.md") {
            continue;
        }
        let text = format!("{}\n{}", name.display(), fs::read_to_string(&file).unwrap());
        // The name of the file stands before the first line.
        found.extend(
            found_in(&text, &gone).into_iter().map(|(line, row)| format!("{}:{}: {row:?}", name.display(), line - 1)),
        );
    }
    assert!(found.is_empty(), "docs/glossary.md says what to write instead:\n{}", found.join("\n"));
}

#[test]
fn names_are_found_whole_and_phrases_across_lines() {
    let table =
        "# G\n\n| `Other` | x |\n\n## Gone\n\n| gone | now |\n|---|---|\n| `OldName`, \"hums softly\" | `Name` |\n";
    let gone = gone_in(table);
    let phrase = Gone::Phrase(vec!["hums".to_owned(), "softly".to_owned()]);
    assert_eq!(gone, [Gone::Name("OldName".to_owned()), phrase]);
    let lines = |text| found_in(text, &gone).into_iter().map(|(line, _)| line).collect::<Vec<_>>();
    assert_eq!(lines("let x = OldName::new();"), [1]);
    assert_eq!(lines("OldNames, oldname, MyOldName, Old Name"), [0; 0]);
    assert_eq!(lines("// a box that Hums\n    /// softly"), [1]);
    assert_eq!(lines("a\nfn a_box_hums_softly() {}"), [2]);
    assert_eq!(lines("it hums very softly"), [0; 0]);
}
