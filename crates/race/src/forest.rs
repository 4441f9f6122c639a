//! The positions of the trees, and the motion of the nearby ones in the wind.

use std::f32::consts::TAU;

use glam::{Affine3A, Quat, Vec2, Vec3};
use kinetree::{EditError, MeshId, MorphTarget, Motion, Pose, Scene};

use crate::driving::LAP;
use crate::ground::Ground;
use crate::palette::Palette;
use crate::rng::{Rng, fractal};
use crate::scene_builder::SceneBuilder;
use crate::stands;
use crate::tree::{Species, sway, tree};

/// The number of trees that move.
const NEAR: usize = 36;
/// The largest number of trees that are too far away for their motion to be visible.
const FAR: usize = 2400;
/// Trees placed by hand for the cameras: x, z, species.
const CHOSEN: [(f32, f32, Species); 15] = [
    (192.0, 2.5, Species::Birch),
    (198.0, -15.0, Species::Poplar),
    (188.0, 50.5, Species::Birch),
    (196.0, -6.0, Species::Oak),
    (186.0, -24.0, Species::Birch),
    (203.0, -26.0, Species::Pine),
    (178.0, -44.0, Species::Oak),
    (139.0, 16.0, Species::Birch),
    (126.0, 24.0, Species::Oak),
    (150.0, 100.0, Species::Poplar),
    (178.0, 86.0, Species::Oak),
    (194.0, 72.0, Species::Birch),
    (112.0, -2.0, Species::Pine),
    (206.0, 8.0, Species::Poplar),
    (207.0, 46.0, Species::Oak),
];
/// Clearings without trees: x, z, radius.
const CLEARINGS: [(f32, f32, f32); 3] = [(150.0, -4.0, 21.0), (20.0, 60.0, 16.0), (-20.0, 100.0, 10.0)];

/// A tree that moves in the wind.
pub(crate) struct Swaying {
    mesh: MeshId,
    phase: [f32; 3],
    rhythm: [f32; 3],
    stiffness: f32,
}

/// Adds the trees, and returns those that move.
pub(crate) fn plant(
    builder: &mut SceneBuilder,
    seed: u64,
    ground: &Ground,
    grandstands: &[Affine3A],
    palette: &Palette,
) -> Result<Vec<Swaying>, EditError> {
    let mut rng = Rng::new(seed, 40);
    let site = Site { ground, grandstands };
    let mut near = Vec::new();
    let mut spots: Vec<(Vec3, Species)> = CHOSEN.iter().map(|&(x, z, species)| (ground.below(x, z), species)).collect();
    for _ in 0..20_000 {
        if spots.len() >= NEAR {
            break;
        }
        let (x, z) = (rng.range(-190.0, 230.0), rng.range(-110.0, 135.0));
        let Some((foot, distance)) = site.free(x, z) else { continue };
        let apart = spots.iter().all(|(other, _)| other.distance(foot) > 9.0);
        if apart && distance > 21.0 && distance < 38.0 {
            spots.push((foot, species_at(seed, x, z, &mut rng)));
        }
    }
    for &(foot, species) in &spots {
        near.push(bending(builder, species, foot, &mut rng, palette)?);
    }
    let mut kinds = Vec::new();
    for species in
        [Species::Oak, Species::Oak, Species::Poplar, Species::Birch, Species::Pine, Species::Pine, Species::Pine]
    {
        let cards = if species == Species::Pine { 170 } else { 260 };
        kinds.push((species, builder.prop(tree(species, cards, &mut rng, palette), Motion::Static)?));
    }
    let mut planted = 0;
    for _ in 0..200_000 {
        if planted >= FAR {
            break;
        }
        // Denser further in, so that the woods seem to begin behind the stands.
        let away =
            Vec2::from_angle(rng.range(0.0, TAU)) * rng.range(0.02f32, 1.0).sqrt() * 420.0 + Vec2::new(10.0, 0.0);
        let Some((foot, distance)) = site.free(away.x, away.y) else { continue };
        let thick = fractal(seed ^ 41, away.x / 60.0, away.y / 60.0, 3) + if distance > 70.0 { 0.30 } else { 0.02 };
        if distance < 27.0 || !rng.chance(2.2 * thick) || spots.iter().any(|(other, _)| other.distance(foot) < 5.0) {
            continue;
        }
        let wanted = species_at(seed, away.x, away.y, &mut rng);
        let like: Vec<_> = kinds.iter().filter(|(species, _)| *species == wanted).collect();
        let (_, prop) = like[rng.below(like.len())];
        builder.put_in_world(*prop, &upright(foot, rng.range(0.75, 1.25), &mut rng))?;
        planted += 1;
    }
    Ok(near)
}

/// Where trees may stand.
struct Site<'a> {
    ground: &'a Ground,
    grandstands: &'a [Affine3A],
}

impl Site<'_> {
    /// The ground at x and z and its distance from the road, if nothing else stands there.
    fn free(&self, x: f32, z: f32) -> Option<(Vec3, f32)> {
        let (height, distance) = self.ground.height(x, z);
        let point = Vec3::new(x, height, z);
        let open = CLEARINGS.iter().all(|&(cx, cz, radius)| Vec2::new(x - cx, z - cz).length() > radius);
        let outside = self.grandstands.iter().all(|world_from_stand| {
            let local = world_from_stand.inverse().transform_point3(point);
            // More room at the front, so that the trees do not hide the track from the spectators.
            local.x.abs() > 0.5 * stands::length() + 5.0 || local.z > stands::depth() + 6.0 || local.z < -24.0
        });
        (open && outside && distance > 17.0).then_some((point, distance))
    }
}

/// The species at a position: noise of low frequency, so that neighbours are mostly of one species.
fn species_at(seed: u64, x: f32, z: f32, rng: &mut Rng) -> Species {
    let kind = fractal(seed ^ 42, x / 85.0, z / 85.0, 2) + rng.range(-0.28, 0.28);
    match kind {
        kind if kind < -0.12 => Species::Pine,
        kind if kind < 0.24 => Species::Oak,
        kind if kind < 0.36 => Species::Birch,
        _ => Species::Poplar,
    }
}

fn upright(foot: Vec3, scale: f32, rng: &mut Rng) -> Affine3A {
    Affine3A::from_scale_rotation_translation(Vec3::splat(scale), Quat::from_rotation_y(rng.range(0.0, TAU)), foot)
}

fn bending(
    builder: &mut SceneBuilder,
    species: Species,
    foot: Vec3,
    rng: &mut Rng,
    palette: &Palette,
) -> Result<Swaying, EditError> {
    let cards = if species == Species::Pine { 200 } else { 620 };
    let sketch = tree(species, cards, rng, palette);
    let targets = sway(sketch.positions());
    let (mesh, surface) = sketch.finish()?;
    let targets = targets.map(|positions| MorphTarget { positions, normals: Vec::new() }).to_vec();
    let prop = builder.with_surface(mesh.with_morph_targets(targets)?, surface, Motion::Deforming)?;
    // Not rotated: the wind blows from the same direction for all of them.
    builder.put_in_world(
        prop,
        &Affine3A::from_scale_rotation_translation(Vec3::splat(rng.range(0.9, 1.15)), Quat::IDENTITY, foot),
    )?;
    Ok(Swaying {
        mesh: prop.mesh,
        phase: [rng.range(0.0, TAU), rng.range(0.0, TAU), rng.range(0.0, TAU)],
        // Whole numbers of periods per lap, so that the animation loops.
        rhythm: [4.0 + rng.below(3) as f32, 6.0 + rng.below(4) as f32, 19.0 + rng.below(9) as f32],
        stiffness: if species == Species::Pine { 0.55 } else { 1.0 },
    })
}

impl Swaying {
    /// Poses the tree for a time.
    pub(crate) fn go_to(&self, scene: &mut Scene, seconds: f64) -> Result<(), EditError> {
        let turns = (seconds / LAP).rem_euclid(1.0) as f32 * TAU;
        let wave = |i: usize| (turns * self.rhythm[i] + self.phase[i]).sin();
        // The same gusts for all trees, with a phase and stiffness of their own.
        let gust = 0.6 + 0.4 * (turns * 2.0 + 0.6).sin();
        let weights = [
            self.stiffness * gust * (0.55 + 0.65 * wave(0)),
            self.stiffness * gust * (0.15 + 0.50 * wave(1)),
            gust * wave(2),
            gust * (turns * self.rhythm[2] + self.phase[2]).cos(),
        ];
        scene.pose(self.mesh, &Pose { weights: &weights, joints: &[] })
    }
}
