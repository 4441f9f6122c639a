//! References to other files and to data inside the reference itself.
//!
//! RFC 3986 percent encoding, RFC 2397 data URIs, RFC 4648 base64. Everything but a
//! relative path or data is refused; nothing is fetched from a network.

use std::path::PathBuf;

/// What a URI in a file stands for.
#[derive(Debug, PartialEq, Eq)]
pub(crate) enum Target {
    /// The bytes that it holds.
    Data(Vec<u8>),
    /// A path, relative to the folder of the file.
    File(PathBuf),
}

/// What a URI stands for, or a clause that says what is wrong with it.
pub(crate) fn resolve(uri: &str) -> Result<Target, &'static str> {
    if let Some(rest) = strip_prefix_ignoring_case(uri, "data:") {
        return data(rest).map(Target::Data);
    }
    // A scheme stands before the first `:` and holds no `/`; `C:` counts as one.
    let first_segment = uri.split('/').next().unwrap_or_default();
    if first_segment.contains(':') {
        return Err("is neither a relative path nor a data URI");
    }
    let path = String::from_utf8(percent_decoded(uri)?).map_err(|_| "is not UTF-8")?;
    if path.starts_with('/') || path.contains(['\\', '\0']) || path.split('/').next().is_some_and(|s| s.contains(':')) {
        return Err("is not a relative path");
    }
    if path.is_empty() {
        return Err("is empty");
    }
    Ok(Target::File(path.split('/').collect()))
}

fn data(rest: &str) -> Result<Vec<u8>, &'static str> {
    let (media_type, payload) = rest.split_once(',').ok_or("is a data URI without a comma")?;
    if media_type.len() >= 7 && media_type.is_char_boundary(media_type.len() - 7) && {
        media_type[media_type.len() - 7..].eq_ignore_ascii_case(";base64")
    } {
        base64(payload.as_bytes())
    } else {
        percent_decoded(payload)
    }
}

fn strip_prefix_ignoring_case<'a>(text: &'a str, prefix: &str) -> Option<&'a str> {
    let head = text.get(..prefix.len())?;
    head.eq_ignore_ascii_case(prefix).then(|| &text[prefix.len()..])
}

fn percent_decoded(text: &str) -> Result<Vec<u8>, &'static str> {
    let mut decoded = Vec::with_capacity(text.len());
    let mut bytes = text.bytes();
    while let Some(byte) = bytes.next() {
        decoded.push(match byte {
            b'%' => {
                let mut digit = || bytes.next().and_then(|c| char::from(c).to_digit(16));
                match (digit(), digit()) {
                    (Some(high), Some(low)) => (high * 16 + low) as u8,
                    _ => return Err("has a percent sign without two hexadecimal digits"),
                }
            }
            other => other,
        });
    }
    Ok(decoded)
}

/// Decodes base64 in either alphabet, with or without padding; white space is skipped.
fn base64(text: &[u8]) -> Result<Vec<u8>, &'static str> {
    const BROKEN: &str = "holds broken base64";
    let mut decoded = Vec::with_capacity(text.len() / 4 * 3 + 3);
    let (mut bits, mut held, mut padding) = (0u32, 0u32, 0u32);
    for &byte in text {
        let value = match byte {
            b'A'..=b'Z' => byte - b'A',
            b'a'..=b'z' => byte - b'a' + 26,
            b'0'..=b'9' => byte - b'0' + 52,
            b'+' | b'-' => 62,
            b'/' | b'_' => 63,
            b'=' => {
                padding += 1;
                continue;
            }
            byte if byte.is_ascii_whitespace() => continue,
            _ => return Err(BROKEN),
        };
        if padding > 0 {
            return Err(BROKEN);
        }
        bits = bits << 6 | u32::from(value);
        held += 6;
        if held >= 8 {
            held -= 8;
            decoded.push((bits >> held) as u8);
            bits &= (1 << held) - 1;
        }
    }
    // Six bits alone cannot make a byte, and what is left over must be zero padding.
    if held == 6 || bits != 0 || padding > 2 { Err(BROKEN) } else { Ok(decoded) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn base64_decodes_the_vectors_of_the_standard() {
        for (text, plain) in [
            ("", ""),
            ("Zg==", "f"),
            ("Zm8=", "fo"),
            ("Zm9v", "foo"),
            ("Zm9vYg==", "foob"),
            ("Zm9vYmE", "fooba"),
            ("Zm9v\nYmFy", "foobar"),
        ] {
            assert_eq!(base64(text.as_bytes()).as_deref(), Ok(plain.as_bytes()), "{text:?}");
        }
        assert_eq!(base64(b"-_+/").as_deref(), Ok(&[0xfb, 0xff, 0xbf][..]));
        for broken in ["Z", "Zm9vY", "Zm=v", "Zg===", "Zh==", "Zm9*"] {
            assert!(base64(broken.as_bytes()).is_err(), "{broken:?}");
        }
    }

    #[test]
    fn data_uris_hold_their_bytes() {
        let resolved = resolve("data:application/octet-stream;base64,AAEC");
        assert_eq!(resolved, Ok(Target::Data(vec![0, 1, 2])));
        assert_eq!(resolve("DATA:,a%20b"), Ok(Target::Data(b"a b".to_vec())));
        assert!(resolve("data:image/png;base64").is_err());
    }

    #[test]
    fn paths_are_percent_decoded_and_stay_relative() {
        assert_eq!(resolve("a%20folder/im%C3%A4ge.png"), Ok(Target::File(PathBuf::from("a folder/imäge.png"))));
        assert_eq!(resolve("./up/../x:y.bin"), Ok(Target::File(PathBuf::from("./up/../x:y.bin"))));
        for refused in [
            "http://example.org/x.bin",
            "file:///etc/passwd",
            "//server/share",
            "/etc/passwd",
            "%2Fetc/passwd",
            "C:/x.bin",
            "c%3A/x.bin",
            "\\\\server\\share",
            "a%5Cb",
            "a%00b",
            "a%2",
            "a%zz",
            "%ff",
            "",
        ] {
            assert!(resolve(refused).is_err(), "{refused:?}");
        }
    }
}
