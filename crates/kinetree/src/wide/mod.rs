//! The eight-way tree, its leaves and its promises.

mod block;
mod bytes;
mod collapse;
mod containment;
mod costs;
mod instance;
mod collapse_costs;
mod leaves;
mod link;
mod measure;
mod mesh_bvh;
mod node;
mod node_view;
mod one_node;
mod refit;
mod top_level_bvh;
mod wide_bvh;

pub use block::TriangleBlock;
pub use bytes::{TreeFileError, fingerprint_in};
pub(crate) use costs::Costs;
pub use instance::InstanceRecord;
pub use link::{WideLink, WideTarget};
pub(crate) use measure::RayCost;
pub use mesh_bvh::MeshBvh;
pub use node::{LANES, WideNode};
pub(crate) use node_view::NodeView;
pub use top_level_bvh::TopLevelBvh;
pub(crate) use wide_bvh::WIDE_STACK;
pub use wide_bvh::WideBvh;
