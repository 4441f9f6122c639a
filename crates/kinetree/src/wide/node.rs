//! Nodes of the eight-way tree.

use super::WideLink;
use crate::geometry::Aabb;

/// The largest number of children of a node.
pub const LANES: usize = 8;

/// Eight boxes and their links, in four cache lines. Both planes of an axis share a cache line.
///
/// An unused lane has an empty box. The lanes in use come first, in the order in which any-hit
/// queries should visit them.
#[derive(Debug, Clone, Copy, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C, align(64))]
pub struct WideNode {
    /// `planes[axis][side][lane]`: side 0 is the lower plane, side 1 the upper one.
    pub(crate) planes: [[[f32; LANES]; 2]; 3],
    pub(crate) links: [u32; LANES],
    /// Lanes in use, one bit each.
    pub(crate) in_use: u8,
    spare: [u8; 27],
    /// The parent's lane that links here: eight times the index of the parent, plus the lane.
    /// `u32::MAX` for the root.
    pub(crate) parent_lane: u32,
}

const _: () = assert!(size_of::<WideNode>() == 256 && align_of::<WideNode>() == 64);

/// A node as rows of eight: row `2 * axis + side` has planes, row [`LINKS`] has links.
pub(crate) const ROWS: usize = 8;
pub(crate) const LINKS: usize = 6;
const _: () = assert!(size_of::<WideNode>() == ROWS * size_of::<[f32; LANES]>());
const _: () = assert!(std::mem::offset_of!(WideNode, links) == LINKS * size_of::<[f32; LANES]>());

impl WideNode {
    pub(crate) fn new(parent_lane: u32) -> Self {
        Self {
            planes: [[[f32::INFINITY; LANES], [f32::NEG_INFINITY; LANES]]; 3],
            links: [0; LANES],
            in_use: 0,
            spare: [0; 27],
            parent_lane,
        }
    }

    /// Uses the next lane, after those in use.
    pub(super) fn set_lane(&mut self, lane: usize, bounds: &Aabb, link: WideLink) {
        self.set_box(lane, bounds);
        self.links[lane] = link.bits();
        self.in_use |= 1 << lane;
    }

    pub(crate) fn set_box(&mut self, lane: usize, bounds: &Aabb) {
        for axis in 0..3 {
            self.planes[axis][0][lane] = bounds.min[axis];
            self.planes[axis][1][lane] = bounds.max[axis];
        }
    }

    /// The box of a lane.
    #[inline]
    pub fn bounds(&self, lane: usize) -> Aabb {
        Aabb::new([0, 1, 2].map(|axis| self.planes[axis][0][lane]), [0, 1, 2].map(|axis| self.planes[axis][1][lane]))
    }

    /// The box around all lanes.
    pub fn all_bounds(&self) -> Aabb {
        (0..LANES).fold(Aabb::EMPTY, |all, lane| all.union(&self.bounds(lane)))
    }

    /// The sum of the half areas of all boxes, each times the cost of visiting its child.
    pub(crate) fn cost_of_lanes(&self, node_cost: f32, item_cost: f32) -> f64 {
        let cost_of = |link: WideLink| if link.is_leaf() { item_cost * link.item_count() as f32 } else { node_cost };
        self.lanes().map(|(lane, link)| f64::from(self.bounds(lane).half_area()) * f64::from(cost_of(link))).sum()
    }

    /// The link of a lane, if it is in use.
    pub fn link(&self, lane: usize) -> Option<WideLink> {
        (self.in_use >> lane & 1 == 1).then(|| WideLink::from_bits(self.links[lane]))
    }

    /// The lanes in use and their links.
    pub fn lanes(&self) -> impl Iterator<Item = (usize, WideLink)> + '_ {
        (0..LANES).filter_map(|lane| Some((lane, self.link(lane)?)))
    }
}
