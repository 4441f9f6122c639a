//! Parts on a car's shell: wing, splitter, skirts, mirrors, diffuser, exhausts, wheel wells.

use std::f32::consts::{FRAC_PI_2, TAU};

use glam::{Affine3A, Quat, Vec2, Vec3};

use crate::car::{AXLES, BLACK, HALF_TRACK, HUB, half_width};
use crate::meshing::Sketch;
use crate::palette::Palette;

/// Adds all of it; `accent` is the colour of wing plates and mirrors.
pub(crate) fn add(pad: &mut Sketch, accent: [f32; 3], palette: &Palette) {
    wing(pad, accent, palette);
    wells(pad, palette);
    floor(pad, palette);
    for side in [-1.0, 1.0] {
        pad.set_material(palette.paint, accent);
        pad.ball(Vec3::new(0.97 * side, 0.98, 0.50), Vec3::new(0.085, 0.055, 0.07), 10, 16);
        pad.set_material(palette.paint, BLACK);
        pad.beam(Vec3::new(0.80 * side, 0.90, 0.50), Vec3::new(0.93 * side, 0.96, 0.50), 0.05, 0.02);
        pad.set_material(palette.paint, [0.30, 0.29, 0.28]);
        let pipe =
            Affine3A::from_rotation_translation(Quat::from_rotation_x(-FRAC_PI_2), Vec3::new(0.42 * side, 0.33, -2.16));
        pad.lathe(
            &[(0.045, -0.1), (0.045, 0.12), (0.045, 0.12), (0.036, 0.12), (0.036, 0.12), (0.036, 0.02), (0.0, 0.02)],
            16,
            &pipe,
        );
    }
}

/// The profile of the wing for a chord of one metre along z.
fn airfoil(around: f32) -> Vec2 {
    let along = 0.5 + 0.5 * (around * TAU).cos();
    let thickness = 0.5
        * 0.14
        * (2.97 * along.sqrt() - 1.26 * along - 3.52 * along * along + 2.84 * along.powi(3) - 1.04 * along.powi(4));
    let camber = -0.22 * along * (1.0 - along);
    Vec2::new(along, camber + if around < 0.5 { thickness } else { -thickness })
}

fn wing(pad: &mut Sketch, accent: [f32; 3], palette: &Palette) {
    let (span, chord, tilt) = (0.86, 0.36, 0.20f32);
    let place = |around: f32| {
        let profile = airfoil(around) * chord;
        let turned = Vec2::from_angle(-tilt).rotate(Vec2::new(-profile.x, profile.y));
        Vec2::new(turned.x - 1.93, turned.y + 1.215)
    };
    pad.set_material(palette.paint, [0.03, 0.03, 0.034]);
    pad.sheet(1, 40, |row, column| {
        let profile = place(1.0 - column);
        (Vec3::new(span * (2.0 * row - 1.0), profile.y, profile.x), Vec2::ZERO)
    });
    for side in [-1.0, 1.0] {
        pad.set_material(palette.paint, accent);
        let x = span * side;
        pad.cuboid(Vec3::new(x - 0.012, 1.06, -2.32), Vec3::new(x + 0.012, 1.30, -1.90), &Affine3A::IDENTITY);
        pad.set_material(palette.paint, BLACK);
        pad.beam(Vec3::new(0.42 * side, 0.88, -1.92), Vec3::new(0.42 * side, 1.19, -2.06), 0.025, 0.14);
    }
}

/// Dark half drums behind the wheels.
fn wells(pad: &mut Sketch, palette: &Palette) {
    pad.set_material(palette.paint, BLACK);
    for axle in AXLES {
        for side in [-1.0f32, 1.0] {
            let turn = Quat::from_rotation_z(-side * FRAC_PI_2);
            let drum = Affine3A::from_rotation_translation(turn, Vec3::new(0.0, HUB, axle));
            // Its open end lies just inside the arch.
            pad.lathe(&[(0.0, 0.50), (0.40, 0.50), (0.40, 0.50), (0.40, HALF_TRACK + 0.07)], 28, &drum);
        }
    }
}

fn floor(pad: &mut Sketch, palette: &Palette) {
    pad.set_material(palette.paint, BLACK);
    let here = Affine3A::IDENTITY;
    // Between the wheel wells the floor is narrow.
    pad.cuboid(Vec3::new(-0.48, 0.12, -2.05), Vec3::new(0.48, 0.16, 2.15), &here);
    pad.cuboid(Vec3::new(-0.90, 0.10, -0.92), Vec3::new(0.90, 0.16, 0.92), &here);
    // The splitter follows the round nose.
    let splitter = |across: f32| {
        let z = 1.78 + 0.62 * (1.0 - across.abs().powi(4) * 0.45);
        Vec3::new(across * 0.93, 0.0, z)
    };
    for (height, flip) in [(0.115, false), (0.085, true)] {
        pad.sheet(1, 24, |row, column| {
            let across = if flip { 2.0 * column - 1.0 } else { 1.0 - 2.0 * column };
            let edge = splitter(across);
            (Vec3::new(edge.x, height, if row < 0.5 { edge.z } else { 1.70 }), Vec2::ZERO)
        });
    }
    pad.sheet(1, 24, |row, column| {
        let edge = splitter(2.0 * column - 1.0);
        (Vec3::new(edge.x, 0.085 + 0.03 * row, edge.z), Vec2::ZERO)
    });
    for side in [-1.0, 1.0] {
        let out = half_width(0.0) * side;
        pad.beam(Vec3::new(out, 0.13, -0.93), Vec3::new(out, 0.13, 0.93), 0.10, 0.05);
    }
    for fin in 0..6 {
        let x = 0.24 * (fin as f32 - 2.5);
        pad.cuboid(Vec3::new(x - 0.01, 0.12, -2.28), Vec3::new(x + 0.01, 0.33, -1.85), &here);
    }
}
