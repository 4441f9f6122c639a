//! What is traced: scenes that the program makes, and files.

mod diagonals;
mod pile;
mod shapes;
mod terrain;

use std::path::Path;

use glam::Vec3;
use kinetree_render::{World, default_camera};
use serde::Deserialize;

use crate::Failure;
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

/// Rays along a side of the picture that tells how much is seen.
const LOOKS: usize = 24;
/// This part of the picture should show something.
const SEEN: f32 = 0.6;
/// How often it is looked closer, and how much each time.
const STEPS: usize = 16;
const CLOSER: f32 = 0.8;

impl Scenery {
    /// Narrows the angle of view until most of the picture shows something, or as far as that helps: rays that leave the scene at once measure nothing.
    pub(crate) fn look_closer(&mut self, trace: &dyn Fn(&Soup, &[Ray]) -> Vec<Answer>) {
        let seen = |eye: &Eye| {
            let rays = first_rays(eye);
            trace(&self.soup, &rays).iter().filter(|answer| answer.is_hit()).count() as f32 / rays.len() as f32
        };
        let mut best = (seen(&self.eye), self.eye);
        let mut eye = self.eye;
        for _ in 0..STEPS {
            if best.0 >= SEEN {
                break;
            }
            eye = Eye { right: eye.right * CLOSER, up: eye.up * CLOSER, ..eye };
            let part = seen(&eye);
            if part > best.0 {
                best = (part, eye);
            }
        }
        self.eye = best.1;
    }
}

fn first_rays(eye: &Eye) -> Vec<Ray> {
    let place = |i: usize| (2 * i + 1) as f32 / LOOKS as f32 - 1.0;
    let pixels = (0..LOOKS * LOOKS).map(|at| (place(at % LOOKS), place(at / LOOKS)));
    pixels.map(|(x, y)| Ray::new(eye.position, (eye.forward + eye.right * x - eye.up * y).normalize())).collect()
}

impl std::fmt::Display for Eye {
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

/// A world at a moment, seen by its first camera, or by one that shows most of it when it has none.
fn of_world(mut world: World, time: f64) -> Result<Scenery, Failure> {
    let frame = world.frame(time)?;
    let soup = Soup::flatten(&frame.view);
    let camera = match world.cameras.first().cloned() {
        Some(source) => world.camera(&source)?,
        None => default_camera(&frame, 1.0),
    };
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

    #[test]
    fn who_sees_little_looks_closer() {
        let (ball, faces) = shapes::sphere(8);
        let mut soup = Soup::default();
        soup.add(ball, &faces);
        let mut scenery = framed(soup);
        let reference = crate::engine::Reference::of(&scenery.soup).unwrap();
        let far = scenery.eye.right.length();
        scenery.eye = Eye { right: scenery.eye.right * 4.0, up: scenery.eye.up * 4.0, ..scenery.eye };
        scenery.look_closer(&|soup, rays| reference.closest(soup, rays));
        assert!(scenery.eye.right.length() < 4.0 * far);
        let seen = reference.closest(&scenery.soup, &first_rays(&scenery.eye));
        let hits = seen.iter().filter(|answer| answer.is_hit()).count();
        assert!(hits as f32 >= SEEN * seen.len() as f32, "{hits}");
    }
}
