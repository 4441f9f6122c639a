//! What is traced: scenes that the program makes, and files.

use std::path::Path;

use glam::Vec3;
use kinetree_render::default_camera;
use kinetree_world::World;
use serde::Deserialize;

use super::bench_scene::BenchScene;
use super::camera::PinholeCamera;
use super::{diagonals, pile, terrain};
use crate::failure::Failure;
use crate::soup::Soup;

/// Which scene a case is about.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
pub(crate) enum SceneChoice {
    /// The built-in race, flattened, at a moment in seconds.
    Race { seed: u64, time: f64 },
    /// Long thin triangles at random angles: boxes far larger than what is in them.
    Diagonals { seed: u64, triangles: usize },
    /// Hills, and spheres strewn over them. About as many triangles as asked for.
    Terrain { seed: u64, triangles: usize },
    /// Spheres in each other's way. About as many triangles as asked for.
    Pile { seed: u64, triangles: usize },
    /// A glTF file, flattened, at a moment in seconds.
    File { path: std::path::PathBuf, time: f64 },
}

impl SceneChoice {
    /// Makes or loads the scene.
    ///
    /// # Errors
    /// A file that cannot be loaded, or a scene without triangles.
    pub(crate) fn open(&self) -> Result<BenchScene, Failure> {
        let scene = match self {
            Self::Race { seed, time } => of_world(kinetree_race::world(*seed), *time)?,
            Self::Diagonals { seed, triangles } => {
                BenchScene::with_default_camera(diagonals::diagonals(*seed, *triangles))
            }
            Self::Terrain { seed, triangles } => terrain::terrain(*seed, *triangles),
            Self::Pile { seed, triangles } => BenchScene::with_default_camera(pile::pile(*seed, *triangles)),
            Self::File { path, time } => of_world(load(path)?, *time)?,
        };
        if scene.soup.len() == 0 {
            return Err("the scene has no triangles".into());
        }
        Ok(scene)
    }
}

fn load(path: &Path) -> Result<World, Failure> {
    Ok(kinetree_gltf::load(path)?.world)
}

/// A world at a moment, seen by its first camera, or by one that shows most of it when it has none.
fn of_world(mut world: World, time: f64) -> Result<BenchScene, Failure> {
    let frame = world.frame(time)?;
    let soup = Soup::flatten(&frame.view);
    let camera = match world.cameras.first().cloned() {
        Some(source) => world.camera(&source)?,
        None => default_camera(&frame, 1.0),
    };
    let position = Vec3::from(camera.position());
    let forward = -Vec3::from(camera.world_from_camera.z_axis);
    if !(position.is_finite() && forward.is_finite() && camera.fov_y.is_finite()) {
        return Ok(BenchScene::with_default_camera(soup));
    }
    let half = (camera.fov_y.clamp(0.05, 2.8) * 0.5).tan();
    Ok(BenchScene { camera: PinholeCamera::look_at(position, position + forward, half), soup })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn made_scenes_are_the_same_every_time_and_about_as_large_as_asked_for() {
        let choices = [
            SceneChoice::Diagonals { seed: 3, triangles: 1000 },
            SceneChoice::Terrain { seed: 3, triangles: 20_000 },
            SceneChoice::Pile { seed: 3, triangles: 20_000 },
        ];
        for choice in choices {
            let (one, other) = (choice.open().unwrap(), choice.open().unwrap());
            assert_eq!(one.soup.positions, other.soup.positions, "{choice:?}");
            assert_eq!(one.soup.triangles, other.soup.triangles, "{choice:?}");
            assert_eq!(one.soup.len(), one.soup.sources.len());
            let asked = if matches!(choice, SceneChoice::Diagonals { .. }) { 1000.0 } else { 20_000.0 };
            assert!((0.7..1.3).contains(&(one.soup.len() as f32 / asked)), "{choice:?}: {}", one.soup.len());
            let in_range = |vertex: &u32| (*vertex as usize) < one.soup.positions.len();
            assert!(one.soup.triangles.iter().flatten().all(in_range));
        }
    }
}
