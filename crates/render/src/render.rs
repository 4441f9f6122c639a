//! From a frame and a camera to a film, on all threads.
//!
//! The picture is cut into tiles that threads take as they come. What a pixel becomes depends on
//! the seed and the pixel alone, so the picture is the same for any number of threads.

use std::ops::ControlFlow;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant};

use kinetree::Ray;
use rayon::prelude::*;

use crate::camera::CameraProjection;
use crate::{Camera, Film, Frame, Integrator, IntegratorKind, Sampler, SceneContext, Tracer};

/// What picture to make.
#[derive(Debug, Clone, PartialEq)]
pub struct Settings {
    /// Pixels in a row, 1 to 65536.
    pub width: u32,
    /// Rows, 1 to 65536.
    pub height: u32,
    /// Samples per pixel, at least 1.
    pub spp: u32,
    /// The first sample's number. Pictures of samples 0..8 and 8..16 complement each other: their
    /// mean is that of 0..16.
    pub first_sample: u32,
    /// Another seed, other noise.
    pub seed: u64,
    /// How many threads trace; `None` for rayon's own pool. The picture does not depend on it.
    pub threads: Option<usize>,
    /// What the picture shows.
    pub integrator: IntegratorKind,
    /// How often a path may scatter.
    pub max_depth: u32,
    /// The most radiance that one path may bring from beyond its first bounce; biased, and
    /// therefore off unless asked for.
    pub clamp: Option<f32>,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            width: 1280,
            height: 720,
            spp: 16,
            first_sample: 0,
            seed: 0,
            threads: None,
            integrator: IntegratorKind::Path,
            max_depth: 64,
            clamp: None,
        }
    }
}

/// How far a picture is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Progress {
    /// Tiles that are finished.
    pub done: usize,
    /// Tiles of the whole picture.
    pub total: usize,
}

/// A picture, and what it took.
#[derive(Debug, Clone)]
pub struct Rendered {
    /// The picture in linear RGB.
    pub film: Film,
    /// Whether colours are meant to be seen as they are, without exposure and tone mapping.
    pub is_display_ready: bool,
    /// Rays traced.
    pub rays: u64,
    /// Samples that were no numbers and were counted as black. Anything but 0 is a bug.
    pub lost_samples: u64,
    /// Time to gather lights.
    pub prepare_time: Duration,
    /// Time to trace.
    pub trace_time: Duration,
}

/// Why there is no picture.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum RenderError {
    /// A side is zero or beyond the limit, or there are too many pixels.
    #[error(
        "a picture of {width} x {height} pixels cannot be made: sides go from 1 to {MAX_SIDE}, pixels up to {MAX_PIXELS}"
    )]
    Size {
        /// As asked for.
        width: u32,
        /// As asked for.
        height: u32,
    },
    /// No samples, or more than can be numbered.
    #[error("{spp} samples per pixel from number {first} on cannot be taken: at least 1, and numbers below 2^32")]
    Samples {
        /// As asked for.
        spp: u32,
        /// As asked for.
        first: u32,
    },
    /// Threads could not be had.
    #[error("{count} threads cannot be had: {reason}")]
    Threads {
        /// As asked for.
        count: usize,
        /// What stood in the way.
        reason: String,
    },
    /// The caller asked to stop.
    #[error("stopped before the picture was finished")]
    Stopped,
}

/// Longest side, pixels.
pub const MAX_SIDE: u32 = 65_536;
/// Most pixels of a picture: with twelve bytes each, 1.5 GiB.
pub const MAX_PIXELS: u64 = 1 << 27;
/// Most threads of a picture.
const MAX_THREADS: usize = 1024;
/// Side of a tile, pixels.
const TILE: u32 = 16;
/// How many samples are traced together: what they need stays in the second cache.
const WAVE: usize = 1024;

/// Makes a picture. `progress` is called by the tracing threads whenever a tile is finished, and
/// may ask to stop.
///
/// # Errors
/// Sizes, samples or threads that cannot be had; [`RenderError::Stopped`] when `progress` broke
/// off.
pub fn render(
    frame: &Frame,
    camera: &Camera,
    settings: &Settings,
    progress: &(dyn Fn(Progress) -> ControlFlow<()> + Sync),
) -> Result<Rendered, RenderError> {
    render_with(settings.integrator.with(settings).as_ref(), frame, camera, settings, progress)
}

/// As [`render`], with an integrator of the caller's own; [`Settings::integrator`] is not looked
/// at.
///
/// # Errors
/// As for [`render`].
pub fn render_with(
    integrator: &dyn Integrator,
    frame: &Frame,
    camera: &Camera,
    settings: &Settings,
    progress: &(dyn Fn(Progress) -> ControlFlow<()> + Sync),
) -> Result<Rendered, RenderError> {
    check(settings)?;
    let start = Instant::now();
    let context = SceneContext::new(frame);
    let prepare_time = start.elapsed();

    let projection = CameraProjection::new(camera, settings.width as f32 / settings.height as f32);
    let picture = Picture { integrator, context: &context, projection, settings };
    let tiles = in_pool(settings.threads, || picture.trace(progress))??;

    let mut film = Film::new(settings.width, settings.height);
    let (mut rays, mut lost_samples) = (0, 0);
    for tile in &tiles {
        rays += tile.rays;
        lost_samples += tile.lost_samples;
        for (row, run) in tile.pixels.chunks(tile.width as usize).enumerate() {
            film.set_row([tile.corner[0], tile.corner[1] + row as u32], run);
        }
    }
    let trace_time = start.elapsed() - prepare_time;
    let is_display_ready = integrator.is_display_ready();
    Ok(Rendered { film, is_display_ready, rays, lost_samples, prepare_time, trace_time })
}

fn check(settings: &Settings) -> Result<(), RenderError> {
    let &Settings { width, height, spp, first_sample: first, .. } = settings;
    let sides = 1..=MAX_SIDE;
    if !sides.contains(&width) || !sides.contains(&height) || u64::from(width) * u64::from(height) > MAX_PIXELS {
        return Err(RenderError::Size { width, height });
    }
    if spp == 0 || first.checked_add(spp).is_none() {
        return Err(RenderError::Samples { spp, first });
    }
    Ok(())
}

/// Runs work on a pool of its own with so many threads, or on the global one.
fn in_pool<T: Send>(threads: Option<usize>, work: impl FnOnce() -> T + Send) -> Result<T, RenderError> {
    let Some(count) = threads else { return Ok(work()) };
    if !(1..=MAX_THREADS).contains(&count) {
        return Err(RenderError::Threads { count, reason: format!("there can be 1 to {MAX_THREADS}") });
    }
    let pool = rayon::ThreadPoolBuilder::new().num_threads(count).build();
    let pool = pool.map_err(|error| RenderError::Threads { count, reason: error.to_string() })?;
    Ok(pool.install(work))
}

/// All that tiles share.
struct Picture<'a> {
    integrator: &'a dyn Integrator,
    context: &'a SceneContext<'a>,
    projection: CameraProjection,
    settings: &'a Settings,
}

/// A finished part of the picture.
struct Tile {
    corner: [u32; 2],
    width: u32,
    pixels: Vec<[f32; 3]>,
    rays: u64,
    lost_samples: u64,
}

impl Picture<'_> {
    fn trace(&self, progress: &(dyn Fn(Progress) -> ControlFlow<()> + Sync)) -> Result<Vec<Tile>, RenderError> {
        let columns = self.settings.width.div_ceil(TILE);
        let total = columns * self.settings.height.div_ceil(TILE);
        let done = AtomicUsize::new(0);
        let one = |index: u32| {
            let tile = self.tile([index % columns * TILE, index / columns * TILE]);
            let done = done.fetch_add(1, Ordering::Relaxed) + 1;
            match progress(Progress { done, total: total as usize }) {
                ControlFlow::Continue(()) => Ok(tile),
                ControlFlow::Break(()) => Err(RenderError::Stopped),
            }
        };
        (0..total).into_par_iter().with_max_len(1).map(one).collect()
    }

    fn tile(&self, corner: [u32; 2]) -> Tile {
        let width = TILE.min(self.settings.width - corner[0]);
        let height = TILE.min(self.settings.height - corner[1]);
        let mut tracer = Tracer::new(self.context);
        let mut wave = Wave::default();
        let mut sums = Sums { of_pixels: vec![[0.0; 3]; (width * height) as usize], lost_samples: 0 };
        // Along a Morton curve, so that what is traced together is a small square of the picture.
        for place in 0..TILE * TILE {
            let [x, y] = [even_bits(place), even_bits(place >> 1)];
            if x >= width || y >= height {
                continue;
            }
            for index in 0..self.settings.spp {
                self.begin([corner[0] + x, corner[1] + y], index, (y * width + x) as usize, &mut wave);
                if wave.rays.len() == WAVE {
                    wave.trace(self.integrator, &mut tracer, &mut sums);
                }
            }
        }
        wave.trace(self.integrator, &mut tracer, &mut sums);
        let mean = |sum: &[f64; 3]| sum.map(|channel| (channel / f64::from(self.settings.spp)) as f32);
        let pixels = sums.of_pixels.iter().map(mean).collect();
        Tile { corner, width, pixels, rays: tracer.rays(), lost_samples: sums.lost_samples }
    }

    /// Adds a sample of a pixel to a wave.
    fn begin(&self, [x, y]: [u32; 2], index: u32, pixel: usize, wave: &mut Wave) {
        let mut sampler = Sampler::new(self.settings.seed, [x, y], self.settings.first_sample + index);
        let [jitter_x, jitter_y] = sampler.next_2d();
        let at =
            [(x as f32 + jitter_x) / self.settings.width as f32, (y as f32 + jitter_y) / self.settings.height as f32];
        wave.pixels.push(pixel);
        wave.rays.push(self.projection.ray(at));
        wave.samplers.push(sampler);
    }
}

/// Samples that are traced together.
#[derive(Default)]
struct Wave {
    /// Within the tile.
    pixels: Vec<usize>,
    rays: Vec<Ray>,
    samplers: Vec<Sampler>,
    colors: Vec<[f32; 3]>,
}

/// The samples of a tile, added up.
struct Sums {
    of_pixels: Vec<[f64; 3]>,
    lost_samples: u64,
}

impl Wave {
    /// Traces the samples, adds them to their pixels, and is empty again.
    fn trace(&mut self, integrator: &dyn Integrator, tracer: &mut Tracer<'_>, sums: &mut Sums) {
        self.colors.clear();
        self.colors.resize(self.rays.len(), [0.0; 3]);
        integrator.radiances(tracer, &self.rays, &mut self.samplers, &mut self.colors);
        for (&pixel, color) in self.pixels.iter().zip(&self.colors) {
            if color.iter().all(|channel| channel.is_finite()) {
                for channel in 0..3 {
                    sums.of_pixels[pixel][channel] += f64::from(color[channel]);
                }
            } else {
                sums.lost_samples += 1;
            }
        }
        self.pixels.clear();
        self.rays.clear();
        self.samplers.clear();
    }
}

/// Every other bit of a number below 2^16, moved together.
fn even_bits(number: u32) -> u32 {
    (0..8).fold(0, |bits, at| bits | (number >> (2 * at) & 1) << at)
}
