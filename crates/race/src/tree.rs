//! Trees: a trunk, limbs, and cards with twigs of leaves or branches of needles.
//!
//! Tree space: the foot of the trunk is the origin, y up, metres.

use std::f32::consts::{FRAC_PI_2, PI, TAU};

use glam::{Quat, Vec2, Vec3};

use crate::meshing::Sketch;
use crate::palette::Palette;
use crate::rng::Rng;

/// The species of a tree.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Species {
    /// Broad and round.
    Oak,
    /// Tall and slim.
    Poplar,
    /// White bark, light leaves.
    Birch,
    /// Needles, in tiers.
    Pine,
}

/// The parameters of the leafy species.
struct Habit {
    height: f32,
    trunk: f32,
    bark: [f32; 3],
    leaf: [f32; 3],
    texture: usize,
    /// Height of the crown's middle, and its half axes, as shares of the height.
    crown: (f32, Vec3),
    /// Lumps that the crown consists of, and their size as a share of the crown's.
    lumps: (usize, f32),
    card: f32,
}

/// A tree with about `cards` cards of leaves.
pub(crate) fn tree(species: Species, cards: usize, rng: &mut Rng, palette: &Palette) -> Sketch {
    let habit = match species {
        Species::Pine => return pine(cards, rng, palette),
        Species::Oak => Habit {
            height: rng.range(8.5, 11.0),
            trunk: 0.36,
            bark: [0.085, 0.060, 0.042],
            leaf: [0.135, 0.235, 0.040],
            texture: 0,
            crown: (0.63, Vec3::new(0.40, 0.34, 0.40)),
            lumps: (11, 0.50),
            card: 1.15,
        },
        Species::Poplar => Habit {
            height: rng.range(13.0, 16.5),
            trunk: 0.26,
            bark: [0.12, 0.10, 0.075],
            leaf: [0.150, 0.250, 0.050],
            texture: 1,
            crown: (0.56, Vec3::new(0.105, 0.44, 0.105)),
            lumps: (12, 0.42),
            card: 1.05,
        },
        Species::Birch => Habit {
            height: rng.range(8.0, 10.5),
            trunk: 0.17,
            bark: [0.60, 0.58, 0.53],
            leaf: [0.330, 0.330, 0.050],
            texture: 1,
            crown: (0.62, Vec3::new(0.25, 0.36, 0.25)),
            lumps: (9, 0.50),
            card: 0.95,
        },
    };
    leafy(&habit, cards, rng, palette)
}

fn leafy(habit: &Habit, cards: usize, rng: &mut Rng, palette: &Palette) -> Sketch {
    let height = habit.height;
    let mut pad = Sketch::new(palette.paint);
    pad.color = habit.bark;
    let lean = Vec3::new(rng.range(-0.3, 0.3), 0.0, rng.range(-0.3, 0.3));
    let stem = |part: f32| Vec3::Y * (height * 0.86 * part) + lean * part * part * 2.0;
    let path: Vec<Vec3> = (0..=6).map(|i| stem(i as f32 / 6.0) - Vec3::Y * if i == 0 { 0.5 } else { 0.0 }).collect();
    let radii: Vec<f32> = (0..=6).map(|i| habit.trunk * (1.15 - i as f32 / 6.0).powf(1.2).max(0.05)).collect();
    pad.tube(&path, &radii, 8);

    let (middle, half) = (Vec3::Y * (height * habit.crown.0) + lean, habit.crown.1 * height);
    let turn = rng.range(0.0, TAU);
    let lumps: Vec<Vec3> = (0..habit.lumps.0)
        .map(|i| {
            // Spread over a sphere by the golden angle (Vogel 1979).
            let level = 1.0 - 2.0 * (i as f32 + 0.5) / habit.lumps.0 as f32;
            let (sine, cosine) = (turn + i as f32 * 2.399_963).sin_cos();
            let ring = (1.0 - level * level).sqrt();
            middle + Vec3::new(ring * cosine, level, ring * sine) * half * rng.range(0.45, 0.72)
        })
        .collect();
    for lump in &lumps {
        let from = stem(((lump.y / height - 0.22) / 0.86).clamp(0.22, 0.8));
        let knee = from.lerp(*lump, 0.5) - Vec3::Y * 0.25;
        let thick = habit.trunk * 0.34;
        pad.tube(&[from, knee, *lump], &[thick, thick * 0.7, thick * 0.25], 5);
    }

    pad.material = palette.leaves[habit.texture];
    let size = half * habit.lumps.1;
    for card in 0..cards {
        let lump = lumps[card % lumps.len()];
        let out = direction(rng);
        let place = lump + out * size * rng.range(0.72, 1.02);
        // Leaves inside the crown, and low ones, are darker: they are in the shade of the others.
        let depth = ((place - middle) / (half * 1.05)).length().min(1.0);
        let light = (0.42 + 0.58 * depth * depth) * (0.86 + 0.14 * ((place.y - middle.y) / half.y));
        pad.color = rng.shade(habit.leaf, 0.22).map(|channel| channel * light);
        let away = (out * 0.6 + (place - middle) / half * 0.6).normalize_or(Vec3::Y);
        let facing = (away + direction(rng) * 0.75).normalize_or(away);
        leaf_card(&mut pad, place, facing, away, habit.card * rng.range(0.8, 1.2), rng.range(0.0, TAU));
    }
    pad
}

/// A quad of leaves, with normals of the round crown that it belongs to.
fn leaf_card(pad: &mut Sketch, center: Vec3, facing: Vec3, away: Vec3, size: f32, spin: f32) {
    let basis = Quat::from_rotation_arc(Vec3::Z, facing) * Quat::from_rotation_z(spin);
    let normal = (facing * 0.4 + away * 0.6).normalize_or(facing);
    let corners = [(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)]
        .map(|(x, y)| pad.vertex(center + basis * Vec3::new(x, y, 0.0) * size, normal, Vec2::new(0.5 + x, 0.5 - y)));
    let [a, b, c, d] = corners;
    pad.quad(a, b, c, d);
}

/// A random unit vector, uniform over the sphere.
fn direction(rng: &mut Rng) -> Vec3 {
    let level = rng.range(-1.0, 1.0);
    let (sine, cosine) = rng.range(0.0, TAU).sin_cos();
    let ring = (1.0 - level * level).max(0.0).sqrt();
    Vec3::new(ring * cosine, level, ring * sine)
}

/// Tiers of drooping branches; each branch is a sheet folded along its stem.
fn pine(cards: usize, rng: &mut Rng, palette: &Palette) -> Sketch {
    let height = rng.range(10.5, 15.0);
    let mut pad = Sketch::new(palette.paint);
    pad.color = [0.105, 0.062, 0.042];
    let path: Vec<Vec3> =
        (0..=5).map(|i| Vec3::Y * (height * 0.97 * i as f32 / 5.0 - if i == 0 { 0.5 } else { 0.0 })).collect();
    let radii: Vec<f32> = (0..=5).map(|i| 0.24 * (1.06 - i as f32 / 5.0)).collect();
    pad.tube(&path, &radii, 8);
    pad.material = palette.needles;
    let tiers = 17;
    let per_tier = (cards / tiers).max(5);
    for tier in 0..tiers {
        let part = (tier as f32 + 0.3) / tiers as f32;
        let foot = height * (0.12 + 0.86 * part);
        let reach = (height * 0.27 * (1.0 - part).powf(0.85)).max(0.5);
        let turn = rng.range(0.0, TAU);
        for branch in 0..per_tier {
            let angle = turn + (branch as f32 + rng.range(-0.25, 0.25)) / per_tier as f32 * TAU;
            let along = Quat::from_rotation_y(angle) * Vec3::Z;
            pad.color = rng.shade([0.058, 0.112, 0.046], 0.25).map(|channel| channel * (0.75 + 0.45 * part));
            let droop = rng.range(0.20, 0.42) - 0.5 * part * part;
            needle_branch(
                &mut pad,
                Vec3::Y * (foot + rng.range(-0.2, 0.2)),
                along,
                reach * rng.range(0.85, 1.12),
                droop,
            );
        }
    }
    pad.color = [0.06, 0.13, 0.05];
    for quarter in 0..3 {
        let along = Quat::from_rotation_y(quarter as f32 * PI / 1.5) * Vec3::Z;
        needle_branch(&mut pad, Vec3::Y * (height * 0.95), (along * 0.4 + Vec3::Y).normalize(), height * 0.07, 0.0);
    }
    pad
}

fn needle_branch(pad: &mut Sketch, foot: Vec3, along: Vec3, length: f32, droop: f32) {
    let across = Vec3::Y.cross(along).normalize_or(Vec3::X) * length * 0.34;
    let point = |part: f32, side: f32| {
        let sag = Vec3::Y * (-droop * length * part * part - 0.12 * length * side.abs());
        let position = foot + along * (length * part) + across * side + sag;
        let normal = (along * 0.55 + Vec3::Y * 0.7 + across.normalize_or(Vec3::X) * side * 0.5).normalize();
        (position, normal, Vec2::new(0.5 + 0.5 * side, 0.02 + 0.96 * part))
    };
    let mut rows = [[0u32; 3]; 3];
    for (row, indices) in rows.iter_mut().enumerate() {
        *indices = [-1.0, 0.0, 1.0].map(|side| {
            let (position, normal, uv) = point(row as f32 / 2.0, side);
            pad.vertex(position, normal, uv)
        });
    }
    for row in 0..2 {
        for side in 0..2 {
            pad.quad(rows[row][side], rows[row][side + 1], rows[row + 1][side + 1], rows[row + 1][side]);
        }
    }
}

/// Morph targets of a tree in the wind: displacements for a gust along x, one along z, and two of
/// the flutter of leaves, whose combinations give every phase of it.
pub(crate) fn sway(positions: &[Vec3]) -> [Vec<[f32; 3]>; 4] {
    let height = positions.iter().map(|point| point.y).fold(1.0, f32::max);
    let bend = |point: &Vec3| height * 0.07 * (point.y.max(0.0) / height).powf(1.8);
    let flutter = |point: &Vec3, phase: f32| {
        let loose = 0.028 * Vec2::new(point.x, point.z).length().min(4.0) * (point.y.max(0.0) / height);
        let wave = |k: f32| (point.dot(Vec3::new(1.7, 1.1, 1.4)) * k + phase).sin();
        [loose * wave(0.8), 1.4 * loose * wave(1.1), loose * wave(0.95)]
    };
    [
        positions.iter().map(|point| [bend(point), 0.0, 0.0]).collect(),
        positions.iter().map(|point| [0.0, 0.0, bend(point)]).collect(),
        positions.iter().map(|point| flutter(point, 0.0)).collect(),
        positions.iter().map(|point| flutter(point, FRAC_PI_2)).collect(),
    ]
}
