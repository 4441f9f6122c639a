//! Checks the promises of a tree.

use super::{Bvh, Location, MAX_DEPTH, Target, Violation};

impl Bvh {
    /// Checks promises 1 to 7.
    ///
    /// # Errors
    /// The first promise that is broken, and where.
    pub fn validate(&self) -> Result<(), Violation> {
        let nodes = self.nodes();
        if nodes.is_empty() {
            let is_empty = self.primitives().is_empty();
            let without_root = Violation::new(1, "primitives without a root", Location::Node(0));
            return if is_empty { Ok(()) } else { Err(without_root) };
        }
        // Depth of each node whose parent has been visited; zero for the others.
        let mut depth_of = vec![0_usize; nodes.len()];
        let mut leaf_counts = vec![0_u32; self.primitives().len()];
        depth_of[0] = 1;
        for (at, node) in nodes.iter().enumerate() {
            let violation = |promise, what, node| Err(Violation::new(promise, what, Location::Node(node)));
            let depth = depth_of[at];
            if depth == 0 {
                return violation(5, "a node without a parent", at);
            }
            if depth > MAX_DEPTH {
                return violation(6, "a path that is too long", at);
            }
            if node.bounds.min.iter().chain(&node.bounds.max).any(|x| x.is_nan()) {
                return violation(3, "a box with a NaN", at);
            }
            match node.link.target() {
                Target::Node(first) => {
                    let first = first as usize;
                    if first + 1 >= nodes.len() {
                        return violation(2, "children beyond the last node", at);
                    }
                    for child in [first, first + 1] {
                        if child <= at || depth_of[child] != 0 {
                            return violation(5, "a child before its parent, or with two parents", child);
                        }
                        if !node.bounds.contains(&nodes[child].bounds) {
                            return violation(3, "a child that reaches out of its parent", child);
                        }
                        depth_of[child] = depth + 1;
                    }
                    if first % 2 == 0 {
                        return violation(7, "a pair of children that begins with an even number", first);
                    }
                }
                Target::Primitives(range) => {
                    let Some(entries) = leaf_counts.get_mut(range.start as usize..range.end as usize) else {
                        return violation(4, "a leaf that leads beyond the last primitive", at);
                    };
                    entries.iter_mut().for_each(|entry| *entry += 1);
                }
            }
        }
        // Each entry of the list belongs to one leaf; a primitive has one entry, or several in a
        // tree with duplicates.
        if let Some(entry) = leaf_counts.iter().position(|&leaves| leaves != 1) {
            let what = if leaf_counts[entry] == 0 { "a primitive in no leaf" } else { "a primitive that leaves share" };
            return Err(Violation::new(4, what, Location::Item(entry)));
        }
        let mut numbers = self.primitives().to_vec();
        numbers.sort_unstable();
        let duplicate = numbers.windows(2).find(|pair| pair[0] == pair[1]).map(|pair| pair[0]);
        numbers.dedup();
        if numbers.len() != self.primitive_count() {
            let location = Location::Primitive(duplicate.unwrap_or(0));
            return Err(Violation::new(4, "the number of distinct primitives is wrong", location));
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

    fn leaf(bounds: Aabb, entry: u32) -> Node {
        Node { bounds, link: Link::primitives(entry..entry + 1) }
    }

    fn check(nodes: Vec<Node>, primitives: Vec<u32>) -> Result<(), Violation> {
        let distinct = primitives.len() as u32;
        Bvh::from_parts(nodes, primitives, distinct).validate()
    }

    /// The broken promise, and where.
    fn broken(nodes: Vec<Node>, primitives: Vec<u32>) -> (u32, Location) {
        let violation = check(nodes, primitives).expect_err("a promise is broken");
        (violation.promise, violation.location)
    }

    #[test]
    fn a_tree_that_keeps_its_promises_passes() {
        assert_eq!(Bvh::default().validate(), Ok(()));
        assert_eq!(check(vec![inner(BIG, 1), leaf(SMALL, 0), leaf(BIG, 1)], vec![0, 1]), Ok(()));
    }

    #[test]
    fn every_broken_promise_is_named() {
        use Location::{Item, Node, Primitive};
        assert_eq!(broken(vec![], vec![7]), (1, Node(0)));
        assert_eq!(broken(vec![inner(BIG, 1)], vec![]), (2, Node(0)));
        assert_eq!(broken(vec![inner(SMALL, 1), leaf(BIG, 0), leaf(SMALL, 1)], vec![0, 1]), (3, Node(1)));
        assert_eq!(broken(vec![leaf(Aabb::new([f32::NAN; 3], [0.0; 3]), 0)], vec![0]), (3, Node(0)));
        let twice = vec![inner(BIG, 1), leaf(SMALL, 0), leaf(SMALL, 0)];
        assert_eq!(broken(twice, vec![0]), (4, Item(0)));
        let same = vec![inner(BIG, 1), leaf(SMALL, 0), leaf(SMALL, 1)];
        assert_eq!(broken(same, vec![5, 5]), (4, Primitive(5)));
        assert_eq!(broken(vec![leaf(BIG, 3)], vec![0]), (4, Node(0)));
        let cycle = vec![inner(BIG, 0), leaf(SMALL, 0)];
        assert_eq!(broken(cycle, vec![0]), (5, Node(0)));
        let orphan = vec![leaf(BIG, 0), leaf(BIG, 1)];
        assert_eq!(broken(orphan, vec![0, 1]), (5, Node(1)));
        // Each inner node has a leaf and the next inner node as children; the last one has two
        // leaves.
        let count = MAX_DEPTH as u32;
        let chain = std::iter::once(inner(BIG, 1))
            .chain((1..count).flat_map(|i| [leaf(BIG, i - 1), inner(BIG, i * 2 + 1)]))
            .chain([leaf(BIG, count - 1), leaf(BIG, count)])
            .collect();
        assert_eq!(broken(chain, (0..=count).collect()).0, 6);
        // A gap before the only pair: all other promises hold, but nodes 2 and 3 are not a pair.
        let shifted = vec![inner(BIG, 2), leaf(SMALL, 0), leaf(SMALL, 1), leaf(SMALL, 2)];
        assert_eq!(broken(shifted, vec![0, 1, 2]), (7, Node(2)));
    }
}
