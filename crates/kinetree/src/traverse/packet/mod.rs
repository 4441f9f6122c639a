//! Packets: sixty-four coherent rays that traverse a tree together.
//!
//! A node is fetched once for all of them. One test of intervals that contain all the rays rules
//! out most of its eight boxes at once; the others are tested by sixteen rays at a step, and each
//! triangle by those rays that reach its leaf.
//!
//! Interval tests after Boulos, Wald and Shirley 2006, "Geometric and Arithmetic Culling Methods
//! for Entire Ray Packets"; sets of active rays after Overbeck, Ramamoorthi and Mark 2008, "Large
//! Ray Packets for Real-time Whitted Ray Tracing".

mod interval;
mod planes;
mod rays;
mod watertight;
#[cfg(test)]
mod tests;
mod walk;

pub(crate) use interval::{Interval, octants};
pub(crate) use planes::PacketPlanes;
pub(crate) use rays::{Column, PACKET, RayPacket, lanes_of};
pub(crate) use walk::{PacketVisitor, walk_packet};
pub(crate) use watertight::WatertightPacket;
