//! Standard output, standard error, and PNG encoding.

use std::io::{self, Write};

use image::codecs::png::PngEncoder;
use image::{ExtendedColorType, ImageEncoder};
use serde::Serialize;

use crate::args::Common;
use crate::failure::Failure;

/// Prints a line on standard output. If the reader has closed it, that is not a failure.
pub(crate) fn print(text: &str) -> Result<(), Failure> {
    let mut stdout = io::stdout().lock();
    match stdout.write_all(text.as_bytes()).and_then(|()| stdout.write_all(b"\n")).and_then(|()| stdout.flush()) {
        Err(error) if error.kind() != io::ErrorKind::BrokenPipe => {
            Err(Failure::work(format!("standard output: cannot be written: {error}")))
        }
        _ => Ok(()),
    }
}

/// Prints the result of a command: as JSON if requested, else as text, unless it is to be quiet. It
/// goes to standard output, unless a picture or trees were written there.
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
        print_to_stderr(&text);
        return Ok(());
    }
    print(&text)
}

/// Prints a line on standard error. Failures are ignored: there is nowhere to report them.
pub(crate) fn print_to_stderr(line: &str) {
    let _ = writeln!(io::stderr(), "{line}");
}

/// Encodes eight-bit sRGB, three bytes per pixel, row by row from the top, as PNG.
pub(crate) fn png(srgb: &[u8], [width, height]: [u32; 2]) -> Result<Vec<u8>, image::ImageError> {
    let mut bytes = Vec::new();
    PngEncoder::new(&mut bytes).write_image(srgb, width, height, ExtendedColorType::Rgb8)?;
    Ok(bytes)
}
