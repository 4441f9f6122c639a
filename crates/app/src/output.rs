//! What the program says on its two streams, and pictures as bytes.

use std::io::{self, Write};

use image::codecs::png::PngEncoder;
use image::{ExtendedColorType, ImageEncoder};
use serde::Serialize;

use crate::args::Common;
use crate::failure::Failure;

/// Text on standard output. Who has closed it wants no more, which is no failure.
pub(crate) fn say(text: &str) -> Result<(), Failure> {
    let mut stdout = io::stdout().lock();
    match stdout.write_all(text.as_bytes()).and_then(|()| stdout.write_all(b"\n")).and_then(|()| stdout.flush()) {
        Err(error) if error.kind() != io::ErrorKind::BrokenPipe => {
            Err(Failure::work(format!("standard output: cannot be written: {error}")))
        }
        _ => Ok(()),
    }
}

/// What a command has found: as JSON where that is asked for, else in words, unless it is to be
/// quiet. On standard output, unless a picture or trees went there.
pub(crate) fn report(
    figures: &impl Serialize,
    words: impl FnOnce() -> String,
    common: &Common,
    is_output_taken: bool,
) -> Result<(), Failure> {
    let text = if common.json {
        let json = serde_json::to_string_pretty(figures);
        json.map_err(|error| Failure::work(format!("the figures cannot be written: {error}")))?
    } else if common.quiet {
        return Ok(());
    } else {
        words()
    };
    if is_output_taken {
        remark(&text);
        return Ok(());
    }
    say(&text)
}

/// A line on standard error. When even that is closed there is nobody left to tell.
pub(crate) fn remark(line: &str) {
    let _ = writeln!(io::stderr(), "{line}");
}

/// A PNG file of eight-bit sRGB, three bytes per pixel, row by row from the top.
pub(crate) fn png(srgb: &[u8], [width, height]: [u32; 2]) -> Result<Vec<u8>, image::ImageError> {
    let mut bytes = Vec::new();
    PngEncoder::new(&mut bytes).write_image(srgb, width, height, ExtendedColorType::Rgb8)?;
    Ok(bytes)
}
