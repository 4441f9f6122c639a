//! What is traced: scenes that the program makes, and files.

mod diagonals;
mod pile;
mod shapes;
mod terrain;

use std::path::Path;

use glam::Vec3;
use kinetree_render::{World, default_camera};
use serde::Deserialize;

use crate::failure::Failure;
use crate::ray::{Answer, Ray};
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
pub(crate) struct BenchScene {
    /// The triangles.
    pub(crate) soup: Soup,
    /// Who looks at them.
    pub(crate) camera: PinholeCamera,
}

/// A pinhole camera for square pictures.
#[derive(Debug, Clone, Copy)]
pub(crate) struct PinholeCamera {
    /// Metres, world space.
    pub(crate) position: Vec3,
    /// Where it looks, of length one.
    pub(crate) forward: Vec3,
    /// From the middle of the picture to its right edge, at distance one.
    pub(crate) right: Vec3,
    /// From the middle of the picture to its upper edge, at distance one.
    pub(crate) up: Vec3,
}

impl PinholeCamera {
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

/// Rays along a side of the picture that tells how much is seen.
const PREVIEW_SIDE: usize = 24;
/// This part of the picture should show something.
const LEAST_COVERAGE: f32 = 0.6;
/// How often it is looked closer, and how much each time.
const STEPS: usize = 16;
const NARROWING: f32 = 0.8;

impl BenchScene {
    /// Narrows the angle of view until most of the picture shows something, or as far as that helps: rays that leave the scene at once measure nothing.
    pub(crate) fn narrow_view(&mut self, trace: &dyn Fn(&Soup, &[Ray]) -> Vec<Answer>) {
        let seen = |camera: &PinholeCamera| {
            let rays = preview_rays(camera);
            trace(&self.soup, &rays).iter().filter(|answer| answer.is_hit()).count() as f32 / rays.len() as f32
        };
        let mut best = (seen(&self.camera), self.camera);
        let mut camera = self.camera;
        for _ in 0..STEPS {
            if best.0 >= LEAST_COVERAGE {
                break;
            }
            camera = PinholeCamera { right: camera.right * NARROWING, up: camera.up * NARROWING, ..camera };
            let part = seen(&camera);
            if part > best.0 {
                best = (part, camera);
            }
        }
        self.camera = best.1;
    }
}

fn preview_rays(camera: &PinholeCamera) -> Vec<Ray> {
    let place = |i: usize| (2 * i + 1) as f32 / PREVIEW_SIDE as f32 - 1.0;
    let pixels = (0..PREVIEW_SIDE * PREVIEW_SIDE).map(|at| (place(at % PREVIEW_SIDE), place(at / PREVIEW_SIDE)));
    pixels
        .map(|(x, y)| Ray::new(camera.position, (camera.forward + camera.right * x - camera.up * y).normalize()))
        .collect()
}

impl std::fmt::Display for PinholeCamera {
    /// As a case file has it.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { position, forward, right, .. } = self;
        write!(f, "{position:?}, looking along {forward:?}, half {}", right.length())
    }
}

impl SceneChoice {
    /// Makes or loads the scene.
    ///
    /// # Errors
    /// A file that cannot be loaded, or a scene without triangles.
    pub(crate) fn open(&self) -> Result<BenchScene, Failure> {
        let scene = match self {
            Self::Race { seed, time } => of_world(kinetree_race::world(*seed), *time)?,
            Self::Diagonals { seed, triangles } => with_default_camera(diagonals::diagonals(*seed, *triangles)),
            Self::Terrain { seed, triangles } => terrain::terrain(*seed, *triangles),
            Self::Pile { seed, triangles } => with_default_camera(pile::pile(*seed, *triangles)),
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

fn with_default_camera(soup: Soup) -> BenchScene {
    BenchScene { camera: PinholeCamera::frame(&soup), soup }
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
        return Ok(with_default_camera(soup));
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

    #[test]
    fn a_camera_that_sees_little_is_narrowed() {
        let (ball, faces) = shapes::sphere(8);
        let mut soup = Soup::default();
        soup.add(ball, &faces);
        let mut scene = with_default_camera(soup);
        let reference = crate::engine::Reference::of(&scene.soup).unwrap();
        let far = scene.camera.right.length();
        scene.camera = PinholeCamera { right: scene.camera.right * 4.0, up: scene.camera.up * 4.0, ..scene.camera };
        scene.narrow_view(&|soup, rays| reference.closest(soup, rays));
        assert!(scene.camera.right.length() < 4.0 * far);
        let seen = reference.closest(&scene.soup, &preview_rays(&scene.camera));
        let hits = seen.iter().filter(|answer| answer.is_hit()).count();
        assert!(hits as f32 >= LEAST_COVERAGE * seen.len() as f32, "{hits}");
    }
}
