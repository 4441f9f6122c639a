//! Default lighting for worlds without lights.

use std::ops::ControlFlow;

use glam::Vec3;
use kinetree::EditError;
use kinetree_world::{Camera, CameraProjection, CameraSource, Frame, Light, LightSource, Sky, World};

use crate::color::luminance;
use crate::lights::LightTable;
use crate::{Settings, default_camera, render};

/// Columns, rows and samples per pixel of the picture that shows whether a scene is dark.
const TEST_PICTURE: [u32; 3] = [32, 18, 32];
/// A pixel is black when its luminance is below this part of that of the bright ones.
const BLACK: f32 = 2e-4;
/// Luminance of the median pixel below which a scene is dark whatever the bright ones have, W/(m^2
/// sr). Emissive materials usually have a radiance of about one; what they light to less than a
/// thousandth is not lit by them on purpose.
const DIM: f32 = 1e-3;

/// A clear afternoon: a sky from pale to blue, and a sun above and behind, to the left, of a camera
/// that looks along -z.
pub fn daylight() -> (Sky, Light) {
    let sky = Sky::Gradient { zenith: [0.22, 0.42, 0.85], horizon: [0.75, 0.83, 0.95], ground: [0.22, 0.2, 0.18] };
    let direction = Vec3::new(0.5, -0.75, -0.45).normalize().into();
    (sky, Light::Sun { direction, irradiance: [3.6, 3.2, 2.7], angle: 0.0093 })
}

/// Whether a frame is dark as a camera sees it. A frame with a sun or a sky is not; one without any
/// light is. With lamps or emissive surfaces only, a picture of a few hundred pixels is traced: the
/// frame is dark when more than half of the pixels are black, absolutely or relative to the bright
/// ones.
pub fn is_dark(frame: &Frame, camera: &Camera) -> bool {
    let lights = LightTable::new(frame);
    if lights.is_empty() || lights.has_infinite() {
        return lights.is_empty();
    }
    looks_dark(frame, camera)
}

/// Whether more than half of the pixels of a small picture are black, whatever the lights are.
fn looks_dark(frame: &Frame, camera: &Camera) -> bool {
    let [width, height, spp] = TEST_PICTURE;
    let settings = Settings { width, height, spp, max_depth: 8, ..Settings::default() };
    let Ok(picture) = render(frame, camera, &settings, &|_| ControlFlow::Continue(())) else { return false };
    let mut light: Vec<f32> = picture.film.pixels().iter().map(|&pixel| luminance(Vec3::from(pixel))).collect();
    light.sort_unstable_by(f32::total_cmp);
    let (middle, bright) = (light[light.len() / 2], light[light.len() * 19 / 20]);
    middle <= DIM.max(BLACK * bright)
}

/// Adds [`daylight`] to a world that at time 0 [is dark](is_dark) for its first camera, or without
/// cameras for the [default one](default_camera), and returns whether it did. If the picture stays
/// dark, because the camera is in a closed room, the world gets a lamp at the camera instead. Call
/// it after loading, before frames are made: earlier frames keep their lighting.
///
/// # Errors
/// An edit of the animation that the scene refused.
pub fn default_lighting(world: &mut World) -> Result<bool, EditError> {
    let frame = world.frame(0.0)?;
    let source = world.cameras.first().cloned();
    let camera = match &source {
        Some(source) => world.camera(source)?,
        None => default_camera(&frame, 16.0 / 9.0),
    };
    if !is_dark(&frame, &camera) {
        return Ok(false);
    }
    drop(frame);
    let (sky, sun) = daylight();
    let own_sky = std::mem::replace(&mut world.sky, sky);
    world.lights.push(LightSource { node: None, light: sun });
    let frame = world.frame(0.0)?;
    if looks_dark(&frame, &camera) && !is_empty(&frame) {
        let lamp = lamp_at(&frame, &camera);
        world.lights.pop();
        world.lights.push(match source {
            Some(CameraSource { node, camera, .. }) => LightSource { node, light: lamp(camera.position()) },
            None => LightSource { node: None, light: lamp(camera.position()) },
        });
        world.sky = own_sky;
    }
    Ok(true)
}

fn is_empty(frame: &Frame) -> bool {
    frame.snapshot.instances().len() == 0
}

/// Makes point lights, given a position, whose irradiance at the median distance of what the camera
/// sees is about that of the sun of [`daylight`].
fn lamp_at(frame: &Frame, camera: &Camera) -> impl Fn([f32; 3]) -> Light + use<> {
    let projection = CameraProjection::new(camera, 1.0);
    let mut distances: Vec<f32> = (0..64)
        .map(|i| projection.ray([(i % 8) as f32 / 8.0 + 0.0625, (i / 8) as f32 / 8.0 + 0.0625]))
        .filter_map(|ray| frame.snapshot.closest_hit(&ray))
        .map(|hit| hit.t)
        .collect();
    distances.sort_unstable_by(f32::total_cmp);
    let distance = distances.get(distances.len() / 2).copied().unwrap_or(1.0).clamp(1e-6, 1e6);
    move |position| Light::Point { position, intensity: [4.0 * distance * distance; 3], range: f32::INFINITY }
}
