//! Rendering a frame through a camera to a film, in parallel.
//!
//! The picture is divided into tiles, which the threads of a pool render. A pixel depends on the
//! seed and its position only, so the picture is the same for any number of threads.

use std::ops::ControlFlow;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant};

use kinetree::Ray;
use kinetree_world::{Camera, CameraProjection, Frame};
use rayon::prelude::*;

use crate::{Film, Integrator, RenderError, Sampler, SceneContext, Settings, Tracer};

/// The progress of a picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Progress {
    /// Tiles that are finished.
    pub done: usize,
    /// Tiles of the whole picture.
    pub total: usize,
}

/// A picture, with statistics of its rendering.
#[derive(Debug, Clone)]
pub struct Rendered {
    /// The picture in linear RGB.
    pub film: Film,
    /// Whether colours are meant to be shown as they are, without exposure and tone mapping.
    pub is_display_ready: bool,
    /// Rays traced.
    pub rays: u64,
    /// Samples that were not finite and were counted as black. Anything but 0 is a bug.
    pub lost_samples: u64,
    /// Time to collect the lights.
    pub prepare_time: Duration,
    /// Time to trace.
    pub trace_time: Duration,
}

/// Largest number of threads.
const MAX_THREADS: usize = 1024;
/// Side of a tile, pixels.
const TILE: u32 = 16;
/// Samples that are traced together: their state fits into the second-level cache.
const BATCH: usize = 1024;

/// Renders a picture. `progress` is called by the rendering threads whenever a tile is finished,
/// and may stop the rendering.
///
/// # Errors
/// Sizes, samples or threads out of range; [`RenderError::Stopped`] when `progress` broke off.
pub fn render(
    frame: &Frame,
    camera: &Camera,
    settings: &Settings,
    progress: &(dyn Fn(Progress) -> ControlFlow<()> + Sync),
) -> Result<Rendered, RenderError> {
    render_with(settings.integrator.with(settings).as_ref(), frame, camera, settings, progress)
}

/// As [`render`], with an integrator of the caller's own; [`Settings::integrator`] is ignored.
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
    settings.check()?;
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

/// Runs `work` on a pool of its own with a number of threads, or on the global pool.
fn in_pool<T: Send>(threads: Option<usize>, work: impl FnOnce() -> T + Send) -> Result<T, RenderError> {
    let Some(count) = threads else { return Ok(work()) };
    if !(1..=MAX_THREADS).contains(&count) {
        return Err(RenderError::Threads { count, reason: format!("there can be 1 to {MAX_THREADS}") });
    }
    let pool = rayon::ThreadPoolBuilder::new().num_threads(count).build();
    let pool = pool.map_err(|error| RenderError::Threads { count, reason: error.to_string() })?;
    Ok(pool.install(work))
}

/// What all tiles share.
struct Picture<'a> {
    integrator: &'a dyn Integrator,
    context: &'a SceneContext<'a>,
    projection: CameraProjection,
    settings: &'a Settings,
}

/// The finished pixels of one tile.
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
        let mut batch = SampleBatch::default();
        let mut sums = Sums { of_pixels: vec![[0.0; 3]; (width * height) as usize], lost_samples: 0 };
        // Pixels in Morton order, so that the samples of a batch cover a small square.
        for place in 0..TILE * TILE {
            let [x, y] = [even_bits(place), even_bits(place >> 1)];
            if x >= width || y >= height {
                continue;
            }
            for index in 0..self.settings.spp {
                self.begin([corner[0] + x, corner[1] + y], index, (y * width + x) as usize, &mut batch);
                if batch.rays.len() == BATCH {
                    batch.trace(self.integrator, &mut tracer, &mut sums);
                }
            }
        }
        batch.trace(self.integrator, &mut tracer, &mut sums);
        let mean = |sum: &[f64; 3]| sum.map(|channel| (channel / f64::from(self.settings.spp)) as f32);
        let pixels = sums.of_pixels.iter().map(mean).collect();
        Tile { corner, width, pixels, rays: tracer.rays(), lost_samples: sums.lost_samples }
    }

    /// Adds a sample of a pixel to a batch.
    fn begin(&self, [x, y]: [u32; 2], index: u32, pixel: usize, batch: &mut SampleBatch) {
        let mut sampler = Sampler::new(self.settings.seed, [x, y], self.settings.first_sample + index);
        let [jitter_x, jitter_y] = sampler.next_2d();
        let at =
            [(x as f32 + jitter_x) / self.settings.width as f32, (y as f32 + jitter_y) / self.settings.height as f32];
        batch.pixels.push(pixel);
        batch.rays.push(self.projection.ray(at));
        batch.samplers.push(sampler);
    }
}

/// Samples that are traced together.
#[derive(Default)]
struct SampleBatch {
    /// Index of the pixel within the tile.
    pixels: Vec<usize>,
    rays: Vec<Ray>,
    samplers: Vec<Sampler>,
    colors: Vec<[f32; 3]>,
}

/// Sums of the samples of each pixel of a tile.
struct Sums {
    of_pixels: Vec<[f64; 3]>,
    lost_samples: u64,
}

impl SampleBatch {
    /// Traces the samples, adds them to their pixels, and empties the batch.
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

/// The even bits of a number below 2^16, compacted: one coordinate of a Morton code.
fn even_bits(number: u32) -> u32 {
    (0..8).fold(0, |bits, at| bits | (number >> (2 * at) & 1) << at)
}
