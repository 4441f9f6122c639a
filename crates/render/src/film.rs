//! The film: a picture in linear RGB.

use std::fmt;

/// A picture of linear RGB, row by row from the top.
#[derive(Clone, PartialEq)]
pub struct Film {
    width: u32,
    height: u32,
    pixels: Vec<[f32; 3]>,
}

/// Prints the size, not the pixels.
impl fmt::Debug for Film {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (width, height) = (self.width, self.height);
        f.debug_struct("Film").field("width", &width).field("height", &height).finish_non_exhaustive()
    }
}

impl Film {
    /// A black picture.
    pub fn new(width: u32, height: u32) -> Self {
        Self { width, height, pixels: vec![[0.0; 3]; width as usize * height as usize] }
    }

    /// Pixels in a row.
    pub fn width(&self) -> u32 {
        self.width
    }

    /// Rows.
    pub fn height(&self) -> u32 {
        self.height
    }

    /// All pixels, linear RGB, row by row from the top.
    pub fn pixels(&self) -> &[[f32; 3]] {
        &self.pixels
    }

    /// One pixel, linear RGB; `[0, 0]` is the upper left.
    ///
    /// # Panics
    /// When the pixel lies outside the picture.
    pub fn pixel(&self, [x, y]: [u32; 2]) -> [f32; 3] {
        assert!(x < self.width && y < self.height, "pixel {x}, {y} of {} x {}", self.width, self.height);
        self.pixels[y as usize * self.width as usize + x as usize]
    }

    /// The mean of all pixels, linear RGB; black for a picture without pixels.
    pub fn mean(&self) -> [f32; 3] {
        let mut sum = [0.0_f64; 3];
        for pixel in &self.pixels {
            for channel in 0..3 {
                sum[channel] += f64::from(pixel[channel]);
            }
        }
        let count = self.pixels.len().max(1) as f64;
        sum.map(|channel| (channel / count) as f32)
    }

    /// Writes consecutive pixels of one row, from `x` to the right.
    pub(crate) fn set_row(&mut self, [x, y]: [u32; 2], run: &[[f32; 3]]) {
        let start = y as usize * self.width as usize + x as usize;
        self.pixels[start..start + run.len()].copy_from_slice(run);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_lie_where_they_were_put() {
        let mut film = Film::new(3, 2);
        film.set_row([1, 1], &[[1.0; 3], [3.0; 3]]);
        assert_eq!(film.pixel([1, 1]), [1.0; 3]);
        assert_eq!(film.pixel([2, 1]), [3.0; 3]);
        assert_eq!(film.pixel([0, 0]), [0.0; 3]);
        assert!((film.mean()[0] - 4.0 / 6.0).abs() < 1e-6);
        assert_eq!(Film::new(0, 0).mean(), [0.0; 3]);
    }
}
