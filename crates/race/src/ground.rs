//! The terrain: its height, and the colour of the grass.
//!
//! Near the road the terrain follows the banking; further out it rises into hills.

use glam::{Vec2, Vec3};

use crate::meshing::Sketch;
use crate::palette::Palette;
use crate::rng::{fractal, noise};
use crate::track::{Station, Track};

/// Half the width of the road with its verge, metres; the terrain is lowered below it.
pub(crate) const VERGE: f32 = 13.0;
/// Half the side of the terrain, metres.
const REACH: f32 = 620.0;
/// Quads along a side of the terrain.
const QUADS: u32 = 230;

/// The terrain.
pub(crate) struct Ground {
    stations: Vec<Station>,
    seed: u64,
}

impl Ground {
    /// The terrain around a track.
    pub(crate) fn new(seed: u64, track: &Track) -> Self {
        Self { stations: track.places(420).map(|(_, station)| station).collect(), seed }
    }

    /// Height at x and z, and distance from the centre line of the road, metres.
    ///
    /// Inverse distance weighting of the stations of the road, by the sixth power (Shepard 1968, "A
    /// two-dimensional interpolation function for irregularly-spaced data").
    pub(crate) fn height(&self, x: f32, z: f32) -> (f32, f32) {
        let (mut sum, mut weights, mut nearest) = (0.0, 0.0, f32::INFINITY);
        for station in &self.stations {
            let away = Vec3::new(x - station.middle.x, 0.0, z - station.middle.z);
            let squared = away.length_squared();
            nearest = nearest.min(squared);
            let weight = (squared + 4.0).powi(-3);
            let shelf = away.dot(station.left).clamp(-9.0, 9.0);
            sum += weight * (station.middle.y - station.fall * shelf);
            weights += weight;
        }
        let distance = nearest.sqrt();
        (sum / weights + self.hills(x, z, distance), distance)
    }

    /// The point of the terrain at x and z.
    pub(crate) fn below(&self, x: f32, z: f32) -> Vec3 {
        Vec3::new(x, self.height(x, z).0, z)
    }

    fn hills(&self, x: f32, z: f32, distance: f32) -> f32 {
        let away = smoothstep(18.0, 120.0, distance);
        let rim = smoothstep(170.0, 520.0, Vec2::new(x - 10.0, z).length());
        let rolling = 4.5 * fractal(self.seed ^ 11, x / 75.0, z / 75.0, 3);
        let ridge = 0.62 + 0.55 * fractal(self.seed ^ 12, x / 210.0, z / 210.0, 4);
        away * rolling + rim * ridge * 62.0
    }

    /// Colour of the grass at x and z, linear RGB.
    pub(crate) fn green(&self, x: f32, z: f32) -> [f32; 3] {
        let dry = smoothstep(-0.15, 0.55, fractal(self.seed ^ 13, x / 38.0, z / 38.0, 3));
        let shade = 1.0 + 0.22 * noise(self.seed ^ 14, x / 9.0, z / 9.0);
        let (lush, straw) = (Vec3::new(0.100, 0.155, 0.038), Vec3::new(0.255, 0.215, 0.085));
        (lush.lerp(straw, 0.55 * dry) * shade).to_array()
    }

    /// The mesh of the terrain: fine in the middle, coarse at the rim.
    pub(crate) fn terrain(&self, palette: &Palette) -> Sketch {
        let mut pad = Sketch::new(palette.grass);
        let spread = |i: u32| {
            let u = 2.0 * i as f32 / QUADS as f32 - 1.0;
            REACH * (0.42 * u + 0.58 * u.powi(3))
        };
        for row in 0..=QUADS {
            for column in 0..=QUADS {
                let (x, z) = (spread(column) + 10.0, spread(QUADS - row));
                let (height, distance) = self.height(x, z);
                let dip = 0.8 * smoothstep(VERGE + 0.5, VERGE - 3.5, distance);
                pad.color = self.green(x, z);
                pad.vertex(Vec3::new(x, height - dip, z), Vec3::Y, Vec2::new(x, z) / 3.0);
            }
        }
        let at = |row: u32, column: u32| row * (QUADS + 1) + column;
        for row in 0..QUADS {
            for column in 0..QUADS {
                pad.quad(at(row, column), at(row, column + 1), at(row + 1, column + 1), at(row + 1, column));
            }
        }
        pad.smooth(0, &[]);
        pad
    }
}

/// 0 before `from`, 1 after `to`, smooth between; `from` may be the larger.
pub(crate) fn smoothstep(from: f32, to: f32, value: f32) -> f32 {
    let part = ((value - from) / (to - from)).clamp(0.0, 1.0);
    part * part * (3.0 - 2.0 * part)
}
