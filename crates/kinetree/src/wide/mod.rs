//! The eight-way tree and its promises, and what its leaves lead to.

mod block;
mod bytes;
mod collapse;
mod containment;
mod instance;
mod least;
mod leaves;
mod link;
mod measure;
mod mesh;
mod node;
mod refit;
mod top;
mod tree;

pub use block::TriangleBlock;
pub use bytes::{TreeFileError, fingerprint_in};
pub use instance::InstanceRecord;
pub use link::{WideLink, WideTarget};
pub(crate) use measure::RayCost;
pub use mesh::WideMesh;
pub(crate) use node::NodeRows;
pub use node::{LANES, WideNode};
pub use top::WideTop;
pub use tree::{WIDE_STACK, WideTree};
