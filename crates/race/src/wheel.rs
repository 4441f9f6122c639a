//! One wheel, shared by all: tyre, rim, spokes, brake disc.
//!
//! Wheel space: the axle is the x axis, the side that is seen from outside the car is at +x.

use std::f32::consts::{FRAC_PI_2, TAU};

use glam::{Affine3A, Quat, Vec3};

use crate::car::HUB;
use crate::meshing::Sketch;
use crate::palette::Palette;

/// The wheel.
pub(crate) fn wheel(palette: &Palette) -> Sketch {
    let mut pad = Sketch::new(palette.paint);
    // The lathe turns around y.
    let axle = Affine3A::from_quat(Quat::from_rotation_z(-FRAC_PI_2));
    pad.color = [0.016, 0.016, 0.017];
    let (shoulder, tread) = (HUB - 0.010, HUB);
    pad.lathe(
        &[
            (0.215, -0.11),
            (0.232, -0.128),
            (0.285, -0.134),
            (shoulder, -0.115),
            (tread, -0.075),
            (tread, 0.0),
            (tread, 0.075),
            (shoulder, 0.115),
            (0.298, 0.131),
            (0.298, 0.131),
            (0.262, 0.135),
            (0.232, 0.128),
            (0.215, 0.11),
        ],
        48,
        &axle,
    );
    // A ring of colour on the side wall.
    pad.color = [0.75, 0.55, 0.05];
    pad.lathe(&[(0.292, 0.1335), (0.276, 0.1355)], 48, &axle);
    pad.color = [0.40, 0.40, 0.42];
    pad.lathe(&[(0.217, 0.112), (0.205, 0.110), (0.205, 0.110), (0.196, 0.06), (0.190, -0.11)], 40, &axle);
    for spoke in 0..5 {
        for twin in [-0.15f32, 0.15] {
            let direction = |angle: f32| Vec3::new(0.0, angle.cos(), angle.sin());
            let angle = spoke as f32 / 5.0 * TAU;
            let (inner, outer) = (direction(angle + 0.5 * twin), direction(angle + twin));
            pad.beam(inner * 0.04 + Vec3::X * 0.085, outer * 0.202 + Vec3::X * 0.095, 0.026, 0.022);
        }
    }
    pad.lathe(&[(0.055, 0.06), (0.055, 0.098), (0.055, 0.098), (0.03, 0.112), (0.0, 0.114)], 20, &axle);
    pad.color = [0.10, 0.095, 0.09];
    pad.lathe(&[(0.175, 0.0), (0.175, 0.02), (0.175, 0.02), (0.05, 0.02)], 32, &axle);
    pad.color = [0.02, 0.02, 0.02];
    pad.lathe(&[(0.20, -0.05), (0.0, -0.05)], 32, &axle);
    pad
}
