//! A car's cabin: pillars, roof, windows of one sheet each, and the driver.

use glam::{Affine3A, Vec2, Vec3};

use crate::car::{BLACK, livery_uv, shoulder};
use crate::curve::curve;
use crate::loft::skin;
use crate::meshing::Sketch;
use crate::palette::Palette;

const ROOF: [(f32, f32); 8] = [
    (-1.80, 0.915),
    (-1.45, 1.035),
    (-1.05, 1.155),
    (-0.6, 1.235),
    (-0.2, 1.262),
    (0.12, 1.245),
    (0.50, 1.07),
    (0.92, 0.845),
];
const BELT: [(f32, f32); 6] = [(-1.80, 0.60), (-1.3, 0.72), (-0.7, 0.78), (0.1, 0.80), (0.6, 0.77), (0.92, 0.66)];

/// Columns from the middle of the roof over its edge down to the belt.
const COLUMNS: [f32; 15] = [0.0, 0.1, 0.2, 0.3, 0.4, 0.46, 0.49, 0.52, 0.55, 0.58, 0.62, 0.72, 0.82, 0.93, 1.0];

/// A point of the left half of the cabin.
fn point(z: f32, column: f32) -> Vec3 {
    let (roof, belt) = (curve(&ROOF, z), curve(&BELT, z));
    let low = (shoulder(z) - 0.03).min(roof - 0.004);
    let high = belt * 0.76 + 0.24 * belt * (1.0 - ((roof - low) / 0.35).min(1.0));
    let drop = 0.075 * ((roof - low) / 0.35).min(1.0);
    let edge = Vec2::new(high, roof - drop);
    let position = if column < 0.46 {
        let across = column / 0.46 * 0.90;
        Vec2::new(high * across, roof - 0.35 * drop * across.powi(2))
    } else if column < 0.58 {
        // A quarter round between roof and side.
        let part = (column - 0.46) / 0.12;
        let (start, end) = (Vec2::new(0.90 * high, roof - 0.284 * drop), edge.lerp(Vec2::new(belt, low), 0.06));
        let corner = Vec2::new(0.985 * high, roof - 0.5 * drop);
        start.lerp(corner, part).lerp(corner.lerp(end, part), part)
    } else {
        let part = 0.06 + 0.94 * (column - 0.58) / 0.42;
        let bow = 0.02 * (std::f32::consts::PI * part).sin();
        edge.lerp(Vec2::new(belt, low), part) + Vec2::X * bow
    };
    Vec3::new(position.x, position.y, z)
}

/// Adds the cabin.
pub(crate) fn add(pad: &mut Sketch, livery: u32, helmet: [f32; 3], palette: &Palette) {
    let mut stations: Vec<f32> = (0..=44).map(|i| -1.80 + 2.72 * i as f32 / 44.0).collect();
    // The edges of the windows.
    stations.extend([-1.62, -0.86, -0.80, 0.10, 0.84, -1.25, -0.52, -0.44, 0.52]);
    stations.sort_by(f32::total_cmp);
    stations.dedup_by(|a, b| (*a - *b).abs() < 0.004);
    let cell_material = |z: f32, column: f32| {
        let within = |low: f32, high: f32, value: f32| low < value && value < high;
        let windscreen = within(0.10, 0.84, z) && column < 0.46;
        let rear = within(-1.62, -0.86, z) && column < 0.40;
        let side = column > 0.62 && column < 0.93 && (within(-1.25, -0.52, z) || within(-0.44, 0.52, z));
        let roof = within(-0.80, 0.10, z) && column < 0.58;
        Some(match () {
            () if windscreen || rear || side => (palette.glass, [1.0; 3]),
            () if roof || z < -1.62 || column > 0.93 || z < -0.86 && column < 0.62 => (livery, [1.0; 3]),
            () => (palette.paint, BLACK),
        })
    };
    skin(pad, &stations, &COLUMNS, point, cell_material, |point, _, side| livery_uv(point.z, 0.47 * point.x, side));
    inside(pad, helmet, palette);
}

/// The driver, the seat, the roll cage and the wheel.
fn inside(pad: &mut Sketch, helmet: [f32; 3], palette: &Palette) {
    pad.set_material(palette.paint, helmet);
    pad.ball(Vec3::new(0.34, 1.03, -0.36), Vec3::new(0.115, 0.13, 0.14), 12, 20);
    pad.set_material(palette.paint, BLACK);
    // The visor.
    pad.ball(Vec3::new(0.34, 1.04, -0.30), Vec3::new(0.095, 0.045, 0.095), 8, 14);
    pad.cuboid(Vec3::new(0.16, 0.86, -0.62), Vec3::new(0.52, 1.12, -0.50), &Affine3A::IDENTITY);
    pad.set_material(palette.paint, [0.09, 0.10, 0.13]);
    pad.ball(Vec3::new(0.34, 0.86, -0.32), Vec3::new(0.24, 0.12, 0.16), 8, 14);
    pad.set_material(palette.paint, [0.22, 0.22, 0.24]);
    for side in [-1.0, 1.0] {
        let foot = Vec3::new(0.60 * side, 0.88, -1.30);
        let bend = Vec3::new(0.52 * side, 1.15, -0.70);
        pad.tube(&[foot, bend, Vec3::new(0.55 * side, 1.17, 0.0)], &[0.02; 3], 8);
    }
    let bend = |x: f32| Vec3::new(x, 1.16, -0.70);
    pad.tube(&[bend(-0.52), bend(0.0), bend(0.52)], &[0.02; 3], 8);
}
