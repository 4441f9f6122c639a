//! Traversal: one walk per kind of ray, compiled for many queries.

mod block;
mod choose;
mod hierarchy;
mod lanes;
mod packet;
mod frame_bvh;
mod wide;
mod work;

pub(crate) use block::WatertightLanes;
pub(crate) use frame_bvh::{FrameBvh, FrameStamp, MeshFrame};
pub(crate) use hierarchy::Hierarchy;
pub(crate) use hierarchy::Interval as InstanceInterval;
pub(crate) use lanes::{Boxes, DoublePrecisionRay, RayLanes, RayQuads};
pub(crate) use packet::{
    Column, Interval, PACKET, PacketPlanes, PacketVisitor, RayPacket, WatertightPacket, lanes_of, octants, walk_packet,
};
pub(crate) use wide::{WideVisitor, walk_wide};
pub(crate) use work::Tally;
pub use work::Work;
