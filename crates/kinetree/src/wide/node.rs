//! One wide node: eight boxes, tested at once.

use super::WideLink;
use crate::geometry::Aabb;

/// How many children a node has, at most.
pub const LANES: usize = 8;

/// Eight boxes and where they lead, in four cache lines. Both planes of an axis share a line.
///
/// A lane that is not in use has an empty box. The lanes in use come first, likelier blockers of shadow rays (larger boxes) before others.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(C, align(64))]
pub struct WideNode {
    /// `planes[axis][side][lane]`: side 0 is the lower plane, side 1 the upper one.
    pub(crate) planes: [[[f32; LANES]; 2]; 3],
    pub(crate) links: [u32; LANES],
    /// For each octant of directions, three bits per lane: the lanes from far to near. One byte more than that, so that four bytes can be read at once.
    order: [u8; 25],
    /// Lanes in use, one bit each.
    pub(crate) in_use: u8,
    spare: [u8; 2],
    /// The lane that leads here: eight times the number of the parent, plus the lane. Nothing for the root.
    pub(crate) parent_lane: u32,
}

const _: () = assert!(size_of::<WideNode>() == 256 && align_of::<WideNode>() == 64);

impl WideNode {
    pub(crate) fn new(parent_lane: u32) -> Self {
        Self {
            planes: [[[f32::INFINITY; LANES], [f32::NEG_INFINITY; LANES]]; 3],
            links: [0; LANES],
            order: [0; 25],
            in_use: 0,
            spare: [0; 2],
            parent_lane,
        }
    }

    /// The lanes from far to near for directions of an octant (bit 0: down the x axis, ...): three bits each, the farthest lowest.
    #[inline(always)]
    pub(crate) fn far_to_near(&self, octant: usize) -> u32 {
        let at = (octant & 7) * 3;
        u32::from_le_bytes([self.order[at], self.order[at + 1], self.order[at + 2], self.order[at + 3]])
    }

    /// Sorts the lanes by their middles, for every octant. Any order is right; a good one finds near hits first.
    pub(crate) fn sort_lanes(&mut self) {
        let middles = |axis: usize, lane: usize| {
            let sides = &self.planes[axis];
            let middle = sides[0][lane] + sides[1][lane];
            if middle.is_nan() { f32::INFINITY } else { middle }
        };
        let middles = [0, 1, 2].map(|axis| [0, 1, 2, 3, 4, 5, 6, 7].map(|lane| middles(axis, lane)));
        // The opposite octant has the opposite order.
        for octant in 0..4_usize {
            let sign = |axis: usize| if octant >> axis & 1 == 1 { -1.0 } else { 1.0 };
            let along = |lane: usize| middles[0][lane] * sign(0) + middles[1][lane] * sign(1) + middles[2][lane];
            let mut lanes = [0, 1, 2, 3, 4, 5, 6, 7];
            let keys = lanes.map(along);
            for i in 1..LANES {
                let mut at = i;
                while at > 0 && keys[lanes[at - 1]] > keys[lanes[at]] {
                    lanes.swap(at - 1, at);
                    at -= 1;
                }
            }
            let near_to_far = pack(lanes.iter());
            let far_to_near = pack(lanes.iter().rev());
            self.order[octant * 3..octant * 3 + 3].copy_from_slice(&far_to_near.to_le_bytes()[..3]);
            let opposite = octant ^ 7;
            self.order[opposite * 3..opposite * 3 + 3].copy_from_slice(&near_to_far.to_le_bytes()[..3]);
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

    /// Where a lane leads, if it is in use.
    pub fn link(&self, lane: usize) -> Option<WideLink> {
        (self.in_use >> lane & 1 == 1).then(|| WideLink::from_bits(self.links[lane]))
    }

    /// Lanes in use.
    pub fn lanes(&self) -> impl Iterator<Item = (usize, WideLink)> + '_ {
        (0..LANES).filter_map(|lane| Some((lane, self.link(lane)?)))
    }
}

/// Three bits per lane, the first one lowest.
fn pack<'a>(lanes: impl Iterator<Item = &'a usize>) -> u32 {
    lanes.zip(0..).fold(0, |packed, (lane, place)| packed | (*lane as u32) << (3 * place))
}
