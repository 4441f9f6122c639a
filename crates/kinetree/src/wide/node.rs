//! One wide node: eight boxes, tested at once.

use super::WideLink;
use crate::geometry::Aabb;

/// How many children a node has, at most.
pub const LANES: usize = 8;

/// Eight boxes and where they lead, in four cache lines. Both planes of an axis share a line.
///
/// A lane that is not in use has an empty box. The lanes in use come first, in the order in which they are best looked at where any hit will do.
#[derive(Debug, Clone, Copy, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C, align(64))]
pub struct WideNode {
    /// `planes[axis][side][lane]`: side 0 is the lower plane, side 1 the upper one.
    pub(crate) planes: [[[f32; LANES]; 2]; 3],
    pub(crate) links: [u32; LANES],
    /// Lanes in use, one bit each.
    pub(crate) in_use: u8,
    spare: [u8; 27],
    /// The lane that leads here: eight times the number of the parent, plus the lane. Nothing for the root.
    pub(crate) parent_lane: u32,
}

const _: () = assert!(size_of::<WideNode>() == 256 && align_of::<WideNode>() == 64);

/// A node as rows of eight: number `2 * axis + side` has planes, [`LINKS`] has links.
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

    /// The half areas of all boxes, each weighed by what it takes to visit what it leads to.
    pub(crate) fn cost_of_lanes(&self, node_cost: f32, item_cost: f32) -> f64 {
        let cost_of = |link: WideLink| if link.is_leaf() { item_cost * link.item_count() as f32 } else { node_cost };
        self.lanes().map(|(lane, link)| f64::from(self.bounds(lane).half_area()) * f64::from(cost_of(link))).sum()
    }

    /// Where a lane leads, if it is in use.
    pub fn link(&self, lane: usize) -> Option<WideLink> {
        (self.in_use >> lane & 1 == 1).then(|| WideLink::from_bits(self.links[lane]))
    }

    /// Lanes in use.
    pub fn lanes(&self) -> impl Iterator<Item = (usize, WideLink)> + '_ {
        (0..LANES).filter_map(|lane| Some((lane, self.link(lane)?)))
    }
}
