//! The summary of a rendering: the figures that the overlay of Bikker's lecture "Ray Tracing for
//! Games" shows.

use std::fmt;

use kinetree::FrameReport;
use kinetree_world::{Camera, Frame, MaterialSet};
use serde::Serialize;

use crate::figures::{self, bytes, count};
use crate::memory;
use crate::trees::CommitFigures;

/// A whole rendering.
#[derive(Debug, Serialize)]
pub(crate) struct Summary {
    pub(crate) scene: SceneFigures,
    pub(crate) width: u32,
    pub(crate) height: u32,
    pub(crate) samples_per_pixel: u32,
    pub(crate) seed: u64,
    pub(crate) integrator: &'static str,
    pub(crate) threads: usize,
    pub(crate) load_ms: f64,
    /// The commit that built all trees.
    pub(crate) first_commit: CommitFigures,
    pub(crate) total: Total,
    pub(crate) memory: MemoryFigures,
    pub(crate) frames: Vec<FrameFigures>,
    /// The report of the last frame.
    #[serde(skip)]
    pub(crate) report: FrameReport,
}

/// Figures of the scene.
#[derive(Debug, Serialize)]
pub(crate) struct SceneFigures {
    pub(crate) name: String,
    /// The period of the animation in seconds; 0 if nothing moves.
    pub(crate) duration_s: f64,
    pub(crate) meshes: usize,
    /// Triangles of all meshes.
    pub(crate) triangles: u64,
    pub(crate) instances: usize,
    /// Triangles of all instances.
    pub(crate) instanced_triangles: u64,
    pub(crate) has_default_lighting: bool,
    pub(crate) notes: Vec<String>,
}

/// Memory in bytes.
#[derive(Debug, Serialize)]
pub(crate) struct MemoryFigures {
    /// Trees and posed geometry, with all buffers.
    pub(crate) scene: u64,
    pub(crate) textures: u64,
    /// The peak of the whole process, if the system tells.
    pub(crate) process_peak: Option<u64>,
}

/// Totals and means over all frames.
#[derive(Debug, Serialize)]
pub(crate) struct Total {
    pub(crate) frames: usize,
    /// Mean time of tracing.
    pub(crate) kernel_ms: f64,
    /// Mean time from the edits to the written file.
    pub(crate) frame_ms: f64,
    pub(crate) fps: f64,
    pub(crate) rays: u64,
    pub(crate) mrays_per_s: f64,
}

/// Figures of one frame.
#[derive(Debug, Serialize)]
pub(crate) struct FrameFigures {
    pub(crate) number: u32,
    pub(crate) time_s: f64,
    pub(crate) file: String,
    pub(crate) camera: CameraFigures,
    /// Each step of one doubles the brightness; `None` for display-ready pictures.
    pub(crate) exposure_ev: Option<f32>,
    /// Edits and commit.
    pub(crate) update_ms: f64,
    /// Collecting lights.
    pub(crate) prepare_ms: f64,
    /// Tracing.
    pub(crate) kernel_ms: f64,
    /// Tone mapping, encoding and writing.
    pub(crate) output_ms: f64,
    /// The whole frame.
    pub(crate) frame_ms: f64,
    pub(crate) fps: f64,
    pub(crate) rays: u64,
    pub(crate) mrays_per_s: f64,
    /// Samples that were not finite; anything but 0 is a bug.
    pub(crate) lost_samples: u64,
    pub(crate) commit: CommitFigures,
}

/// The camera of a frame.
#[derive(Debug, Serialize)]
pub(crate) struct CameraFigures {
    /// Metres, world space.
    pub(crate) position: [f32; 3],
    /// Unit length, world space.
    pub(crate) direction: [f32; 3],
    /// Vertical field of view, degrees.
    pub(crate) fov_degrees: f32,
}

impl CameraFigures {
    pub(crate) fn of(camera: &Camera) -> Self {
        let back = camera.world_from_camera.z_axis;
        let length = back.iter().map(|x| x * x).sum::<f32>().sqrt();
        Self {
            position: camera.position(),
            direction: back.map(|x| if length > 0.0 { 0.0 - x / length } else { 0.0 }),
            fov_degrees: camera.fov_y.to_degrees(),
        }
    }
}

impl SceneFigures {
    /// Figures of the scene in one frame.
    pub(crate) fn of(name: &str, duration_s: f64, frame: &Frame, has_default_lighting: bool, notes: &[String]) -> Self {
        let report = frame.snapshot.report();
        Self {
            name: name.to_owned(),
            duration_s,
            meshes: report.meshes.len(),
            triangles: report.triangles() as u64,
            instances: frame.snapshot.instances().len(),
            instanced_triangles: frame.snapshot.instances().map(|instance| instance.triangles().len() as u64).sum(),
            has_default_lighting,
            notes: notes.to_vec(),
        }
    }
}

impl MemoryFigures {
    pub(crate) fn of(report: &FrameReport, material_set: &MaterialSet) -> Self {
        Self {
            scene: report.memory as u64,
            textures: material_set.textures.iter().map(|texture| size_of_val(texture.texels.as_slice()) as u64).sum(),
            process_peak: memory::process_peak(),
        }
    }
}

impl Total {
    pub(crate) fn of(frames: &[FrameFigures]) -> Self {
        let mean =
            |figure: fn(&FrameFigures) -> f64| frames.iter().map(figure).sum::<f64>() / frames.len().max(1) as f64;
        let (kernel_ms, frame_ms) = (mean(|frame| frame.kernel_ms), mean(|frame| frame.frame_ms));
        let rays = frames.iter().map(|frame| frame.rays).sum();
        let mrays_per_s = mrays_per_s(rays, kernel_ms * frames.len() as f64);
        Self { frames: frames.len(), kernel_ms, frame_ms, fps: per_second(frame_ms), rays, mrays_per_s }
    }
}

/// The rate of something that takes `ms` milliseconds.
pub(crate) fn per_second(ms: f64) -> f64 {
    if ms > 0.0 { 1e3 / ms } else { 0.0 }
}

/// Million rays per second.
pub(crate) fn mrays_per_s(rays: u64, ms: f64) -> f64 {
    rays as f64 * 1e-6 * per_second(ms)
}

impl fmt::Display for Summary {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Some(last) = self.frames.last() else { return f.write_str("no frames") };
        let (scene, total, several) = (&self.scene, &self.total, self.frames.len() > 1);
        match self.frames.first() {
            Some(first) if several => writeln!(f, "{} to {}", first.file, last.file)?,
            _ => writeln!(f, "{}", last.file)?,
        }
        let meshes = figures::of(scene.meshes as u64, "mesh", "meshes");
        let instances = figures::of(scene.instances as u64, "instance", "instances");
        let triangles = [scene.triangles, scene.instanced_triangles];
        let triangles = triangles.map(|number| figures::of(number, "triangle", "triangles"));
        writeln!(f, "  scene      {}: {} in {meshes}, {} in {instances}", scene.name, triangles[0], triangles[1])?;
        let [x, y, z] = last.camera.position;
        let [to_x, to_y, to_z] = last.camera.direction;
        write!(f, "  camera     at {x:.2}, {y:.2}, {z:.2}, looking along {to_x:.2}, {to_y:.2}, {to_z:.2}")?;
        writeln!(f, ", {:.0} degrees high", last.camera.fov_degrees)?;
        match self.frames.first() {
            Some(first) if several => writeln!(f, "  time       {:.3} s to {:.3} s", first.time_s, last.time_s)?,
            _ => writeln!(f, "  time       {:.3} s", last.time_s)?,
        }
        write!(f, "  picture    {} x {}, {} samples per pixel", self.width, self.height, self.samples_per_pixel)?;
        write!(f, ", {}, seed {}", self.integrator, self.seed)?;
        writeln!(f, "{}", last.exposure_ev.map(|ev| format!(", exposure {ev:+.2} EV")).unwrap_or_default())?;
        let mean = if several { format!(", mean of {} frames", total.frames) } else { String::new() };
        write!(
            f,
            "  kernel     {:.1} ms, {} rays, {:.2} Mrays/s",
            total.kernel_ms,
            count(total.rays),
            total.mrays_per_s
        )?;
        writeln!(f, ", {}{mean}", figures::of(self.threads as u64, "thread", "threads"))?;
        let digits = if total.fps < 1.0 { 4 } else { 2 };
        writeln!(f, "  frame      {:.1} ms, {:.digits$} FPS{mean}", total.frame_ms, total.fps)?;
        write!(f, "  memory     {} trees and geometry, ", bytes(self.memory.scene))?;
        write!(f, "{} textures", bytes(self.memory.textures))?;
        let peak = self.memory.process_peak.map(|peak| format!(", {} process peak", bytes(peak)));
        writeln!(f, "{}", peak.unwrap_or_default())?;
        let first_commit = self.first_commit.total_ms.map(|ms| format!(", first commit {ms:.1} ms"));
        let loaded = match self.first_commit.loaded {
            0 => String::new(),
            loaded => format!(", {} from a file", figures::of(loaded as u64, "tree", "trees")),
        };
        writeln!(f, "  load       {:.1} ms{}{loaded}", self.load_ms, first_commit.unwrap_or_default())?;
        write!(f, "{}", self.report)
    }
}
