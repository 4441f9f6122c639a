//! Grandstands: steps, seats, walls, a roof; the placement of stands and seats.
//!
//! Stand space: x along the stand, y up, z away from the road; the front row begins at z = 0;
//! metres.

use glam::{Affine3A, Mat3, Vec3};

use crate::ground::Ground;
use crate::meshing::Sketch;
use crate::palette::Palette;
use crate::track::Track;

/// Rows of seats.
const ROWS: usize = 14;
/// Seats in a row.
const SEATS: usize = 72;
/// Spacing of seats in a row, height and depth of a row.
const PITCH: Vec3 = Vec3::new(0.58, 0.44, 0.86);
/// Height of the first step.
const FIRST: f32 = 1.3;
/// From the middle of the road to the front of a stand.
const SETBACK: f32 = 18.5;
/// Positions of the stands: the nearest point of the road, x and z, and the side of it, 1 for left.
const PLACES: [([f32; 2], f32); 5] =
    [([170.0, 30.0], -1.0), ([150.0, 66.0], -1.0), ([-20.0, 78.0], -1.0), ([26.0, 78.0], -1.0), ([72.0, 78.0], -1.0)];

/// The placements of the stands, world from stand space.
pub(crate) fn placements(track: &Track, ground: &Ground) -> Vec<Affine3A> {
    let place = |&([x, z], side): &([f32; 2], f32)| {
        let station = track.at(track.nearest(x, z).0);
        let away = station.left * side;
        let along = Vec3::Y.cross(away);
        let front = station.middle + away * SETBACK;
        // High enough for the highest ground along its front.
        let height = (-4..=4)
            .map(|i| {
                let point = front + along * (length() * i as f32 / 8.0);
                ground.height(point.x, point.z).0
            })
            .fold(f32::NEG_INFINITY, f32::max);
        Affine3A::from_mat3_translation(Mat3::from_cols(along, Vec3::Y, away), Vec3::new(front.x, height, front.z))
    };
    PLACES.iter().map(place).collect()
}

/// Length of a stand, metres.
pub(crate) fn length() -> f32 {
    SEATS as f32 * PITCH.x
}

/// Depth of a stand, from front to back, metres.
pub(crate) fn depth() -> f32 {
    1.2 + ROWS as f32 * PITCH.z
}

/// The front edge of each seat, in stand space.
pub(crate) fn seats() -> impl Iterator<Item = Vec3> {
    (0..ROWS).flat_map(|row| (0..SEATS).filter(|&seat| !is_aisle(seat)).map(move |seat| seat_at(row, seat)))
}

fn is_aisle(seat: usize) -> bool {
    matches!(seat % 24, 11 | 12)
}

fn seat_at(row: usize, seat: usize) -> Vec3 {
    let x = (seat as f32 + 0.5) * PITCH.x - 0.5 * length();
    Vec3::new(x, FIRST + row as f32 * PITCH.y, 1.3 + row as f32 * PITCH.z)
}

/// The mesh of a stand, shared by all.
pub(crate) fn stand(palette: &Palette) -> Sketch {
    let mut pad = Sketch::new(palette.paint);
    let here = Affine3A::IDENTITY;
    let (half, deep) = (0.5 * length(), depth());
    let top = FIRST + ROWS as f32 * PITCH.y;

    // The foundation reaches below sloping ground.
    pad.color = [0.36, 0.35, 0.33];
    pad.cuboid(Vec3::new(-half, -4.0, 0.0), Vec3::new(half, FIRST - PITCH.y, 1.2), &here);
    for row in 0..ROWS {
        let z = 1.0 + row as f32 * PITCH.z;
        let step = FIRST + row as f32 * PITCH.y - 0.02;
        pad.cuboid(Vec3::new(-half, -4.0, z), Vec3::new(half, step, z + PITCH.z), &here);
        for seat in 0..SEATS {
            let at = seat_at(row, seat);
            if is_aisle(seat) {
                pad.color = [0.62, 0.60, 0.20];
                pad.cuboid(at + Vec3::new(-0.29, -0.02, -0.3), at + Vec3::new(0.29, 0.0, -0.22), &here);
            } else {
                // Blocks of seats in two colours.
                pad.color = if seat / 12 % 2 == 0 { [0.05, 0.13, 0.36] } else { [0.55, 0.55, 0.56] };
                pad.cuboid(at + Vec3::new(-0.22, 0.36, 0.0), at + Vec3::new(0.22, 0.41, 0.40), &here);
                pad.cuboid(at + Vec3::new(-0.22, 0.41, 0.36), at + Vec3::new(0.22, 0.78, 0.41), &here);
            }
            pad.color = [0.36, 0.35, 0.33];
        }
    }
    walls_and_roof(&mut pad, half, deep, top);
    front(&mut pad, half, palette);
    pad
}

fn walls_and_roof(pad: &mut Sketch, half: f32, deep: f32, top: f32) {
    let here = Affine3A::IDENTITY;
    pad.color = [0.48, 0.47, 0.45];
    pad.cuboid(Vec3::new(-half, -4.0, deep), Vec3::new(half, top + 1.2, deep + 0.3), &here);
    for side in [-1.0f32, 1.0] {
        // Side walls climb with the steps.
        for row in 0..ROWS {
            let z = 1.0 + row as f32 * PITCH.z;
            let x = [side * half, side * (half + 0.2)];
            let high = FIRST + row as f32 * PITCH.y + 1.0;
            pad.cuboid(Vec3::new(x[0].min(x[1]), -4.0, z), Vec3::new(x[0].max(x[1]), high, z + PITCH.z), &here);
        }
    }
    let (eaves, ridge) = (top + 3.6, top + 2.9);
    pad.color = [0.55, 0.56, 0.58];
    let bays = 7;
    for bay in 0..=bays {
        let x = (half - 0.3) * (2.0 * bay as f32 / bays as f32 - 1.0);
        pad.beam(Vec3::new(x, -2.0, deep + 0.5), Vec3::new(x, ridge, deep + 0.5), 0.35, 0.35);
        pad.beam(Vec3::new(x, ridge, deep + 0.5), Vec3::new(x, eaves + 0.1, -0.8), 0.22, 0.45);
        pad.beam(Vec3::new(x, top - 0.8, deep + 0.3), Vec3::new(x, eaves - 0.6, deep * 0.45), 0.14, 0.14);
    }
    pad.color = [0.24, 0.25, 0.27];
    let slab = [Vec3::new(-half - 0.4, ridge + 0.25, deep + 0.9), Vec3::new(half + 0.4, ridge + 0.25, deep + 0.9)];
    let edge = [Vec3::new(half + 0.4, eaves + 0.35, -1.2), Vec3::new(-half - 0.4, eaves + 0.35, -1.2)];
    let up = Vec3::Y * 0.14;
    pad.panel([slab[0], slab[1], edge[0], edge[1]]);
    pad.panel([edge[1] + up, edge[0] + up, slab[1] + up, slab[0] + up]);
    pad.color = [0.62, 0.05, 0.04];
    pad.cuboid(Vec3::new(-half - 0.4, eaves - 0.15, -1.3), Vec3::new(half + 0.4, eaves + 0.6, -1.2), &here);
}

/// The wall before the first row, with boards facing the road.
fn front(pad: &mut Sketch, half: f32, palette: &Palette) {
    let here = Affine3A::IDENTITY;
    pad.set_material(palette.paint, [0.66, 0.66, 0.65]);
    pad.cuboid(Vec3::new(-half, -4.0, -0.25), Vec3::new(half, FIRST + 0.6, 0.0), &here);
    let count = 6;
    for index in 0..count {
        pad.set_material(palette.boards[index * 2 % palette.boards.len()], [1.0; 3]);
        let [right, left] = [index, index + 1].map(|i| half * (2.0 * i as f32 / count as f32 - 1.0));
        let z = -0.27;
        let (low, high) = (FIRST - 1.0, FIRST + 0.5);
        // From the road, +x is to the left.
        pad.panel([
            Vec3::new(left - 0.15, low, z),
            Vec3::new(right + 0.15, low, z),
            Vec3::new(right + 0.15, high, z),
            Vec3::new(left - 0.15, high, z),
        ]);
    }
    pad.set_material(palette.paint, [0.5, 0.5, 0.52]);
    for height in [0.35, 0.75] {
        let y = FIRST + 0.6 + height;
        pad.beam(Vec3::new(-half, y, -0.1), Vec3::new(half, y, -0.1), 0.05, 0.05);
    }
}
