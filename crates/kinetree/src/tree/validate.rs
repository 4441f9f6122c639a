//! Does a tree keep its promises?

use thiserror::Error;

use super::{Bvh, MAX_DEPTH, Target};

/// The first promise of a [`Bvh`] that does not hold, and where.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum Violation {
    /// Promise 1.
    #[error("promise 1: there are {primitives} primitives, but no root")]
    NoRoot {
        /// How many.
        primitives: usize,
    },
    /// Promise 2.
    #[error("promise 2: the children of node {node} would be {first} and the next, of {count} nodes")]
    NoChildren {
        /// The parent.
        node: usize,
        /// The first child.
        first: u32,
        /// How many nodes there are.
        count: usize,
    },
    /// Promise 3.
    #[error("promise 3: node {child} reaches out of its parent {parent}")]
    OutsideParent {
        /// The parent.
        parent: usize,
        /// The child.
        child: usize,
    },
    /// Promise 3, for a leaf.
    #[error("promise 3: the box of leaf {node} is not a number")]
    NotANumber {
        /// The node.
        node: usize,
    },
    /// Promise 4.
    #[error("promise 4: leaf {node} holds the places {start}..{end} of {count}")]
    NoPrimitives {
        /// The leaf.
        node: usize,
        /// First place.
        start: u32,
        /// After the last place.
        end: u32,
        /// How many places there are.
        count: usize,
    },
    /// Promise 4.
    #[error("promise 4: primitive {primitive} is in {leaves} leaves")]
    WrongCount {
        /// The primitive, or the place in the list of primitives.
        primitive: u32,
        /// How often it was met.
        leaves: u32,
    },
    /// Promises 2 and 5.
    #[error("promise 5: node {child} does not stand after its parent {parent}, or has two parents")]
    OutOfOrder {
        /// The parent.
        parent: usize,
        /// The child.
        child: usize,
    },
    /// Promise 5.
    #[error("promise 5: node {node} has no parent")]
    Orphan {
        /// The node.
        node: usize,
    },
    /// Promise 6.
    #[error("promise 6: node {node} lies {depth} deep, and {MAX_DEPTH} is the limit")]
    TooDeep {
        /// The node.
        node: usize,
        /// The length of its path.
        depth: usize,
    },
}

impl Bvh {
    /// Checks promises 1 to 6.
    ///
    /// # Errors
    /// The first promise that does not hold, and where.
    pub fn validate(&self) -> Result<(), Violation> {
        let nodes = self.nodes();
        if nodes.is_empty() {
            let primitives = self.primitives().len();
            return if primitives == 0 { Ok(()) } else { Err(Violation::NoRoot { primitives }) };
        }
        // Depth of a node once its parent has been met; zero until then.
        let mut depth_of = vec![0_usize; nodes.len()];
        let mut met = vec![0_u32; self.primitives().len()];
        depth_of[0] = 1;
        for (at, node) in nodes.iter().enumerate() {
            let depth = depth_of[at];
            if depth == 0 {
                return Err(Violation::Orphan { node: at });
            }
            if depth > MAX_DEPTH {
                return Err(Violation::TooDeep { node: at, depth });
            }
            if node.bounds.min.iter().chain(&node.bounds.max).any(|x| x.is_nan()) {
                return Err(Violation::NotANumber { node: at });
            }
            match node.link.target() {
                Target::Node(first) => {
                    if first as usize + 1 >= nodes.len() {
                        return Err(Violation::NoChildren { node: at, first, count: nodes.len() });
                    }
                    for child in [first as usize, first as usize + 1] {
                        if child <= at || depth_of[child] != 0 {
                            return Err(Violation::OutOfOrder { parent: at, child });
                        }
                        if !node.bounds.contains(&nodes[child].bounds) {
                            return Err(Violation::OutsideParent { parent: at, child });
                        }
                        depth_of[child] = depth + 1;
                    }
                }
                Target::Primitives(range) => {
                    let count = met.len();
                    let Some(places) = met.get_mut(range.start as usize..range.end as usize) else {
                        return Err(Violation::NoPrimitives { node: at, start: range.start, end: range.end, count });
                    };
                    places.iter_mut().for_each(|place| *place += 1);
                }
            }
        }
        // Each place of the list belongs to one leaf; each primitive has one place, or more in a tree with duplicates.
        if let Some(place) = met.iter().position(|&leaves| leaves != 1) {
            return Err(Violation::WrongCount { primitive: place as u32, leaves: met[place] });
        }
        let mut numbers = self.primitives().to_vec();
        numbers.sort_unstable();
        let duplicate = numbers.windows(2).find(|pair| pair[0] == pair[1]).map(|pair| pair[0]);
        numbers.dedup();
        if numbers.len() != self.primitive_count() {
            return Err(Violation::WrongCount { primitive: duplicate.unwrap_or(0), leaves: 2 });
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Aabb;
    use crate::tree::{Link, Node};

    const BIG: Aabb = Aabb::new([0.0; 3], [9.0; 3]);
    const SMALL: Aabb = Aabb::new([1.0; 3], [2.0; 3]);

    fn inner(bounds: Aabb, first: u32) -> Node {
        Node { bounds, link: Link::node(first) }
    }

    fn leaf(bounds: Aabb, place: u32) -> Node {
        Node { bounds, link: Link::primitives(place..place + 1) }
    }

    fn check(nodes: Vec<Node>, primitives: Vec<u32>) -> Result<(), Violation> {
        let distinct = primitives.len() as u32;
        Bvh::from_parts(nodes, primitives, distinct).validate()
    }

    #[test]
    fn a_tree_that_keeps_its_promises_passes() {
        assert_eq!(Bvh::default().validate(), Ok(()));
        assert_eq!(check(vec![inner(BIG, 1), leaf(SMALL, 0), leaf(BIG, 1)], vec![0, 1]), Ok(()));
    }

    #[test]
    fn every_broken_promise_is_named() {
        assert_eq!(check(vec![], vec![7]), Err(Violation::NoRoot { primitives: 1 }));
        assert!(matches!(check(vec![inner(BIG, 1)], vec![]), Err(Violation::NoChildren { .. })));
        assert!(matches!(
            check(vec![inner(SMALL, 1), leaf(BIG, 0), leaf(SMALL, 1)], vec![0, 1]),
            Err(Violation::OutsideParent { parent: 0, child: 1 })
        ));
        let twice = vec![inner(BIG, 1), leaf(SMALL, 0), leaf(SMALL, 0)];
        assert!(matches!(check(twice, vec![0]), Err(Violation::WrongCount { leaves: 2, .. })));
        let same = vec![inner(BIG, 1), leaf(SMALL, 0), leaf(SMALL, 1)];
        assert!(matches!(check(same, vec![5, 5]), Err(Violation::WrongCount { primitive: 5, .. })));
        assert!(matches!(check(vec![leaf(BIG, 3)], vec![0]), Err(Violation::NoPrimitives { .. })));
        let circle = vec![inner(BIG, 0), leaf(SMALL, 0)];
        assert!(matches!(check(circle, vec![0]), Err(Violation::OutOfOrder { child: 0, .. })));
        let orphan = vec![leaf(BIG, 0), leaf(BIG, 1)];
        assert!(matches!(check(orphan, vec![0, 1]), Err(Violation::Orphan { node: 1 })));
        // Each inner node's children are the leaf and the inner node that follow it; the last gets two leaves.
        let count = MAX_DEPTH as u32;
        let chain = std::iter::once(inner(BIG, 1))
            .chain((1..count).flat_map(|i| [leaf(BIG, i - 1), inner(BIG, i * 2 + 1)]))
            .chain([leaf(BIG, count - 1), leaf(BIG, count)])
            .collect();
        assert!(matches!(check(chain, (0..=count).collect()), Err(Violation::TooDeep { .. })));
        assert!(matches!(
            check(vec![leaf(Aabb::new([f32::NAN; 3], [0.0; 3]), 0)], vec![0]),
            Err(Violation::NotANumber { .. })
        ));
    }
}
