//! The chequered flag: a waving cloth on a pole.

use std::f32::consts::TAU;

use glam::{Affine3A, Vec2, Vec3};
use kinetree::{EditError, MeshId, Motion, Scene};

use crate::driving::LAP;
use crate::meshing::Sketch;
use crate::palette::Palette;
use crate::scene_builder::SceneBuilder;

/// Quads along the cloth and down it.
const GRID: [u32; 2] = [36, 18];
/// Length and height, metres.
const SIZE: Vec2 = Vec2::new(3.6, 2.2);
/// Height of the pole, metres.
const POLE: f32 = 7.6;

/// A flag whose cloth moves.
pub(crate) struct Flag {
    mesh: MeshId,
    phase: f32,
}

/// Adds a flag whose pole stands at a position.
pub(crate) fn raise(builder: &mut SceneBuilder, foot: Vec3, phase: f32, palette: &Palette) -> Result<Flag, EditError> {
    let mut pole = Sketch::new(palette.paint);
    pole.color = [0.70, 0.70, 0.70];
    pole.lathe(&[(0.07, -0.5), (0.05, POLE), (0.05, POLE), (0.0, POLE)], 10, &Affine3A::IDENTITY);
    pole.color = [0.75, 0.52, 0.10];
    pole.ball(Vec3::Y * POLE, Vec3::splat(0.12), 8, 12);
    let at = Affine3A::from_translation(foot);
    let pole = builder.prop(pole, Motion::Static)?;
    builder.put_in_world(pole, &at)?;
    let cloth = builder.prop(cloth(palette.chequer, 0.0, phase), Motion::Deforming)?;
    builder.put_in_world(cloth, &at)?;
    Ok(Flag { mesh: cloth.mesh, phase })
}

impl Flag {
    /// Moves the cloth.
    pub(crate) fn go_to(&self, scene: &mut Scene, seconds: f64) -> Result<(), EditError> {
        let cloth = cloth(0, seconds, self.phase);
        let plain = |vectors: &[Vec3]| -> Vec<[f32; 3]> { vectors.iter().map(|vector| vector.to_array()).collect() };
        scene.set_positions(self.mesh, &plain(cloth.positions()))?;
        scene.set_normals(self.mesh, &plain(cloth.normals()))
    }
}

/// The cloth at a time. It is attached to the pole at x = 0 and streams along +x.
fn cloth(material: u32, seconds: f64, phase: f32) -> Sketch {
    let turns = (seconds / LAP).rem_euclid(1.0) as f32 * TAU;
    let mut pad = Sketch::new(material);
    pad.sheet(GRID[1], GRID[0], |row, column| {
        // A wave travels along the cloth, with growing amplitude; another runs diagonally.
        let first = (column * 9.0 - turns * 22.0 + phase + row).sin();
        let second = (column * 16.0 + row * 4.0 - turns * 37.0 + 1.7 * phase).sin();
        let depth = column * (0.34 * first + 0.10 * second);
        let sag = 0.22 * column * column + 0.06 * column * (turns * 9.0 + phase).sin();
        let position = Vec3::new(0.06 + SIZE.x * column * 0.93, POLE - 0.25 - SIZE.y * (1.0 - row) - sag, depth);
        (position, Vec2::new(column, (1.0 - row) * SIZE.y / SIZE.x))
    });
    pad
}
