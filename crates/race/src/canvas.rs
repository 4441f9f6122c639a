//! A small raster to paint textures on.

use glam::Vec2;
use kinetree_world::{Filter, Texture, Wrap};

use crate::font::glyph;

/// Texels that are painted over; (0, 0) is the upper left one. Colours are sRGB, eight bits.
pub(crate) struct Canvas {
    width: u32,
    height: u32,
    texels: Vec<[u8; 4]>,
}

impl Canvas {
    /// A canvas of one colour.
    pub(crate) fn new(width: u32, height: u32, color: [u8; 4]) -> Self {
        Self { width, height, texels: vec![color; (width * height) as usize] }
    }

    /// Sets every texel to a function of its coordinates and its colour.
    pub(crate) fn paint(&mut self, color: impl Fn(u32, u32, [u8; 4]) -> [u8; 4]) -> &mut Self {
        for y in 0..self.height {
            for x in 0..self.width {
                let texel = &mut self.texels[(y * self.width + x) as usize];
                *texel = color(x, y, *texel);
            }
        }
        self
    }

    /// Fills a rectangle, given in texels and clipped to the canvas.
    pub(crate) fn rectangle(&mut self, low: [i32; 2], high: [i32; 2], color: [u8; 4]) -> &mut Self {
        for y in low[1].max(0)..high[1].min(self.height as i32) {
            for x in low[0].max(0)..high[0].min(self.width as i32) {
                self.texels[(y as u32 * self.width + x as u32) as usize] = color;
            }
        }
        self
    }

    /// Fills an ellipse with half axes `radii`, turned by an angle.
    pub(crate) fn ellipse(&mut self, center: Vec2, radii: Vec2, radians: f32, color: [u8; 4]) -> &mut Self {
        let turn = Vec2::from_angle(-radians);
        self.paint(|x, y, old| {
            let local = turn.rotate(Vec2::new(x as f32 + 0.5, y as f32 + 0.5) - center) / radii;
            if local.length_squared() <= 1.0 { color } else { old }
        })
    }

    /// Writes text into a box with its upper left corner at `at`; each dot of a letter is `dot`
    /// texels large. `flip` mirrors it left to right and top to bottom, for surfaces whose image
    /// runs the other way.
    pub(crate) fn text(&mut self, text: &str, at: [i32; 2], dot: [i32; 2], flip: [bool; 2], ink: [u8; 4]) -> &mut Self {
        let columns = text.chars().count() as i32 * 6 - 1;
        for (place, character) in text.chars().enumerate() {
            for (row, bits) in (0..).zip(glyph(character)) {
                for column in (0..5).filter(|column| bits >> (4 - column) & 1 == 1) {
                    let across = place as i32 * 6 + column;
                    let across = if flip[0] { columns - 1 - across } else { across };
                    let down = if flip[1] { 6 - row } else { row };
                    let low = [at[0] + across * dot[0], at[1] + down * dot[1]];
                    self.rectangle(low, [low[0] + dot[0], low[1] + dot[1]], ink);
                }
            }
        }
        self
    }

    /// The texture, repeated in both directions.
    pub(crate) fn finish(self, filter: Filter) -> Texture {
        let Self { width, height, texels } = self;
        Texture { width, height, texels, srgb: true, wrap: [Wrap::Repeat; 2], filter }
    }

    /// The texture, clamped at its edges.
    pub(crate) fn finish_clamped(self) -> Texture {
        Texture { wrap: [Wrap::Clamp; 2], ..self.finish(Filter::Bilinear) }
    }
}
