//! The road itself: asphalt, painted lines, kerbs, gravel and the mown verge.

use glam::{Vec2, Vec3};

use crate::ground::{Ground, VERGE, smoothstep};
use crate::meshing::Sketch;
use crate::palette::Palette;
use crate::rng::noise;
use crate::track::{HALF_WIDTH, Station, Track};

/// Rows of the asphalt along a lap.
const ROWS: usize = 640;
/// Length of one stripe of a kerb, metres.
const STRIPE: f32 = 1.25;
/// Above this curvature, 1/m, a corner has gravel and tyres at its outside.
pub(crate) const SHARP: f32 = 0.0125;

/// The road with its paint, kerbs and verge.
pub(crate) fn road(seed: u64, track: &Track, ground: &Ground, palette: &Palette) -> Sketch {
    let mut pad = Sketch::new(palette.asphalt);
    asphalt(&mut pad, seed, track);
    lines(&mut pad, track, palette);
    start_line(&mut pad, track, palette);
    for side in [-1.0, 1.0] {
        verge(&mut pad, side, track, ground, palette);
        kerbs(&mut pad, side, track, palette);
    }
    pad
}

/// The height of the kerb's profile from its inner to its outer edge, metres.
const KERB: [(f32, f32); 5] = [(-0.10, -0.01), (0.10, 0.03), (0.55, 0.065), (1.15, 0.085), (1.30, -0.06)];

fn asphalt(pad: &mut Sketch, seed: u64, track: &Track) {
    band(pad, track, 10, |distance, station, across| {
        let offset = HALF_WIDTH * (1.0 - 2.0 * across);
        // Rubber darkens the line that the cars take.
        let line = (station.curvature * 170.0).clamp(-2.6, 2.6);
        let rubber = (-(offset - line).powi(2) / 5.0).exp();
        let patch = 0.05 * noise(seed ^ 21, distance / 17.0, offset / 4.0);
        let level = 0.118 + patch * 0.3 - 0.048 * rubber;
        (station.at(offset), Vec2::new(offset, distance) / 4.0, [level * 1.02, level, level * 0.98])
    });
}

fn lines(pad: &mut Sketch, track: &Track, palette: &Palette) {
    pad.material = palette.paint;
    for side in [-1.0, 1.0] {
        band(pad, track, 1, |_, station, across| {
            let offset = side * (HALF_WIDTH - 0.30) + 0.08 * (1.0 - 2.0 * across);
            (station.at(offset) + Vec3::Y * 0.008, Vec2::ZERO, [0.74; 3])
        });
    }
}

fn start_line(pad: &mut Sketch, track: &Track, palette: &Palette) {
    let on_road = |distance: f32, offset: f32| track.at(distance).at(offset) + Vec3::Y * 0.012;
    pad.set_material(palette.chequer, [0.85; 3]);
    let middle = start_distance(track);
    for piece in 0..8 {
        let (right, width) = (-HALF_WIDTH + 0.4 + piece as f32 * 1.3, 1.3);
        let corners = [(0.0, right), (0.0, right + width), (1.3, right + width), (1.3, right)]
            .map(|(along, offset)| on_road(middle + along, offset));
        pad.panel([corners[1], corners[0], corners[3], corners[2]]);
    }
    pad.set_material(palette.paint, [0.74; 3]);
    for slot in 0..10 {
        let offset = if slot % 2 == 0 { 2.6 } else { -2.6 };
        let at = middle - 6.0 - 7.0 * slot as f32;
        for (along, across, length, width) in [(0.0, 0.0, 0.15, 2.4), (-0.8, 1.2, 0.95, 0.15), (-0.8, -1.2, 0.95, 0.15)]
        {
            let (from, to) = (offset + across - width / 2.0, offset + across + width / 2.0);
            let [a, b] = [at + along, at + along + length];
            pad.panel([on_road(a, to), on_road(a, from), on_road(b, from), on_road(b, to)]);
        }
    }
}

/// The distance at which the lap begins: in front of the main stand.
pub(crate) fn start_distance(track: &Track) -> f32 {
    track.nearest(20.0, 78.0).0
}

fn verge(pad: &mut Sketch, side: f32, track: &Track, ground: &Ground, palette: &Palette) {
    pad.material = palette.grass;
    let offsets = [HALF_WIDTH - 0.02, 6.9, 8.4, 10.0, 11.6, VERGE, VERGE + 1.6];
    let columns = offsets.len() as u32 - 1;
    band(pad, track, columns, |distance, station, across| {
        // Columns run from the driver's left to the right.
        let across = if side > 0.0 { 1.0 - across } else { across };
        let away = offsets[(across * columns as f32).round() as usize];
        let road = station.at(side * away.min(9.0)) + station.left * (side * (away - away.min(9.0)));
        let land = ground.height(road.x, road.z).0;
        let height = match away {
            away if away > VERGE + 1.0 => land - 0.8,
            away => {
                road.y + (land + 0.03 - road.y) * smoothstep(6.9, VERGE, away) - if away < 6.0 { 0.03 } else { 0.0 }
            }
        };
        let gravel = away > 8.0 && away < 12.5 && -side * station.curvature > SHARP;
        let mown = if (distance / 5.0) as i32 % 2 == 0 { 1.12 } else { 0.9 };
        let color =
            if gravel { [0.46, 0.38, 0.26] } else { ground.green(road.x, road.z).map(|channel| channel * mown) };
        (Vec3::new(road.x, height, road.z), Vec2::new(road.x, road.z) / 3.0, color)
    });
}

/// A strip of quads along the whole lap; `point` gives position, texture coordinates and colour for
/// a distance, a station and a coordinate across in 0..=1, from left to right.
fn band(pad: &mut Sketch, track: &Track, columns: u32, point: impl Fn(f32, &Station, f32) -> (Vec3, Vec2, [f32; 3])) {
    let first = pad.vertex_count();
    // The first row is repeated at the end, so that texture coordinates go on.
    for row in 0..=ROWS {
        let distance = track.length() * row as f32 / ROWS as f32;
        let station = track.at(distance);
        for column in 0..=columns {
            let (position, uv, color) = point(distance, &station, column as f32 / columns as f32);
            pad.color = color;
            pad.vertex(position, Vec3::Y, uv);
        }
    }
    let at = |row: usize, column: u32| first + row as u32 * (columns + 1) + column;
    for row in 0..ROWS {
        for column in 0..columns {
            pad.quad(at(row, column), at(row, column + 1), at(row + 1, column + 1), at(row + 1, column));
        }
    }
    let same: Vec<[u32; 2]> = (0..=columns).map(|column| [at(0, column), at(ROWS, column)]).collect();
    pad.smooth(first, &same);
}

/// Red and white stripes at the inside of corners, and at the outside of the sharper ones.
fn kerbs(pad: &mut Sketch, side: f32, track: &Track, palette: &Palette) {
    pad.material = palette.paint;
    let count = (track.length() / STRIPE / 2.0) as usize * 2;
    for stripe in 0..count {
        let [from, to] = [stripe, stripe + 1].map(|i| track.length() * i as f32 / count as f32);
        let inside = side * track.at(0.5 * (from + to)).curvature;
        if inside < 0.0055 && inside > -0.011 {
            continue;
        }
        pad.color = if stripe % 2 == 0 { [0.62, 0.035, 0.03] } else { [0.78, 0.77, 0.74] };
        let first = pad.vertex_count();
        for part in 0..=2 {
            let station = track.at(from + (to - from) * part as f32 / 2.0);
            for column in 0..KERB.len() {
                let index = if side > 0.0 { KERB.len() - 1 - column } else { column };
                let (away, height) = KERB[index];
                pad.vertex(station.at(side * (HALF_WIDTH + away)) + Vec3::Y * height, Vec3::Y, Vec2::ZERO);
            }
        }
        let columns = KERB.len() as u32;
        for part in 0..2 {
            for column in 0..columns - 1 {
                let at = first + part * columns + column;
                pad.quad(at, at + 1, at + columns + 1, at + columns);
            }
        }
        pad.smooth(first, &[]);
    }
}
