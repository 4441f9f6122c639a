//! Ray tracing for game scenes that move.
//!
//! One acceleration structure per mesh, kept by the method that suits how the mesh moves; all of them combined every frame under a tree over the
//! instances. A game edits a [`Scene`], commits, and asks the [`Snapshot`] that it gets, from all threads, without locks:
//!
//! ```
//! use kinetree::{Affine, Mesh, Motion, Ray, Scene};
//!
//! # fn main() -> Result<(), kinetree::EditError> {
//! let mut scene = Scene::new();
//! let triangle = Mesh::new(&[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], &[[0, 1, 2]])?;
//! let body = scene.add_mesh(triangle, Motion::Rigid)?;
//! let car = scene.add_node(scene.root(), Affine::IDENTITY)?;
//! scene.add_instance(car, body, Affine::IDENTITY)?;
//!
//! scene.place(car, Affine::from_translation([0.0, 0.0, -5.0]))?; // edit: recorded
//! let view = scene.commit(); // commit: every tree brought up to date
//! let hit = view.closest_hit(&Ray::new([0.2, 0.2, 0.0], [0.0, 0.0, -1.0])).unwrap(); // query: from any thread
//! assert!((hit.t - 5.0).abs() < 1e-5);
//! # Ok(())
//! # }
//! ```
//!
//! # Debug builds
//!
//! Without optimisation rays take 25 to 75 times as long. Cargo builds dependencies as it builds
//! the game, unless told otherwise: these lines in the game's `Cargo.toml` optimise the library and
//! leave the game's own code as it is.
//!
//! ```toml
//! [profile.dev.package.kinetree]
//! opt-level = 3
//! ```
//!
//! # Map
//!
//! The modules stand in the order of their layers; each uses what stands before it only.

#![warn(missing_debug_implementations)] // reports and snapshots are printed while debugging a game

#[cfg(test)]
mod test_random;
mod build_progress;
#[cfg(feature = "parallel")]
mod crew;
pub mod threads;
mod clock;
mod memory;
mod digest;
mod handle;

pub mod geometry;
pub mod simd;
pub mod tree;
pub mod wide;
pub mod build;
pub mod update;
pub mod traverse;
pub mod query;
pub mod scene;
pub mod tree_file;

pub use build::{BuildOptions, BuildProgress, Cancelled, Quality};
pub use geometry::{Aabb, Affine, Interpolate, Precision, Ray};
pub use query::{Candidate, Coherence, Cull, Hit, Query};
pub use scene::{
    EditError, ForeignHit, FrameReport, Indices, InstanceId, InstanceView, Mesh, MeshError, MeshId, MeshReport,
    MeshView, MorphTarget, NodeId, Placed, Pose, Positions, Scene, Skin, Snapshot, TopLevelMethod, TopLevelReport,
};
pub use threads::{Executor, Threads};
pub use traverse::Work;
pub use tree::Bvh;
pub use tree_file::TreeFile;
pub use update::{Action, Motion, Reason};
pub use wide::{MeshBvh, TopLevelBvh, TreeFileError};
