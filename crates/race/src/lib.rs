//! The built-in race of kinetree: an animated scene that the program makes from a seed, without a
//! file.
//!
//! Two cars race around a banked circuit on a late afternoon; trees move in the wind, a flag waves,
//! tyres smoke, and some thousand spectators watch. Every kind of [`Motion`] is there. After
//! [`duration`](kinetree_world::Animation::duration) seconds it repeats.
//!
//! ```
//! let mut race = kinetree_race::world(1);
//! let frame = race.frame(2.5)?;
//! assert!(frame.snapshot.instances().len() > 1000);
//! # Ok::<(), kinetree::EditError>(())
//! ```
//!
//! # The map
//!
//! | | |
//! |---|---|
//! | the circuit and the terrain | `track`, `ground` |
//! | buildings | `road`, `roadside`, `stands` |
//! | trees and spectators | `tree`, `forest`, `crowd` |
//! | the cars and their motion | `car`, `cabin`, `trim`, `wheel`; `driving`, `cars` |
//! | other animation | `flag`, `smoke`; `animation` |
//! | cameras | `cameras` |
//! | making meshes | `meshing`, `shapes`, `loft`, `curve` |
//! | making images and materials | `canvas`, `font`, `textures`, `palette` |
//! | random numbers, and building the scene | `rng`, `scene_builder` |

mod animation;
mod cabin;
mod cameras;
mod canvas;
mod car;
mod cars;
mod crowd;
mod curve;
mod driving;
mod flag;
mod font;
mod forest;
mod ground;
mod loft;
mod meshing;
mod palette;
mod rng;
mod road;
mod roadside;
mod shapes;
mod smoke;
mod scene_builder;
mod stands;
mod textures;
mod track;
mod tree;
mod trim;
mod wheel;

use std::sync::Arc;

use glam::{Affine3A, Vec3};
use kinetree::{Affine, EditError, Motion, Scene};
use kinetree_world::{Light, LightSource, MaterialBindings, MaterialSet, Sky, World};

use animation::Race;
use cameras::Panning;
use driving::Driving;
use ground::Ground;
use palette::Palette;
use scene_builder::SceneBuilder;

/// The race. The seed decides about hills, trees, spectators and wind; the circuit is always the
/// same.
///
/// The first camera, "track", shows both cars in the banked corner at time 0; "chase", "front" and
/// "wheel" are attached to them; the others are "aerial", "grandstand", "pit" and "hairpin".
pub fn world(seed: u64) -> World {
    build(seed).expect("the race's meshes are sound, and it edits with handles of its own")
}

fn build(seed: u64) -> Result<World, EditError> {
    let mut material_set = MaterialSet::default();
    let palette = Palette::new(seed, &mut material_set);
    let material_bindings = MaterialBindings::default();
    let mut builder = SceneBuilder { scene: Scene::new(), material_set, material_bindings };
    let driving = Driving::new();
    let track = driving.track();
    let ground = Ground::new(seed, track);

    let here = Affine3A::IDENTITY;
    let land = builder.prop(ground.terrain(&palette), Motion::Static)?;
    builder.put_in_world(land, &here)?;
    let asphalt = builder.prop(road::road(seed, track, &ground, &palette), Motion::Static)?;
    builder.put_in_world(asphalt, &here)?;
    roadside::build(&mut builder, track, &ground, &palette)?;
    let grandstands = stands::placements(track, &ground);
    let stand = builder.prop(stands::stand(&palette), Motion::Static)?;
    for placement in &grandstands {
        builder.put_in_world(stand, placement)?;
    }

    let jumpers = crowd::seat(&mut builder, seed, &grandstands, &palette)?;
    let trees = forest::plant(&mut builder, seed, &ground, &grandstands, &palette)?;
    let mut flags = Vec::new();
    for (index, &[x, z]) in FLAGS.iter().enumerate() {
        flags.push(flag::raise(&mut builder, ground.below(x, z), 2.1 * index as f32, &palette)?);
    }
    let smoke = smoke::prepare(&mut builder, seed, &palette)?;
    let cars = cars::build(&mut builder, &palette)?;

    let panning = Panning::new(builder.scene.add_node(builder.scene.root(), Affine::IDENTITY)?, &ground);
    let cameras = cameras::cameras(&ground, [cars[0].node, cars[1].node], &panning);
    let mut world = World::new(builder.scene);
    world.material_set = Arc::new(builder.material_set);
    world.material_bindings = builder.material_bindings;
    world.lights = vec![LightSource { node: None, light: sun() }];
    world.sky = SKY;
    world.cameras = cameras;
    world.animation = Box::new(Race { driving, cars, trees, flags, smoke, jumpers, panning });
    Ok(world)
}

/// The positions of the flags: x, z.
const FLAGS: [[f32; 2]; 3] = [[189.0, 6.0], [5.0, 62.0], [38.0, 62.0]];

const SKY: Sky = Sky::Gradient { zenith: [0.06, 0.17, 0.52], horizon: [0.47, 0.60, 0.80], ground: [0.20, 0.19, 0.14] };

/// A low sun in the west, an hour before sunset.
fn sun() -> Light {
    let direction = Vec3::new(0.80, -0.40, 0.45).normalize().to_array();
    Light::Sun { direction, irradiance: [6.0, 4.15, 2.45], angle: 0.02 }
}
