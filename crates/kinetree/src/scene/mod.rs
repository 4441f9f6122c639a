//! Meshes, poses, nodes, instances, frames and snapshots: what a game edits, and what it queries.
//!
//! A frame has phases. Edits are recorded (`edit`); [`Scene::commit`] brings every tree up to date
//! (`commit`, with `mesh_commit` for one mesh and `top_level` for all instances) and returns a
//! [`Snapshot`], which queries share without locks and no later edit changes (`published`, and
//! `ring` for the buffers of one mesh).

mod commit;
mod contents;
mod edit;
mod error;
mod frame;
mod graph;
mod hierarchy_cache;
mod history;
mod input;
mod lookup;
mod mesh_state;
mod members;
mod mesh;
mod mesh_commit;
mod mesh_edits;
mod offset;
mod pose;
mod published;
mod report;
mod resolve;
mod ring;
mod skin;
mod slots;
mod snapshot;
mod top_level;
mod views;

pub use crate::handle::{InstanceId, MeshId, NodeId, Placed};
pub use contents::Scene;
pub use error::{EditError, ForeignHit, MeshError};
pub use input::{Indices, Positions};
pub use mesh::Mesh;
pub use pose::Pose;
pub use report::{FrameReport, MeshReport, TopLevelMethod, TopLevelReport};
pub use skin::{MorphTarget, Skin};
pub use snapshot::Snapshot;
pub use views::{InstanceView, MeshView};
