//! `kinetree render`: renders frames of a scene to files.

use std::ops::{ControlFlow, Range};
use std::path::{Path, PathBuf};
use std::time::Instant;

use kinetree_render::{Rendered, Settings, encode_srgb, metered_exposure, render, tone_map};
use kinetree_world::{Camera, Frame};

use crate::args::{Common, RenderArgs};
use crate::camera::PictureCamera;
use crate::destination::{Destination, Inputs};
use crate::failure::Failure;
use crate::figures::millis;
use crate::names::FileNames;
use crate::output::{png, print_to_stderr, report};
use crate::progress::Progress;
use crate::scene::{self, OpenedScene};
use crate::summary::{self, CameraFigures, FrameFigures, MemoryFigures, SceneFigures, Summary, Total};
use crate::trees::CommitFigures;

/// Renders the frames and prints a summary.
pub(crate) fn run(args: &RenderArgs, common: &Common) -> Result<(), Failure> {
    let numbers = args.frames.clone().unwrap_or(0..1);
    let names = FileNames::new(args.out.as_deref(), &scene::stem(args.scene.as_deref()), numbers.len() > 1)?;
    let inputs = Inputs::of(args.scene.as_deref().into_iter().chain(args.trees.as_deref()));
    numbers.clone().try_for_each(|number| inputs.refuse_overwriting(&names.of(number)))?;
    let first = Destination::resolve(&names.of(numbers.start))?;
    let is_output_taken = first.is_standard_output();
    let opened = scene::open(args.scene.as_deref(), args.clip.as_ref(), args.trees.as_deref())?;
    let inputs = Inputs::of(opened.files.iter().map(PathBuf::as_path));
    numbers.clone().try_for_each(|number| inputs.refuse_overwriting(&names.of(number)))?;
    if !common.quiet {
        opened.notes.iter().for_each(|note| print_to_stderr(&format!("{}: {note}", opened.name)));
    }
    let picture_camera = PictureCamera::choose(args.camera.as_ref(), &opened.world.cameras, &opened.name)?;

    let progress = Progress::new(numbers.len() as u64, common.quiet);
    let exposure = args.exposure.map(f32::exp2);
    let mut rendering = Rendering { args, opened, picture_camera, names, exposure, progress: &progress };
    let summary = rendering.render_all(numbers, first);
    progress.finish();
    let summary = summary?;
    report(&summary, || summary.to_string(), common, is_output_taken)
}

/// What the frames of a rendering share.
struct Rendering<'a> {
    args: &'a RenderArgs,
    opened: OpenedScene,
    picture_camera: PictureCamera,
    names: FileNames,
    /// The factor of exposure: as requested, or that of the first frame, so that a sequence does
    /// not flicker.
    exposure: Option<f32>,
    progress: &'a Progress,
}

impl Rendering<'_> {
    fn render_all(&mut self, numbers: Range<u32>, first: Destination) -> Result<Summary, Failure> {
        let mut frames = Vec::new();
        let mut last = None;
        let mut first = Some(first);
        for number in numbers {
            let destination = match first.take() {
                Some(first) => first,
                None => Destination::resolve(&self.names.of(number))?,
            };
            // Drops the previous frame, so that its buffers can be reused.
            drop(last.take());
            let (frame, figures) = self.render_one(number, destination)?;
            frames.push(figures);
            last = Some(frame);
        }
        let last = last.ok_or_else(|| Failure::arguments("there are no frames to make"))?;
        let OpenedScene { name, world, notes, load_time, first_commit, has_default_lighting, .. } = &self.opened;
        let [width, height] = self.args.size;
        Ok(Summary {
            scene: SceneFigures::of(name, world.animation.duration(), &last, *has_default_lighting, notes),
            width,
            height,
            samples_per_pixel: self.args.spp,
            seed: self.args.seed,
            integrator: self.args.integrator.name(),
            threads: rayon::current_num_threads(),
            load_ms: millis(*load_time),
            first_commit: CommitFigures::of(first_commit),
            total: Total::of(&frames),
            memory: MemoryFigures::of(last.snapshot.report(), &last.material_set),
            frames,
            report: last.snapshot.report().clone(),
        })
    }

    fn render_one(&mut self, number: u32, destination: Destination) -> Result<(Frame, FrameFigures), Failure> {
        let start = Instant::now();
        let time = if self.args.frames.is_some() { f64::from(number) / self.args.fps } else { self.args.time };
        let frame = self.opened.frame(time)?;
        let update_time = start.elapsed();

        let [width, height] = self.args.size;
        let camera = self.picture_camera.camera(&self.opened.world, &frame, width as f32 / height as f32)?;
        let rendered = self.trace(&frame, &camera)?;
        let traced = Instant::now();
        let file = self.names.of(number);
        let exposure = self.exposure(&rendered, &frame, &camera);
        write_picture(&rendered, exposure, &file, destination)?;

        let kernel_ms = millis(rendered.trace_time);
        let frame_ms = millis(start.elapsed());
        let figures = FrameFigures {
            number,
            time_s: time,
            file: file.display().to_string(),
            camera: CameraFigures::of(&camera),
            exposure_ev: exposure.map(f32::log2),
            update_ms: millis(update_time),
            prepare_ms: millis(rendered.prepare_time),
            kernel_ms,
            output_ms: millis(traced.elapsed()),
            frame_ms,
            fps: summary::per_second(frame_ms),
            rays: rendered.rays,
            mrays_per_s: summary::mrays_per_s(rendered.rays, kernel_ms),
            lost_samples: rendered.lost_samples,
            commit: CommitFigures::of(frame.snapshot.report()),
        };
        Ok((frame, figures))
    }

    fn trace(&self, frame: &Frame, camera: &Camera) -> Result<Rendered, Failure> {
        let [width, height] = self.args.size;
        // No limit: the global pool has the number of threads that was requested.
        let settings = Settings {
            width,
            height,
            spp: self.args.spp,
            seed: self.args.seed,
            integrator: self.args.integrator,
            threads: None,
            ..Settings::default()
        };
        let on_tile = |tiles: kinetree_render::Progress| {
            self.progress.tile_done(tiles.total as u64);
            ControlFlow::Continue(())
        };
        render(frame, camera, &settings, &on_tile)
            .map_err(|error| Failure::work(format!("{}: {error}", self.opened.name)))
    }

    /// The factor of exposure; `None` if the integrator gives display-ready colours.
    fn exposure(&mut self, rendered: &Rendered, frame: &Frame, camera: &Camera) -> Option<f32> {
        let metered = || metered_exposure(frame, camera, &rendered.film);
        (!rendered.is_display_ready).then(|| *self.exposure.get_or_insert_with(metered))
    }
}

/// Encodes a film and writes it.
fn write_picture(rendered: &Rendered, exposure: Option<f32>, file: &Path, to: Destination) -> Result<(), Failure> {
    let film = &rendered.film;
    let srgb = exposure.map_or_else(|| encode_srgb(film), |exposure| tone_map(film, exposure));
    let bytes = png(&srgb, [film.width(), film.height()]);
    let bytes = bytes.map_err(|error| Failure::work(format!("{}: cannot be encoded: {error}", file.display())))?;
    to.write(&bytes)
}
