//! Which items of its own crate a source file names, as the compiler reads it: comments and strings
//! are no code, and paths may be written in many ways.

use std::collections::HashMap;

/// A word or a sign of Rust. `::` is one sign; strings, characters and numbers are left out.
type Token<'a> = &'a str;

/// The tokens of a text, without comments and literals.
pub(crate) fn tokens(text: &str) -> Vec<Token<'_>> {
    let mut tokens = Vec::new();
    let mut rest = text;
    while let Some(first) = rest.chars().next() {
        let word = rest.find(|c: char| !c.is_alphanumeric() && c != '_').unwrap_or(rest.len());
        let length = if let Some(comment) = comment(rest) {
            comment
        } else if let Some(literal) = literal(rest) {
            literal
        } else if word > 0 {
            if !first.is_ascii_digit() {
                tokens.push(&rest[..word]);
            }
            word
        } else if rest.starts_with("::") {
            tokens.push("::");
            2
        } else {
            if !first.is_whitespace() {
                tokens.push(&rest[..first.len_utf8()]);
            }
            first.len_utf8()
        };
        rest = &rest[length..];
    }
    tokens
}

/// The length of the comment that a text begins with.
fn comment(text: &str) -> Option<usize> {
    if text.starts_with("//") {
        return Some(text.find('\n').unwrap_or(text.len()));
    }
    if !text.starts_with("/*") {
        return None;
    }
    let (mut at, mut depth) = (2, 1);
    while depth > 0 && at < text.len() {
        let rest = &text.as_bytes()[at..];
        let step = if rest.starts_with(b"/*") {
            depth += 1;
            2
        } else if rest.starts_with(b"*/") {
            depth -= 1;
            2
        } else {
            1
        };
        at += step;
    }
    Some(at)
}

/// The length of the string or character that a text begins with.
fn literal(text: &str) -> Option<usize> {
    let unprefixed = text.trim_start_matches(['b', 'c']);
    if text.len() - unprefixed.len() > 1 {
        return None;
    }
    let prefix = text.len() - unprefixed.len();
    if let Some(raw) = unprefixed.strip_prefix('r') {
        let hashes = raw.len() - raw.trim_start_matches('#').len();
        let body = raw[hashes..].strip_prefix('"')?;
        let end = format!("\"{}", "#".repeat(hashes));
        return Some(prefix + 1 + hashes + 1 + body.find(&end).map_or(body.len(), |at| at + end.len()));
    }
    if unprefixed.starts_with('"') {
        return Some(prefix + quoted(unprefixed, '"'));
    }
    let quote = unprefixed.strip_prefix('\'')?;
    // Else a lifetime, or a label.
    let is_character = quote.starts_with('\\') || quote.chars().nth(1) == Some('\'');
    is_character.then(|| prefix + quoted(unprefixed, '\''))
}

/// The length of what stands in quotes, both included.
fn quoted(text: &str, quote: char) -> usize {
    let mut escaped = false;
    for (at, c) in text.char_indices().skip(1) {
        if c == quote && !escaped {
            return at + c.len_utf8();
        }
        escaped = c == '\\' && !escaped;
    }
    text.len()
}

/// The tokens without items that only tests have, and the modules in other files among those.
pub(crate) fn without_tests<'a>(tokens: &[Token<'a>]) -> (Vec<Token<'a>>, Vec<&'a str>) {
    const TEST: [&str; 7] = ["#", "[", "cfg", "(", "test", ")", "]"];
    let (mut kept, mut modules, mut at) = (Vec::new(), Vec::new(), 0);
    while at < tokens.len() {
        if !tokens[at..].starts_with(&TEST) {
            kept.push(tokens[at]);
            at += 1;
            continue;
        }
        at += TEST.len();
        let item = &tokens[at..];
        let end = item.iter().position(|&token| token == "{" || token == ";").unwrap_or(item.len());
        if item.get(end) == Some(&";") {
            modules.extend(item[..end].iter().skip_while(|&&token| token != "mod").nth(1));
        }
        at += if item.get(end) == Some(&"{") { end + block(&item[end..]) } else { end + 1 };
    }
    (kept, modules)
}

/// How many tokens there are up to the end of the block that they begin with.
fn block(tokens: &[Token<'_>]) -> usize {
    let mut depth = 0;
    for (at, &token) in tokens.iter().enumerate() {
        match token {
            "{" => depth += 1,
            "}" => depth -= 1,
            _ => {}
        }
        if depth == 0 {
            return at + 1;
        }
    }
    tokens.len()
}

/// The names that a file takes from the root of its crate: the first name of each path that begins
/// with `crate`, or with so many `super`s that it gets there. `depth` is how many modules the file
/// lies deep, 1 for a module of the root.
pub(crate) fn names_from_root<'a>(tokens: &[Token<'a>], depth: usize) -> Vec<&'a str> {
    let mut names = Vec::new();
    for at in 0..tokens.len() {
        let goes_on = at > 0 && tokens[at - 1] == "::";
        let steps = match tokens[at] {
            "crate" if !goes_on => Some(depth),
            "super" if !goes_on => Some(1),
            // A path that continues from here is one with `self` before it, or in braces.
            _ => None,
        };
        if let Some(steps) = steps {
            follow(&tokens[at + 1..], steps, depth, &mut names);
        }
    }
    names
}

/// Goes on along a path that has left so many modules.
fn follow<'a>(tokens: &[Token<'a>], left: usize, depth: usize, names: &mut Vec<&'a str>) {
    match tokens {
        ["::", "super", rest @ ..] => follow(rest, left + 1, depth, names),
        ["::", "{", rest @ ..] => {
            let mut nested = 0;
            let mut begins = true;
            for (at, &token) in rest.iter().enumerate() {
                match token {
                    "{" => nested += 1,
                    "}" if nested == 0 => return,
                    "}" => nested -= 1,
                    "super" if begins => follow(&rest[at + 1..], left + 1, depth, names),
                    name if begins && left == depth => names.push(name),
                    _ => {}
                }
                begins = token == "," && nested == 0;
            }
        }
        ["::", name, ..] if left == depth => names.push(name),
        _ => {}
    }
}

/// Of each name that the root of a crate gives on with `use`, the module that it is from.
pub(crate) fn homes_of_exports<'a>(root: &[Token<'a>]) -> HashMap<&'a str, &'a str> {
    let mut homes = HashMap::new();
    for at in 0..root.len() {
        let ["use", module, "::", rest @ ..] = &root[at..] else { continue };
        let end = rest.iter().position(|&token| token == ";").unwrap_or(rest.len());
        homes.extend(
            rest[..end].iter().filter(|name| name.starts_with(char::is_alphabetic)).map(|name| (*name, *module)),
        );
    }
    homes
}
