//! The spectators: three meshes in six colours, instanced some thousand times; some of them jump.

use glam::{Affine3A, Quat, Vec3};
use kinetree::{EditError, InstanceId, Motion};

use crate::driving::LAP;
use crate::meshing::Sketch;
use crate::palette::Palette;
use crate::rng::Rng;
use crate::scene_builder::{Prop, SceneBuilder, affine};
use crate::stands::seats;

const SHIRTS: [[f32; 3]; 6] = [
    [0.66, 0.05, 0.04],
    [0.07, 0.17, 0.50],
    [0.76, 0.74, 0.70],
    [0.80, 0.50, 0.05],
    [0.07, 0.09, 0.10],
    [0.10, 0.38, 0.20],
];
const SKINS: [[f32; 3]; 3] = [[0.62, 0.38, 0.26], [0.42, 0.24, 0.15], [0.16, 0.085, 0.055]];

/// A spectator who jumps.
pub(crate) struct Jumper {
    instance: InstanceId,
    world_from_seat: Affine3A,
    phase: f32,
    hops: f32,
}

impl Jumper {
    /// The placement at a time.
    pub(crate) fn placement(&self, seconds: f64) -> Affine3A {
        let turns = (seconds / LAP * f64::from(self.hops)).rem_euclid(1.0) as f32;
        let wave = ((turns + self.phase) * std::f32::consts::TAU).sin();
        self.world_from_seat * Affine3A::from_translation(Vec3::Y * (0.22 * wave.max(0.0)))
    }

    /// The instance that is moved.
    pub(crate) fn instance(&self) -> InstanceId {
        self.instance
    }
}

/// Fills the stands, and returns the spectators who jump.
pub(crate) fn seat(
    builder: &mut SceneBuilder,
    seed: u64,
    stands: &[Affine3A],
    palette: &Palette,
) -> Result<Vec<Jumper>, EditError> {
    let mut rng = Rng::new(seed, 30);
    let mut people: Vec<Vec<Prop>> = Vec::new();
    for pose in [Pose::Sitting, Pose::Standing, Pose::Cheering] {
        let mut wardrobe = Vec::new();
        for (index, &shirt) in SHIRTS.iter().enumerate() {
            let (mesh, surface) = person(pose, shirt, SKINS[index % SKINS.len()], palette).finish()?;
            // All colours share one mesh.
            wardrobe.push(match wardrobe.first() {
                None => builder.with_surface(mesh, surface, Motion::Rigid)?,
                Some(&Prop { mesh, .. }) => builder.with_other_surface(mesh, surface),
            });
        }
        people.push(wardrobe);
    }
    let mut jumpers = Vec::new();
    for world_from_stand in stands {
        for seat in seats() {
            if rng.chance(0.22) {
                continue;
            }
            let mood = rng.unit();
            let pose = if mood < 0.62 {
                0
            } else if mood < 0.84 {
                1
            } else {
                2
            };
            let turn = Quat::from_rotation_y(rng.range(-0.35, 0.35));
            let scale = Vec3::splat(rng.range(0.92, 1.08));
            let spot = seat + Vec3::new(rng.range(-0.05, 0.05), 0.0, 0.0);
            let placement = *world_from_stand * Affine3A::from_scale_rotation_translation(scale, turn, spot);
            let prop = people[pose][rng.below(SHIRTS.len())];
            let instance = builder.put_in_world(prop, &placement)?;
            if pose == 2 && rng.chance(0.6) {
                let hops = 24.0 + rng.below(14) as f32;
                jumpers.push(Jumper { instance, world_from_seat: placement, phase: rng.unit(), hops });
            }
        }
    }
    Ok(jumpers)
}

/// Moves the spectators who jump.
pub(crate) fn cheer(scene: &mut kinetree::Scene, jumpers: &[Jumper], seconds: f64) -> Result<(), EditError> {
    jumpers.iter().try_for_each(|jumper| scene.place(jumper.instance(), affine(&jumper.placement(seconds))))
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Pose {
    Sitting,
    Standing,
    Cheering,
}

/// A spectator at a seat whose front edge is the origin, facing -z.
fn person(pose: Pose, shirt: [f32; 3], skin: [f32; 3], palette: &Palette) -> Sketch {
    let mut pad = Sketch::new(palette.paint);
    let (hips, z) = if pose == Pose::Sitting { (0.45, 0.22) } else { (0.86, -0.12) };
    let point = |x: f32, y: f32, forward: f32| Vec3::new(x, y, z - forward);
    pad.color = [0.045, 0.055, 0.09];
    for side in [-1.0, 1.0] {
        let x = 0.09 * side;
        let knee = if pose == Pose::Sitting { point(x, hips + 0.02, 0.40) } else { point(x, 0.45, 0.03) };
        let foot = point(x * 1.2, 0.0, if pose == Pose::Sitting { 0.42 } else { 0.0 });
        pad.tube(&[point(x, hips, 0.0), knee, foot], &[0.085, 0.07, 0.05], 5);
    }
    pad.color = shirt;
    let torso = Affine3A::from_translation(point(0.0, hips - 0.06, 0.0));
    let girth = Affine3A::from_scale(Vec3::new(1.0, 1.0, 0.68));
    pad.lathe(&[(0.14, 0.0), (0.165, 0.12), (0.195, 0.42), (0.17, 0.54), (0.06, 0.61)], 8, &(torso * girth));
    let shoulder = hips + 0.43;
    for side in [-1.0, 1.0] {
        let (elbow, hand) = match pose {
            Pose::Sitting => (point(0.26 * side, shoulder - 0.24, 0.06), point(0.13 * side, hips + 0.10, 0.28)),
            Pose::Standing => (point(0.25 * side, shoulder - 0.26, 0.0), point(0.12 * side, shoulder - 0.14, 0.22)),
            Pose::Cheering => (point(0.31 * side, shoulder + 0.16, 0.04), point(0.24 * side, shoulder + 0.46, 0.10)),
        };
        pad.tube(&[point(0.18 * side, shoulder, 0.0), elbow, hand], &[0.06, 0.05, 0.04], 5);
    }
    pad.color = skin;
    pad.ball(point(0.0, hips + 0.68, 0.01), Vec3::new(0.095, 0.125, 0.11), 6, 8);
    pad.color = shirt.map(|channel| 0.03 + 0.25 * channel);
    pad.ball(point(0.0, hips + 0.73, -0.02), Vec3::new(0.105, 0.09, 0.115), 4, 8);
    pad
}
