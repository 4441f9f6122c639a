//! Ray tracing for game scenes that move.
//!
//! Each mesh has a tree (a BVH) of its own, built and updated by the method that suits how the mesh
//! moves; every frame, a tree over all instances combines them. A game *edits* a [`Scene`],
//! *commits*, and *queries* the [`Snapshot`] that the commit returns: on any number of threads,
//! without locks, while the next frame is edited and committed.
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
//! let view = scene.commit(); // commit: every tree is brought up to date
//! let hit = view.closest_hit(&Ray::new([0.2, 0.2, 0.0], [0.0, 0.0, -1.0])).unwrap(); // query
//! assert!((hit.t - 5.0).abs() < 1e-5);
//! # Ok(())
//! # }
//! ```
//!
//! What was hit is asked of the same snapshot, and shading goes on from there:
//!
//! ```
//! # use kinetree::{Affine, EditError, Mesh, Motion, Ray, Scene};
//! # fn main() -> Result<(), EditError> {
//! # let mut scene = Scene::new();
//! # let square = [[-9.0, 0.0, -9.0], [-9.0, 0.0, 9.0], [9.0, 0.0, 9.0], [9.0, 0.0, -9.0]];
//! # let floor = scene.add_mesh(Mesh::new(&square, &[[0, 1, 2], [0, 2, 3]])?, Motion::Static)?;
//! # let lamp = scene.add_instance(scene.root(), floor, Affine::IDENTITY)?;
//! # scene.set_user_id(lamp, 7)?;
//! # let view = scene.commit();
//! # let ray = Ray::new([0.5, 3.0, 0.25], [0.0, -1.0, 0.0]);
//! # let texture_coordinates = square.map(|[x, _, z]| [x, z]);
//! # let toward_light = [0.0, 1.0, 0.0];
//! if let Some(hit) = view.closest_hit(&ray) {
//!     let instance = view.instance(&hit); // its handle, mesh, placement, posed vertices
//!     let material = instance.user_id(); // the caller's own number
//!     let [u, v] = instance.interpolate(&hit, &texture_coordinates).unwrap();
//!     let in_shadow = view.occluded(&view.leave(&hit, toward_light)); // leaves the surface cleanly
//! #   assert_eq!((material, [u, v], in_shadow), (7, [0.5, 0.25], false));
//! }
//! # Ok(())
//! # }
//! ```
//!
//! # Modules
//!
//! Programs need little beyond the root of the crate. The modules stand in the order of their
//! layers: each uses only those above it.
//!
//! | module | contents |
//! |---|---|
//! | [`threads`] | where commits and builds run: rayon, one thread, or the caller's [`Executor`] |
//! | [`geometry`] | boxes, rays, triangles, placements; the watertight ray-triangle test |
//! | [`simd`] | the vector operations of the kernels, and the levels of the processor |
//! | [`tree`] | binary trees, which builders make; their numbered promises and `validate` |
//! | [`wide`] | eight-way trees, which rays walk: nodes, links, blocks of triangles, bytes |
//! | [`build`] | the builders, and options, progress and cancelling of a build |
//! | [`update`] | motions, refitting, drift, and the decision to keep, refit or rebuild |
//! | [`query`] | closest hit, occlusion, all hits; masks, culling, filters, exclusions, batches |
//! | [`scene`] | meshes, poses, nodes, instances, commits, snapshots, reports |
//! | [`tree_file`] | a file of many baked trees |
//!
//! # Conventions
//!
//! - **Handedness.** None is assumed: no axis is up or forward, but for [`Affine::look_at`], whose
//!   objects look along -z.
//! - **Transforms** are affine maps of column vectors, named `to_from_from`: `world_from_car *
//!   car_from_wheel` is `world_from_wheel`.
//! - **Winding.** The front of a triangle is the side from which its corners run counter-clockwise
//!   in right-handed coordinates. Mirrored instances keep their sides: outside stays outside.
//! - **Units.** Lengths are in any unit; the documentation says metres.
//! - **Distances.** [`Hit::t`] counts lengths of the ray's direction, which need not have length one.
//!   Rays are not normalised again on entering an instance, so `t` means the same whatever its scale.
//! - **Ties.** Of two hits at the same `t`, the one with the smaller (instance, primitive) wins, on
//!   every processor, for every tree and every number of threads.
//! - **Weights.** `u` and `v` of a hit are the weights of the second and third corner.
//!
//! # A recipe per motion
//!
//! | [`Motion`] | for | in a frame | what the commit does |
//! |---|---|---|---|
//! | `Static` | scenery | nothing | nothing |
//! | `Rigid` | cars, wheels, crates | [`Scene::place`] | moves instances; the mesh's tree is not touched |
//! | `Deforming` | cloth, trees in the wind, characters | [`Scene::set_positions`], [`Scene::pose`] | refits the tree; rebuilds it when its measured cost has risen too far |
//! | `Dynamic` | smoke, shards | [`Scene::set_triangles`] | builds a new tree, fast |
//!
//! *Rigid*, with wheels that turn as the car drives:
//!
//! ```
//! # use kinetree::{Affine, EditError, Mesh, Motion, Scene};
//! # fn drive(scene: &mut Scene, body: kinetree::MeshId, wheel: kinetree::MeshId) -> Result<(), EditError> {
//! # let (world_from_car, car_from_axle, turn) = (Affine::IDENTITY, Affine::IDENTITY, 0.3);
//! let car = scene.add_node(scene.root(), world_from_car)?;
//! let axle = scene.add_node(car, car_from_axle)?;
//! scene.add_instance(car, body, Affine::IDENTITY)?;
//! scene.add_instance(axle, wheel, Affine::IDENTITY)?;
//! // In each frame:
//! scene.place(car, world_from_car)?;
//! scene.place(axle, car_from_axle * Affine::from_axis_angle([1.0, 0.0, 0.0], turn))?;
//! # Ok(())
//! # }
//! ```
//!
//! *Deforming*, by positions that the game computes, or by skin and morph targets:
//!
//! ```
//! # use kinetree::{Affine, EditError, Mesh, Motion, Pose, Scene, Skin};
//! # fn act(scene: &mut Scene, cloth: Mesh, driver: Mesh, skin: Skin) -> Result<(), EditError> {
//! # let (moved, pose_from_rest) = (cloth.positions().to_vec(), vec![Affine::IDENTITY; 4]);
//! let cloth = scene.add_mesh(cloth, Motion::Deforming)?;
//! let driver = scene.add_mesh(driver.with_skin(skin)?, Motion::Deforming)?;
//! // In each frame:
//! scene.set_positions(cloth, &moved)?;
//! scene.pose(driver, &Pose { weights: &[], joints: &pose_from_rest })?;
//! # Ok(())
//! # }
//! ```
//!
//! *Dynamic*, other triangles in each frame, and *static*, with a tree that was baked beforehand:
//!
//! ```
//! # use kinetree::{BuildOptions, EditError, Mesh, Motion, Quality, Scene};
//! # fn smoke(scene: &mut Scene, track: Mesh, puffs: &[[f32; 3]], puff_indices: &[u16]) -> Result<(), EditError> {
//! let smoke = scene.add_mesh(Mesh::empty(), Motion::Dynamic)?;
//! scene.set_triangles(smoke, puffs, puff_indices)?; // in each frame
//!
//! let tree = track.bake(&BuildOptions::new().quality(Quality::Best)); // once, offline
//! let track = scene.add_mesh(track.with_tree(&tree)?, Motion::Static)?; // in the game
//! # Ok(())
//! # }
//! ```
//!
//! # Features
//!
//! | feature | |
//! |---|---|
//! | `parallel` (default) | commits and builds share their work between threads, through rayon |
//! | `serde` | placements, options, reports and handles are `Serialize` and `Deserialize` |
//! | `glam` | [`Affine`] from and to glam's affine types and to its `Mat4`; `&[Vec3]` as positions; vectors are [`Interpolate`] |
//! | `mint` | [`Affine`] from and to mint's 3x4 matrices; points and vectors convert to arrays by mint itself |
//!
//! Features add abilities. They leave layouts and results as they are.
//!
//! # Processor levels
//!
//! Kernels exist for AVX-512, AVX2 with FMA, NEON and plain Rust ([`simd::Level`]). The best one
//! that the processor has is chosen when the program runs; the environment variable `KINETREE_SIMD`
//! (`avx512`, `avx2`, `neon`, `scalar`) names another. Hits are the same to the bit at every level,
//! unless a mesh asks for [`Precision::Fast`].
//!
//! # Threads
//!
//! A [`Scene`] is edited and committed by one thread at a time. A commit runs on the calling thread
//! with help from a pool ([`Threads`]), and does not wait for other work in the pool. A
//! [`Snapshot`] is `Clone + Send + Sync + 'static`: query it anywhere, drop it anywhere. Queries
//! run on the calling thread, batches too. ARCHITECTURE.md of the repository tells what an
//! [`Executor`] must do.
//!
//! # Determinism
//!
//! The same edits give the same trees for any number of threads and at every processor level, and
//! the same hits, except on meshes that ask for [`Precision::Fast`]. [`Scene::commit`] decides by
//! expected costs, never by measured times. Only the times in a [`FrameReport`] differ.
//!
//! # Errors
//!
//! A mistake of the caller is an error value that says what happened: [`EditError`], [`MeshError`],
//! [`TreeFileError`], [`ForeignHit`]. After an error the scene is as it was. Non-finite coordinates
//! are refused; degenerate triangles are allowed; a ray that is not finite hits nothing; a handle
//! that is stale or of another scene is recognised. Functions that panic on a mistake say so under
//! *Panics*; any other panic is a bug. Bytes of trees are checked completely before they are used.
//!
//! # Rust version
//!
//! Rust 1.89 or newer. A rise of it is not a breaking change.
//!
//! # Debug builds
//!
//! Without optimisation rays take 25 to 75 times as long. Cargo builds dependencies with the
//! profile of the game, unless told otherwise: these lines in the game's `Cargo.toml` optimise the
//! library and leave the game's own code as it is.
//!
//! ```toml
//! [profile.dev.package.kinetree]
//! opt-level = 3
//! ```
//!
//! # When not to use it
//!
//! - Shapes that are not triangles: curves, voxels, points, subdivision surfaces, spheres.
//! - Motion blur within a frame, and more than one level of instancing.
//! - Rays on the graphics processor: kinetree runs on the CPU.
//! - Collision detection: there are no shape casts and no contacts.
//! - A static scene that is traced once: a library with one tree and no scene is less to learn.

#![warn(missing_debug_implementations)] // what a game holds can be printed

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

pub mod simd;
pub mod geometry;
pub mod tree;
pub mod wide;
pub mod build;
pub mod update;
mod traverse;
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
