//! Smoke from sliding tyres: puffs that appear, grow, fade and disappear.
//!
//! Each wheel emits puffs at regular intervals while its tyre slides. The opacity of a puff depends
//! on its age only, so puffs have slots by age, whose vertex colours are fixed.

use std::f32::consts::TAU;

use glam::{Affine3A, Quat, Vec2, Vec3};
use kinetree::{EditError, Mesh, MeshId, Motion, Scene};
use kinetree_world::{Part, Surface};

use crate::car::{AXLES, HALF_TRACK};
use crate::driving::{Driving, LAP};
use crate::palette::Palette;
use crate::rng::Rng;
use crate::scene_builder::SceneBuilder;

/// The number of puffs that a wheel can emit in a lap.
const BIRTHS: i64 = 500;
/// The lifetime of a puff, in intervals between two puffs.
const SLOTS: usize = 34;
/// The number of crossing quads of a puff.
const CARDS: usize = 3;
/// Wheels that smoke: both rear wheels of both cars.
const WHEELS: usize = 4;

/// The smoke.
pub(crate) struct Smoke {
    mesh: MeshId,
    seed: u64,
}

/// The vertices and triangles at one time.
#[derive(Default)]
struct Puffs {
    positions: Vec<[f32; 3]>,
    triangles: Vec<[u32; 3]>,
}

/// Adds the mesh of the smoke, without triangles.
pub(crate) fn prepare(builder: &mut SceneBuilder, seed: u64, palette: &Palette) -> Result<Smoke, EditError> {
    let (mut uvs, mut colors) = (Vec::new(), Vec::new());
    for _ in 0..WHEELS {
        for slot in 0..SLOTS {
            let age = (slot as f32 + 0.5) / SLOTS as f32;
            let density = (age * 9.0).min(1.0) * (1.0 - age).powf(1.4);
            for _ in 0..CARDS {
                uvs.extend([[0.0, 1.0], [1.0, 1.0], [1.0, 0.0], [0.0, 0.0]]);
                colors.extend([[1.0, 1.0, 1.0, density]; 4]);
            }
        }
    }
    let surface = Surface { parts: vec![Part { first_triangle: 0, material: palette.smoke }], uvs, colors };
    let prop = builder.with_surface(Mesh::empty(), surface, Motion::Dynamic)?;
    builder.put_in_world(prop, &Affine3A::IDENTITY)?;
    Ok(Smoke { mesh: prop.mesh, seed })
}

impl Smoke {
    /// Sets the triangles of a time.
    pub(crate) fn go_to(&self, scene: &mut Scene, driving: &Driving, seconds: f64) -> Result<(), EditError> {
        let puffs = self.puffs(driving, seconds);
        scene.set_triangles(self.mesh, &puffs.positions, &puffs.triangles)
    }

    fn puffs(&self, driving: &Driving, seconds: f64) -> Puffs {
        let between = LAP / BIRTHS as f64;
        let newest = (seconds / between).floor();
        let mut puffs = Puffs::default();
        for wheel in 0..WHEELS {
            for slot in 0..SLOTS {
                let birth = newest as i64 - slot as i64;
                let age = seconds - birth as f64 * between;
                self.puff(&mut puffs, driving, wheel, birth, age as f32, (SLOTS as f64 * between) as f32);
            }
        }
        if puffs.triangles.is_empty() { Puffs::default() } else { puffs }
    }

    /// Adds the vertices of a puff, and its triangles if it is visible.
    fn puff(&self, puffs: &mut Puffs, driving: &Driving, wheel: usize, birth: i64, age: f32, life: f32) {
        let (car, side) = (wheel / 2, if wheel % 2 == 0 { 1.0 } else { -1.0 });
        let born = driving.moment(car, birth as f64 * LAP / BIRTHS as f64);
        let first = puffs.positions.len() as u32;
        if born.slide <= 0.0 || age >= life {
            puffs.positions.extend([born.world_from_car.translation.to_array(); 4 * CARDS]);
            return;
        }
        let mut rng = Rng::new(self.seed ^ 50, (birth.rem_euclid(BIRTHS) as u64) << 3 | wheel as u64);
        let contact = Vec3::new(side * HALF_TRACK, 0.12, AXLES[0] - 0.25);
        let start = born.world_from_car.transform_point3(contact);
        // Drag slows the puff down, heat lifts it, the wind carries it along +x.
        let carried = born.velocity * 0.22 * (1.0 - (-2.5 * age).exp()) / 2.5;
        let stray = Vec3::new(rng.range(-0.5, 0.5), rng.range(0.25, 0.85), rng.range(-0.5, 0.5)) * age;
        let wind = Vec3::X * (0.5 * age * age);
        let radius = (0.20 + 0.95 * (age / life).sqrt()) * (0.45 + 0.55 * born.slide) * rng.range(0.8, 1.25);
        let center = start + carried + stray + wind + Vec3::Y * (radius * 0.55);
        let turn = Quat::from_rotation_y(rng.range(0.0, TAU) + age * rng.range(-1.0, 1.0))
            * Quat::from_rotation_x(rng.range(-0.5, 0.5));
        for card in 0..CARDS {
            let facing =
                turn * [Quat::IDENTITY, Quat::from_rotation_y(TAU / 4.0), Quat::from_rotation_x(TAU / 4.0)][card];
            let corner = |corner: Vec2| (center + facing * (corner * radius).extend(0.0)).to_array();
            let square = [Vec2::new(-1.0, -1.0), Vec2::new(1.0, -1.0), Vec2::new(1.0, 1.0), Vec2::new(-1.0, 1.0)];
            let at = first + 4 * card as u32;
            puffs.positions.extend(square.map(corner));
            puffs.triangles.extend([[at, at + 1, at + 2], [at, at + 2, at + 3]]);
        }
    }
}
