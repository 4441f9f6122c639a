//! A racing car's body: a shell lofted over cross-sections, with the arches of the wheels cut out.
//!
//! Car space: the origin is on the road midway between the axles, x to the left, y up, z to the
//! nose; metres.

use glam::{Vec2, Vec3};

use crate::curve::curve;
use crate::loft::{skin, through};
use crate::meshing::Sketch;
use crate::palette::Palette;
use crate::{cabin, trim};

/// From the rear axle to the front axle.
pub(crate) const WHEELBASE: f32 = 2.70;
/// The z of the axles, rear and front.
pub(crate) const AXLES: [f32; 2] = [-0.5 * WHEELBASE, 0.5 * WHEELBASE];
/// From the middle of the car to the middle of a wheel.
pub(crate) const HALF_TRACK: f32 = 0.815;
/// Tail and nose of the shell.
pub(crate) const ENDS: [f32; 2] = [-2.20, 2.25];
/// Radius of a wheel arch.
const ARCH: f32 = 0.385;
/// Height of the wheels' hubs, and so their radius.
pub(crate) const HUB: f32 = 0.335;
/// The vertex colour of unpainted parts.
pub(crate) const BLACK: [f32; 3] = [0.012, 0.012, 0.014];

#[rustfmt::skip]
const BONNET: [(f32, f32); 9] = [
    (-2.20, 0.86), (-2.05, 0.93), (-1.5, 0.93), (-0.6, 0.90), (0.7, 0.89),
    (1.2, 0.80), (1.7, 0.68), (2.05, 0.56), (2.25, 0.47),
];
#[rustfmt::skip]
const SHOULDER: [(f32, f32); 9] = [
    (-2.20, 0.80), (-1.95, 0.90), (-1.35, 0.95), (-0.7, 0.86), (0.5, 0.82),
    (1.3, 0.83), (1.75, 0.71), (2.05, 0.57), (2.25, 0.45),
];
#[rustfmt::skip]
const HALF_WIDTH: [(f32, f32); 9] = [
    (-2.20, 0.86), (-1.9, 0.94), (-1.35, 0.99), (-0.6, 0.905), (0.4, 0.90),
    (1.35, 0.975), (1.85, 0.93), (2.10, 0.84), (2.25, 0.68),
];
const SILL: [(f32, f32); 6] = [(-2.20, 0.34), (-1.85, 0.20), (-1.0, 0.13), (1.6, 0.13), (2.0, 0.12), (2.25, 0.15)];

/// Half the width of the shell at a z.
pub(crate) fn half_width(z: f32) -> f32 {
    curve(&HALF_WIDTH, z)
}

/// Height of the shoulder line, where sides and top meet.
pub(crate) fn shoulder(z: f32) -> f32 {
    curve(&SHOULDER, z)
}

/// A point of the shell, left half; `column` in 0..=1 runs from the middle line to the sill.
pub(crate) fn shell(z: f32, column: f32) -> Vec3 {
    let (top, edge, width, sill) = (curve(&BONNET, z), shoulder(z), half_width(z), curve(&SILL, z));
    let waist = 0.52 * edge + 0.48 * sill;
    let section = [
        Vec2::new(0.0, top),
        Vec2::new(0.50 * width, 0.55 * top + 0.45 * edge.max(top - 0.03) - 0.004),
        Vec2::new(0.83 * width, edge),
        Vec2::new(0.985 * width, edge - 0.30 * (edge - waist)),
        Vec2::new(width, waist),
        Vec2::new(0.955 * width, sill),
    ];
    let mut point = through(&section, column);
    for axle in AXLES {
        let along = z - axle;
        if along.abs() < ARCH {
            let arch = HUB + (ARCH * ARCH - along * along).max(0.0).sqrt();
            if point.y < edge && arch > sill {
                // The side is compressed between the shoulder and the arch.
                point.y = arch + (point.y - sill) * (edge - arch) / (edge - sill);
            }
        }
        if column > 0.5 {
            let distance = Vec2::new(along, point.y - HUB).length() - ARCH;
            point.x += 0.03 * (-(distance / 0.07).powi(2)).exp();
        }
    }
    Vec3::new(point.x, point.y, z)
}

/// Texture coordinates of the livery.
pub(crate) fn livery_uv(z: f32, column: f32, side: f32) -> Vec2 {
    Vec2::new((z - ENDS[0]) / (ENDS[1] - ENDS[0]), 0.5 + 0.5 * side * column)
}

/// The whole body of a car in one of the liveries.
pub(crate) fn body(livery: u32, wing: [f32; 3], helmet: [f32; 3], palette: &Palette) -> Sketch {
    let mut pad = Sketch::new(livery);
    let columns: Vec<f32> = (0..=26).map(|i| i as f32 / 26.0).collect();
    skin(
        &mut pad,
        &stations(),
        &columns,
        shell,
        |z, column| Some(shell_material(z, column, livery, palette)),
        |point, column, side| livery_uv(point.z, column, side),
    );
    ends(&mut pad, livery, palette);
    cabin::add(&mut pad, livery, helmet, palette);
    pad.coat(livery, palette.coat, 0.006);
    trim::add(&mut pad, wing, palette);
    pad
}

/// The z of the cross-sections of the shell: close together at the arches and the ends.
fn stations() -> Vec<f32> {
    let mut stations: Vec<f32> = (0..=64).map(|i| ENDS[0] + (ENDS[1] - ENDS[0]) * i as f32 / 64.0).collect();
    for axle in AXLES {
        stations.retain(|z| (z - axle).abs() > ARCH + 0.02);
        stations.extend((0..=24).map(|i| axle - ARCH * (i as f32 / 24.0 * std::f32::consts::PI).cos()));
        stations.extend([axle - ARCH - 0.008, axle + ARCH + 0.008]);
    }
    stations.sort_by(f32::total_cmp);
    stations
}

fn shell_material(z: f32, column: f32, livery: u32, palette: &Palette) -> (u32, [f32; 3]) {
    let within = |low: f32, high: f32, value: f32| low < value && value < high;
    if within(-1.62, 0.72, z) && column < 0.30 {
        return (palette.paint, BLACK);
    }
    if within(1.80, 2.11, z) && within(0.36, 0.56, column) {
        let lamp = within(1.87, 2.06, z) && within(0.39, 0.51, column);
        return if lamp { (palette.headlamp, [1.0; 3]) } else { (palette.paint, BLACK) };
    }
    // Vents behind the front wheels and in the bonnet.
    if within(0.72, 0.86, z) && within(0.66, 0.86, column) || within(1.30, 1.55, z) && within(0.14, 0.26, column) {
        return (palette.paint, BLACK);
    }
    (livery, [1.0; 3])
}

/// The faces at the tail and at the nose.
fn ends(pad: &mut Sketch, livery: u32, palette: &Palette) {
    for (z, out, bulge) in [(ENDS[0], -1.0, 0.05), (ENDS[1], 1.0, 0.10)] {
        let rows = 26;
        let at = |row: u32, across: f32| {
            let edge = shell(z, row as f32 / rows as f32);
            let round = 1.0 - across * across;
            let upright = (std::f32::consts::PI * row as f32 / rows as f32).sin();
            Vec3::new(edge.x * across, edge.y, z + out * bulge * round * upright)
        };
        for row in 0..rows {
            let height = at(row, 0.0).y;
            let cell_material = match (out < 0.0, row as f32 / rows as f32) {
                (true, part) if part > 0.36 && part < 0.56 => (palette.tail_lamp, [1.0; 3]),
                (true, part) if part > 0.74 => (palette.paint, BLACK),
                (false, _) if height < 0.36 => (palette.paint, BLACK),
                _ => (livery, [1.0; 3]),
            };
            // Rows run downwards; seen from outside, left and right change places between tail and
            // nose.
            for column in 0..16 {
                let [from, to] = [column, column + 1].map(|i| (i as f32 / 8.0 - 1.0) * out);
                let lamp = cell_material.0 == palette.tail_lamp;
                let gap = lamp && (from + to).abs() * 0.5 < 0.34;
                let worn = if gap { (palette.paint, BLACK) } else { cell_material };
                pad.set_material(worn.0, worn.1);
                let corners = [at(row + 1, from), at(row + 1, to), at(row, to), at(row, from)];
                let normal = (corners[2] - corners[0]).cross(corners[3] - corners[1]).normalize_or(Vec3::Z * out);
                let [a, b, c, d] = corners.map(|point| pad.vertex(point, normal, livery_uv(point.z, 0.9, 1.0)));
                pad.quad(a, b, c, d);
            }
        }
    }
}
