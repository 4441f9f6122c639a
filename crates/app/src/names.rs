//! The names of the picture files: one, or one for each frame.

use std::path::{Path, PathBuf};

use crate::destination::is_stream;
use crate::failure::Failure;

/// A file name, which may contain the number of the frame.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum FileNames {
    /// One name for all frames.
    One(PathBuf),
    /// `before`, the number of the frame with at least `digits` digits, `after`.
    Numbered { before: String, digits: usize, after: String },
}

impl FileNames {
    /// The name given by `out`, or else one made from the scene's name, in the current directory.
    /// `sequence` is true if there are several frames.
    pub(crate) fn new(out: Option<&Path>, scene: &str, sequence: bool) -> Result<Self, Failure> {
        let Some(out) = out else {
            return Ok(if sequence {
                Self::Numbered { before: format!("{scene}-"), digits: 4, after: ".png".into() }
            } else {
                Self::One(format!("{scene}.png").into())
            });
        };
        check_extension(out)?;
        let names = Self::parse(out).map_err(|problem| Failure::arguments(format!("{}: {problem}", out.display())))?;
        if sequence && matches!(names, Self::One(_)) {
            return Err(Failure::arguments(format!(
                "{}: several frames need several files: put a number such as %04d into the name",
                out.display()
            )));
        }
        Ok(names)
    }

    fn parse(out: &Path) -> Result<Self, &'static str> {
        // A name that is not Unicode contains no number; a per cent sign without a number stands
        // for itself.
        let Some(text) = out.to_str() else { return Ok(Self::One(out.into())) };
        let mut numbers = text.match_indices('%').filter_map(|(start, _)| {
            let digits = text[start + 1..].find('d').map(|length| &text[start + 1..start + 1 + length])?;
            let is_number = digits.is_empty() || digits.starts_with('0') && digits.bytes().all(|b| b.is_ascii_digit());
            is_number.then_some((start, digits))
        });
        let Some((start, digits)) = numbers.next() else { return Ok(Self::One(out.into())) };
        if numbers.next().is_some() {
            return Err("one number of the frame is enough");
        }
        let width = if digits.is_empty() { 1 } else { digits.parse().ok().filter(|&width| width <= 20).unwrap_or(0) };
        if width == 0 {
            return Err("a number has 1 to 20 digits");
        }
        let after = text[start + digits.len() + 2..].to_owned();
        Ok(Self::Numbered { before: text[..start].to_owned(), digits: width, after })
    }

    /// The file of a frame.
    pub(crate) fn of(&self, frame: u32) -> PathBuf {
        match self {
            Self::One(path) => path.clone(),
            Self::Numbered { before, digits, after } => format!("{before}{frame:0digits$}{after}").into(),
        }
    }
}

/// Files must be named .png; pipes and devices may have any name.
fn check_extension(out: &Path) -> Result<(), Failure> {
    if is_stream(out) {
        return Ok(());
    }
    let extension = out.extension().map(|extension| extension.to_string_lossy().to_lowercase());
    let problem = match extension.as_deref() {
        Some("png") => return Ok(()),
        Some("exr") => "EXR is not written yet; write a .png",
        _ => "pictures are written as .png",
    };
    Err(Failure::arguments(format!("{}: {problem}", out.display())))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn file(out: &str, frame: u32) -> String {
        FileNames::new(Some(out.as_ref()), "scene", false).unwrap().of(frame).display().to_string()
    }

    #[test]
    fn a_number_takes_its_place_in_the_name() {
        assert_eq!(file("lap/%04d.png", 7), "lap/0007.png");
        assert_eq!(file("%d.png", 7), "7.png");
        assert_eq!(file("a%02d/b.PNG", 123), "a123/b.PNG");
        assert_eq!(file("plain.png", 7), "plain.png");
        assert_eq!(file("100% done.png", 7), "100% done.png");
        assert_eq!(FileNames::new(None, "car", true).unwrap().of(3), Path::new("car-0003.png"));
        assert_eq!(FileNames::new(None, "car", false).unwrap().of(3), Path::new("car.png"));
    }

    #[test]
    fn names_that_cannot_serve_are_refused() {
        for wrong in ["a.exr", "a", "", "a.jpg", "%d-%04d.png", "%099d.png", "%00d.png", "lap/"] {
            assert!(FileNames::new(Some(wrong.as_ref()), "scene", false).is_err(), "{wrong}");
        }
        assert!(FileNames::new(Some("a.png".as_ref()), "scene", true).is_err());
        assert!(FileNames::new(Some("a%04d.png".as_ref()), "scene", true).is_ok());
    }
}
