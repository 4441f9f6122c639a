//! `kinetree inspect`: reports what a scene consists of and what its trees are like, and checks
//! them.

mod text;

use std::collections::HashMap;

use kinetree::{MeshId, MeshView, Motion, Snapshot};
use kinetree_gltf::ClipInfo;
use kinetree_world::Frame;
use serde::Serialize;

use crate::args::{Common, InspectArgs};
use crate::failure::Failure;
use crate::figures::{self, millis};
use crate::output::{print_to_stderr, report};
use crate::scene;
use crate::summary::{MemoryFigures, SceneFigures};
use crate::trees::{CommitFigures, MOTIONS, TreeFigures, name_of};

/// Prints the report; fails if any tree is not valid.
pub(crate) fn run(args: &InspectArgs, common: &Common) -> Result<(), Failure> {
    let mut opened = scene::open(args.scene.as_deref(), args.clip.as_ref(), args.trees.as_deref())?;
    if !common.quiet {
        opened.notes.iter().for_each(|note| print_to_stderr(&format!("{}: {note}", opened.name)));
    }
    let frame = opened.frame(args.time)?;
    let duration = opened.world.animation.duration();
    let meshes = meshes(&frame.snapshot);
    let inspection = Inspection {
        scene: SceneFigures::of(&opened.name, duration, &frame, opened.has_default_lighting, &opened.notes),
        time_s: args.time,
        load_ms: millis(opened.load_time),
        first_commit: CommitFigures::of(&opened.first_commit),
        commit: CommitFigures::of(frame.snapshot.report()),
        memory: MemoryFigures::of(frame.snapshot.report(), &frame.material_set),
        appearance: AppearanceFigures::of(&frame),
        cameras: opened.world.cameras.iter().map(|source| source.name.clone()).collect(),
        clips: opened.clips.iter().map(ClipFigures::of).collect(),
        motions: MOTIONS.map(|(motion, name)| MotionFigures::of(&meshes, motion, name)).into(),
        top_level: TreeFigures::of_top_level(frame.snapshot.top_level()),
        meshes,
    };
    report(&inspection, || inspection.text(if args.all { usize::MAX } else { SHOWN }), common, false)?;
    inspection.verdict()
}

/// How many meshes the table shows unless all are requested.
const SHOWN: usize = 20;

/// All figures of a scene at one time.
#[derive(Debug, Serialize)]
struct Inspection {
    scene: SceneFigures,
    time_s: f64,
    load_ms: f64,
    first_commit: CommitFigures,
    commit: CommitFigures,
    memory: MemoryFigures,
    appearance: AppearanceFigures,
    cameras: Vec<String>,
    clips: Vec<ClipFigures>,
    motions: Vec<MotionFigures>,
    top_level: TreeFigures,
    meshes: Vec<MeshFigures>,
}

/// Counts of what gives the scene its appearance.
#[derive(Debug, Serialize)]
struct AppearanceFigures {
    materials: usize,
    textures: usize,
    lights: usize,
}

/// An animation of the file.
#[derive(Debug, Serialize)]
struct ClipFigures {
    name: Option<String>,
    is_played: bool,
}

impl ClipFigures {
    fn of(clip: &ClipInfo) -> Self {
        Self { name: clip.name.clone(), is_played: clip.is_played }
    }
}

/// Totals of the meshes with one `Motion`, whether or not they have instances.
#[derive(Debug, Serialize)]
struct MotionFigures {
    motion: &'static str,
    meshes: usize,
    triangles: u64,
    instances: usize,
    instanced_triangles: u64,
}

/// Figures of one mesh.
#[derive(Debug, Serialize)]
struct MeshFigures {
    /// The index of the mesh in the scene.
    number: usize,
    triangles: usize,
    /// Instances in the frame.
    instances: usize,
    action: String,
    reason: String,
    drift: f32,
    seen: SeenMesh,
}

/// The geometry and tree of a mesh in this frame, whether or not it has instances.
#[derive(Debug, Serialize)]
struct SeenMesh {
    motion: &'static str,
    #[serde(skip)]
    kind: Motion,
    vertices: usize,
    /// Positions, normals and vertex numbers.
    geometry_bytes: usize,
    tree: TreeFigures,
}

impl MeshFigures {
    fn bytes(&self) -> usize {
        self.seen.geometry_bytes + self.seen.tree.bytes
    }
}

/// The figures of all meshes of the scene.
fn meshes(view: &Snapshot) -> Vec<MeshFigures> {
    // Only looked up, never iterated: the order of a hash map varies.
    let mut instances: HashMap<MeshId, usize> = HashMap::new();
    for instance in view.instances() {
        *instances.entry(instance.mesh_id()).or_insert(0) += 1;
    }
    let figures = |(number, mesh): (usize, MeshView<'_>)| {
        let report = mesh.report();
        MeshFigures {
            number,
            triangles: report.triangles,
            instances: instances.get(&mesh.id()).copied().unwrap_or(0),
            action: report.action.to_string(),
            reason: report.reason.to_string(),
            drift: report.drift,
            seen: seen(&mesh),
        }
    };
    view.meshes().enumerate().map(figures).collect()
}

fn seen(mesh: &MeshView<'_>) -> SeenMesh {
    let kind = mesh.motion();
    SeenMesh {
        motion: name_of(kind),
        kind,
        vertices: mesh.positions().len(),
        geometry_bytes: size_of_val(mesh.positions())
            + size_of_val(mesh.normals().unwrap_or_default())
            + size_of_val(mesh.triangles()),
        tree: TreeFigures::of_mesh(mesh.bvh()),
    }
}

impl AppearanceFigures {
    fn of(frame: &Frame) -> Self {
        let material_set = &frame.material_set;
        Self {
            materials: material_set.materials.len(),
            textures: material_set.textures.len(),
            lights: frame.lights.len(),
        }
    }
}

impl MotionFigures {
    fn of(meshes: &[MeshFigures], kind: Motion, motion: &'static str) -> Self {
        let mut figures = Self { motion, meshes: 0, triangles: 0, instances: 0, instanced_triangles: 0 };
        for mesh in meshes.iter().filter(|mesh| mesh.seen.kind == kind) {
            figures.meshes += 1;
            figures.triangles += mesh.triangles as u64;
            figures.instances += mesh.instances;
            figures.instanced_triangles += mesh.triangles as u64 * mesh.instances as u64;
        }
        figures
    }
}

impl Inspection {
    /// Fails if any tree breaks a promise, and names the first.
    fn verdict(&self) -> Result<(), Failure> {
        let top_level = self.top_level.violation.iter().map(|violation| format!("top level: {violation}"));
        let of_mesh = |mesh: &MeshFigures| {
            let violation = mesh.seen.tree.violation.as_ref()?;
            Some(format!("mesh {}: {violation}", mesh.number))
        };
        let broken: Vec<String> = top_level.chain(self.meshes.iter().filter_map(of_mesh)).collect();
        match broken.first() {
            None => Ok(()),
            Some(first) => {
                let trees = figures::of(broken.len() as u64, "tree is", "trees are");
                Err(Failure::work(format!("{}: {trees} not valid: {first}", self.scene.name)))
            }
        }
    }
}
