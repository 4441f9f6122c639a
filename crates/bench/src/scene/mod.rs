//! What is traced: scenes that the program makes, and files.

mod diagonals;
mod pile;
mod shapes;
mod terrain;

use std::path::Path;

use glam::Vec3;
use kinetree_render::World;
use serde::Deserialize;

use crate::Failure;
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

/// A scene ready to be measured.
pub(crate) struct Scenery {
    /// The triangles.
    pub(crate) soup: Soup,
    /// Who looks at them.
    pub(crate) eye: Eye,
}

/// A pinhole camera for square pictures.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Eye {
    /// Metres, world space.
    pub(crate) position: Vec3,
    /// Where it looks, of length one.
    pub(crate) forward: Vec3,
    /// From the middle of the picture to its right edge, at distance one.
    pub(crate) right: Vec3,
    /// From the middle of the picture to its upper edge, at distance one.
    pub(crate) up: Vec3,
}

impl Eye {
    /// At `position`, looking at `target`; `half` is the tangent of half the angle of view.
    pub(crate) fn look_at(position: Vec3, target: Vec3, half: f32) -> Self {
        let forward = (target - position).normalize_or(Vec3::NEG_Z);
        let right = forward.cross(Vec3::Y).normalize_or(Vec3::X);
        Self { position, forward, right: right * half, up: right.cross(forward) * half }
    }

    /// From outside, so that the box fills the picture.
    fn frame(soup: &Soup) -> Self {
        let bounds = soup.bounds();
        let radius = (Vec3::from(bounds.extent()).length() * 0.5).max(1e-6);
        let center = Vec3::from(bounds.center());
        Self::look_at(center + Vec3::new(0.62, 0.38, 0.68).normalize() * radius * 2.0, center, 0.5)
    }
}

impl SceneChoice {
    /// Makes or loads the scene.
    ///
    /// # Errors
    /// A file that cannot be loaded, or a scene without triangles.
    pub(crate) fn open(&self) -> Result<Scenery, Failure> {
        let scenery = match self {
            Self::Race { seed, time } => of_world(kinetree_race::world(*seed), *time)?,
            Self::Diagonals { seed, triangles } => framed(diagonals::diagonals(*seed, *triangles)),
            Self::Terrain { seed, triangles } => terrain::terrain(*seed, *triangles),
            Self::Pile { seed, triangles } => framed(pile::pile(*seed, *triangles)),
            Self::File { path, time } => of_world(load(path)?, *time)?,
        };
        if scenery.soup.len() == 0 {
            return Err("the scene has no triangles".into());
        }
        Ok(scenery)
    }
}

fn load(path: &Path) -> Result<World, Failure> {
    Ok(kinetree_gltf::load(path)?.world)
}

fn framed(soup: Soup) -> Scenery {
    Scenery { eye: Eye::frame(&soup), soup }
}

/// A world at a moment, seen by its first camera, or framed when it has none.
fn of_world(mut world: World, time: f64) -> Result<Scenery, Failure> {
    let view = world.frame(time)?.view;
    let soup = Soup::flatten(&view);
    let Some(source) = world.cameras.first().cloned() else { return Ok(framed(soup)) };
    let camera = world.camera(&source)?;
    let position = Vec3::from(camera.position());
    let forward = -Vec3::from(camera.world_from_camera.z_axis);
    if !(position.is_finite() && forward.is_finite() && camera.fov_y.is_finite()) {
        return Ok(framed(soup));
    }
    let half = (camera.fov_y.clamp(0.05, 2.8) * 0.5).tan();
    Ok(Scenery { eye: Eye::look_at(position, position + forward, half), soup })
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
