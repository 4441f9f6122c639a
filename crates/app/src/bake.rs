//! `kinetree bake`: builds the trees of static and rigid meshes once, at best quality, into a file.
//!
//! The offline build of Bikker's lecture "Ray Tracing for Games", part 6.

use std::collections::HashMap;
use std::fmt;
use std::path::PathBuf;
use std::sync::mpsc::{self, RecvTimeoutError};
use std::time::{Duration, Instant};

use kinetree::build::{self, BuildOptions, BuildProgress, Cancelled, Quality};
use kinetree::geometry::Triangles;
use kinetree::{Mesh, MeshBvh, Motion, Scene, TreeFile};
use serde::Serialize;

use crate::args::{BakeArgs, Common};
use crate::baked_trees::is_baked;
use crate::destination::{Destination, Inputs};
use crate::failure::Failure;
use crate::figures::{self, bytes, count, millis};
use crate::output::{print_to_stderr, report};
use crate::progress::Progress;
use crate::scene::{self, LoadedScene};
use crate::trees::name_of;

/// Builds the trees and writes them.
pub(crate) fn run(args: &BakeArgs, common: &Common) -> Result<(), Failure> {
    let out = args.out.clone().unwrap_or_else(|| format!("{}.trees", scene::stem(args.scene.as_deref())).into());
    Inputs::of(args.scene.as_deref()).refuse_overwriting(&out)?;
    let destination = Destination::resolve(&out)?;
    let is_output_taken = destination.is_standard_output();
    let loaded = scene::load(args.scene.as_deref(), args.clip.as_ref())?;
    Inputs::of(loaded.files.iter().map(PathBuf::as_path)).refuse_overwriting(&out)?;
    if !common.quiet {
        loaded.notes.iter().for_each(|note| print_to_stderr(&format!("{}: {note}", loaded.name)));
    }
    let start = Instant::now();
    let progress = Progress::new(1, common.quiet);
    let baked = bake_all(&loaded, &progress);
    progress.finish();
    let (trees, figures) = baked?;
    let file = TreeFile::write(&trees);
    destination.write(&file)?;
    let summary = Summary {
        scene: loaded.name,
        file: out.display().to_string(),
        bytes: file.len(),
        quality: "best",
        threads: rayon::current_num_threads(),
        meshes: loaded.world.scene.meshes().count(),
        left_out: meshes_of(&loaded.world.scene).filter(|(_, motion)| !is_baked(*motion)).count(),
        load_ms: millis(loaded.load_time),
        bake_ms: millis(start.elapsed()),
        trees: figures,
    };
    report(&summary, || summary.to_string(), common, is_output_taken)
}

/// Every mesh of a scene, and how it moves.
fn meshes_of(scene: &Scene) -> impl Iterator<Item = (&Mesh, Motion)> {
    scene.meshes().filter_map(|id| Some((scene.mesh(id).ok()?, scene.motion(id).ok()?)))
}

/// Builds one tree for each distinct mesh that does not deform.
fn bake_all(loaded: &LoadedScene, progress: &Progress) -> Result<(Vec<Vec<u8>>, Vec<TreeFigures>), Failure> {
    let mut wanted: Vec<(&Mesh, Motion, Vec<usize>)> = Vec::new();
    let mut index_of: HashMap<u64, usize> = HashMap::new();
    for (number, (mesh, motion)) in meshes_of(&loaded.world.scene).enumerate() {
        if is_baked(motion) {
            let index = *index_of.entry(mesh.fingerprint()).or_insert(wanted.len());
            match wanted.get_mut(index) {
                Some((_, _, numbers)) => numbers.push(number),
                None => wanted.push((mesh, motion, vec![number])),
            }
        }
    }
    let all: usize = wanted.iter().map(|(mesh, ..)| mesh.triangles().len()).sum();
    let (mut trees, mut figures, mut done) = (Vec::new(), Vec::new(), 0);
    for (mesh, motion, meshes) in wanted {
        let here = mesh.triangles().len();
        let report_fraction =
            |fraction: f64| progress.report_fraction((done as f64 + fraction * here as f64) / all.max(1) as f64);
        let (tree, of_tree) = bake_one(mesh, motion, meshes, &report_fraction)?;
        trees.push(tree);
        figures.push(of_tree);
        done += here;
    }
    Ok((trees, figures))
}

fn bake_one(
    mesh: &Mesh,
    motion: Motion,
    meshes: Vec<usize>,
    report_fraction: &(dyn Fn(f64) + Sync),
) -> Result<(Vec<u8>, TreeFigures), Failure> {
    let start = Instant::now();
    let triangles = Triangles::new(mesh.positions().to_vec(), mesh.triangles().into());
    let triangles = triangles.expect("a mesh has only indices in range");
    let mut options = BuildOptions::default();
    options.quality = Quality::Best;
    let tree =
        build_with_reports(&triangles, &options, report_fraction).map_err(|error| Failure::work(error.to_string()))?;
    let bytes = tree.to_bytes(&triangles);
    let figures = TreeFigures {
        meshes,
        motion: name_of(motion),
        triangles: triangles.len(),
        nodes: tree.node_count(),
        cost: tree.cost(1.0, 1.0),
        bytes: bytes.len(),
        build_ms: millis(start.elapsed()),
    };
    Ok((bytes, figures))
}

/// How often the progress of a build is reported.
const REPORT_INTERVAL: Duration = Duration::from_millis(100);

/// Builds a tree, while another thread reports the progress.
fn build_with_reports(
    triangles: &Triangles,
    options: &BuildOptions,
    report_fraction: &(dyn Fn(f64) + Sync),
) -> Result<MeshBvh, Cancelled> {
    let progress = BuildProgress::new();
    let (ended, end) = mpsc::channel::<()>();
    std::thread::scope(|scope| {
        let progress = &progress;
        scope.spawn(move || {
            // The loop ends when the sender is dropped.
            while end.recv_timeout(REPORT_INTERVAL) == Err(RecvTimeoutError::Timeout) {
                report_fraction(progress.progress().into());
            }
            report_fraction(progress.progress().into());
        });
        let tree = build::build_with_progress(triangles, options, progress);
        drop(ended);
        tree
    })
}

/// The figures that are printed.
#[derive(Debug, Serialize)]
struct Summary {
    scene: String,
    file: String,
    /// Length of the file.
    bytes: usize,
    quality: &'static str,
    threads: usize,
    /// Meshes in the scene.
    meshes: usize,
    /// Deforming and dynamic meshes, whose trees are built at run time.
    left_out: usize,
    load_ms: f64,
    bake_ms: f64,
    trees: Vec<TreeFigures>,
}

/// Figures of one tree in the file.
#[derive(Debug, Serialize)]
struct TreeFigures {
    /// The meshes that use it, numbered as `inspect` numbers them; equal meshes share one tree.
    meshes: Vec<usize>,
    motion: &'static str,
    triangles: usize,
    nodes: usize,
    /// The expected cost of a ray that hits the root, in visits of nodes and tests of blocks of
    /// four triangles.
    cost: f32,
    bytes: usize,
    build_ms: f64,
}

impl fmt::Display for Summary {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let triangles: usize = self.trees.iter().map(|tree| tree.triangles).sum();
        let nodes: usize = self.trees.iter().map(|tree| tree.nodes).sum();
        let served: usize = self.trees.iter().map(|tree| tree.meshes.len()).sum();
        writeln!(f, "{}", self.file)?;
        writeln!(
            f,
            "  scene      {}: {}, {} of them static or rigid",
            self.scene,
            figures::of(self.meshes as u64, "mesh", "meshes"),
            count(served as u64)
        )?;
        writeln!(
            f,
            "  trees      {} over {}, {} nodes, {} quality",
            figures::of(self.trees.len() as u64, "tree", "trees"),
            figures::of(triangles as u64, "triangle", "triangles"),
            count(nodes as u64),
            self.quality
        )?;
        writeln!(f, "  file       {}", bytes(self.bytes as u64))?;
        let threads = figures::of(self.threads as u64, "thread", "threads");
        write!(f, "  time       {:.1} ms, {threads}; load {:.1} ms", self.bake_ms, self.load_ms)
    }
}
