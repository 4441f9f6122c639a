//! The roadside: guard rails, tyre walls, boards, the gantry over the start, lamp masts.

use glam::{Affine3A, Quat, Vec2, Vec3};
use kinetree::{EditError, Motion};

use crate::ground::{Ground, VERGE};
use crate::meshing::Sketch;
use crate::palette::Palette;
use crate::road::{SHARP, start_distance};
use crate::scene_builder::SceneBuilder;
use crate::track::{HALF_WIDTH, Track};

/// From the middle of the road to the rail.
const RAIL: f32 = VERGE + 0.6;
/// From the middle of the road to the tyres.
const TYRES: f32 = VERGE - 0.7;

/// Adds all of it.
pub(crate) fn build(
    builder: &mut SceneBuilder,
    track: &Track,
    ground: &Ground,
    palette: &Palette,
) -> Result<(), EditError> {
    let mut pad = Sketch::new(palette.paint);
    for side in [-1.0, 1.0] {
        rail(&mut pad, side, track, ground, palette);
        boards(&mut pad, side, track, ground, palette);
    }
    gantry(&mut pad, track, ground, palette);
    let fixed = builder.prop(pad, Motion::Static)?;
    builder.put_in_world(fixed, &Affine3A::IDENTITY)?;
    tyre_walls(builder, track, ground, palette)
}

/// A point of the ground beside the road; `None` where another stretch of road is nearer.
fn beside(track: &Track, ground: &Ground, distance: f32, offset: f32) -> Option<Vec3> {
    let station = track.at(distance);
    let point = station.middle + station.left * offset;
    let (height, nearest) = ground.height(point.x, point.z);
    (nearest > offset.abs() - 0.7).then_some(Vec3::new(point.x, height, point.z))
}

/// The two waves of a guard rail's section: how far towards the road, and how high.
const WAVES: [(f32, f32); 7] =
    [(0.0, 0.42), (0.08, 0.48), (0.08, 0.56), (0.0, 0.63), (0.08, 0.70), (0.08, 0.78), (0.0, 0.84)];

fn rail(pad: &mut Sketch, side: f32, track: &Track, ground: &Ground, palette: &Palette) {
    pad.set_material(palette.paint, [0.50, 0.51, 0.53]);
    let count = (track.length() / 2.0) as usize;
    let post = |i: usize| beside(track, ground, track.length() * i as f32 / count as f32, side * RAIL);
    for i in 0..count {
        let (Some(from), Some(to)) = (post(i), post(i + 1)) else { continue };
        let away = (to - from).cross(Vec3::Y).normalize_or(Vec3::X) * side;
        pad.beam(from + away * 0.1 - Vec3::Y * 0.5, from + away * 0.1 + Vec3::Y * 0.88, 0.10, 0.10);
        let first = pad.vertex_count();
        for (depth, height) in WAVES {
            for end in [from, to] {
                pad.vertex(end - away * depth + Vec3::Y * height, Vec3::Y, Vec2::ZERO);
            }
        }
        for wave in 0..WAVES.len() as u32 - 1 {
            let at = first + 2 * wave;
            if side > 0.0 { pad.quad(at, at + 1, at + 3, at + 2) } else { pad.quad(at + 1, at, at + 2, at + 3) }
        }
        pad.smooth(first, &[]);
    }
}

/// Advertising boards behind the rail: all along the outside of sharp corners, and here and there.
fn boards(pad: &mut Sketch, side: f32, track: &Track, ground: &Ground, palette: &Palette) {
    let (width, height) = (6.0, 1.25);
    let count = (track.length() / (width + 0.5)) as usize;
    for i in 0..count {
        let middle = track.length() * (i as f32 + 0.5) / count as f32;
        let outside = -side * track.at(middle).curvature;
        if outside < 0.006 && i % 9 > 2 {
            continue;
        }
        let reach = RAIL + 1.1;
        let ends = [-0.5, 0.5].map(|end| beside(track, ground, middle + end * width, side * reach));
        let [Some(from), Some(to)] = ends else { continue };
        let low = from.y.max(to.y) + 0.95;
        // From the left end to the right one, as seen from the road.
        let [a, b] = if side > 0.0 { [from, to] } else { [to, from] }.map(|end| Vec3::new(end.x, low, end.z));
        let away = Vec3::Y.cross((b - a).normalize());
        pad.set_material(palette.boards[i % palette.boards.len()], [1.0; 3]);
        let up = Vec3::Y * height;
        pad.panel([a, b, b + up, a + up]);
        pad.set_material(palette.paint, [0.20, 0.20, 0.22]);
        let back = away * 0.06;
        pad.panel([b + back, a + back, a + back + up, b + back + up]);
        for end in [a.lerp(b, 0.1), a.lerp(b, 0.9)] {
            pad.beam(end + back * 2.0 - Vec3::Y * 2.2, end + back * 2.0 + up, 0.08, 0.08);
        }
    }
}

/// A truss over the start with lamps and a chequered banner on both faces.
fn gantry(pad: &mut Sketch, track: &Track, ground: &Ground, palette: &Palette) {
    let station = track.at(start_distance(track));
    let reach = HALF_WIDTH + 4.2;
    let [left, right] = [1.0, -1.0].map(|side| {
        let foot = station.middle + station.left * (side * reach);
        ground.below(foot.x, foot.z)
    });
    let top = Vec3::new(0.0, 6.4 + left.y.max(right.y), 0.0);
    let level = |foot: Vec3| Vec3::new(foot.x, top.y, foot.z);
    pad.set_material(palette.paint, [0.16, 0.17, 0.19]);
    for foot in [left, right] {
        for (along, across) in [(-0.4, -0.4), (0.4, -0.4), (0.4, 0.4), (-0.4, 0.4)] {
            let shift = station.forward * along + station.left * across;
            pad.beam(foot + shift - Vec3::Y, level(foot) + shift + Vec3::Y * 1.3, 0.12, 0.12);
        }
        for rung in 0..8 {
            let at = foot + Vec3::Y * (0.9 * rung as f32);
            let (a, b) = (station.forward * 0.4, station.left * 0.4);
            pad.beam(at + a + b, at - a + b + Vec3::Y * 0.9, 0.05, 0.05);
            pad.beam(at - a - b, at + a - b + Vec3::Y * 0.9, 0.05, 0.05);
        }
    }
    for along in [-0.4, 0.4] {
        for height in [0.0, 1.3] {
            let shift = station.forward * along + Vec3::Y * height;
            pad.beam(level(left) + shift, level(right) + shift, 0.12, 0.12);
        }
    }
    let up = Vec3::Y * 1.2;
    for (along, [a, b]) in [(-0.48, [left, right]), (0.48, [right, left])] {
        let (a, b) = (level(a) + station.forward * along, level(b) + station.forward * along);
        for piece in 0..7 {
            let [p, q] = [piece, piece + 1].map(|i| a.lerp(b, i as f32 / 7.0) + Vec3::Y * 0.08);
            let plain = piece % 2 == 1;
            pad.set_material(if plain { palette.boards[0] } else { palette.chequer }, [1.0; 3]);
            pad.panel([p, q, q + up, p + up]);
        }
    }
    pad.set_material(palette.start_lamp, [1.0; 3]);
    for lamp in 0..5 {
        let at = level(left).lerp(level(right), 0.4 + 0.05 * lamp as f32) - station.forward * 0.55 - Vec3::Y * 0.3;
        pad.ball(at, Vec3::splat(0.16), 8, 12);
    }
}

/// Stacks of tyres at the outside of sharp corners, three high, alternately red and white.
fn tyre_walls(builder: &mut SceneBuilder, track: &Track, ground: &Ground, palette: &Palette) -> Result<(), EditError> {
    let mut stacks = Vec::new();
    for color in [[0.62, 0.04, 0.035], [0.74, 0.73, 0.70]] {
        let (mesh, surface) = stack(color, palette).finish()?;
        stacks.push(match stacks.first() {
            None => builder.with_surface(mesh, surface, Motion::Static)?,
            Some(&crate::scene_builder::Prop { mesh, .. }) => builder.with_other_surface(mesh, surface),
        });
    }
    for side in [-1.0, 1.0] {
        let mut distance = 0.0;
        let mut count = 0;
        while distance < track.length() {
            let station = track.at(distance);
            // Steps are measured along the wall, not along the road.
            distance += 0.66 / (1.0 - station.curvature * side * TYRES).max(0.3);
            if -side * station.curvature < SHARP {
                continue;
            }
            let Some(foot) = beside(track, ground, distance, side * TYRES) else { continue };
            let turn = Quat::from_rotation_y(count as f32 * 2.4);
            builder.put_in_world(
                stacks[count / 5 % 2],
                &Affine3A::from_rotation_translation(turn, foot + Vec3::Y * 0.02),
            )?;
            count += 1;
        }
    }
    Ok(())
}

fn stack(color: [f32; 3], palette: &Palette) -> Sketch {
    let mut pad = Sketch::new(palette.paint);
    for tyre in 0..4 {
        pad.color = if tyre == 1 { [0.03, 0.03, 0.032] } else { color };
        let at = Affine3A::from_translation(Vec3::Y * (0.24 * tyre as f32));
        pad.lathe(&[(0.20, 0.03), (0.30, 0.0), (0.33, 0.06), (0.33, 0.17), (0.30, 0.23), (0.20, 0.20)], 14, &at);
    }
    pad
}
