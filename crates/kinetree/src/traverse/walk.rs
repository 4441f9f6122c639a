//! The walk through a binary tree: nearer children first, what lies too far is skipped.

use std::ops::{ControlFlow, Range};

use super::Tally;
use crate::geometry::Aabb;
use crate::tree::{Bvh, MAX_DEPTH, Target};

/// A question that a walk is compiled for.
pub trait Visitor<T: Tally> {
    /// Where a box is entered, if what lies in it matters still.
    fn enter(&mut self, bounds: &Aabb) -> Option<f32>;

    /// Boxes that are entered beyond this do not matter any more.
    fn limit(&self) -> f32;

    /// What stands at these places of the tree's list of primitives. `Break` ends the walk.
    fn leaf(&mut self, places: Range<u32>, tally: &mut T) -> ControlFlow<()>;
}

/// Visits the leaves whose boxes are entered, nearer ones first.
pub fn walk<T: Tally>(tree: &Bvh, visitor: &mut impl Visitor<T>, tally: &mut T) {
    let nodes = tree.nodes();
    // A walk keeps one node aside per level at most, so promise 6 bounds the stack.
    let mut stack = [(0_u32, 0.0_f32); MAX_DEPTH];
    let mut aside = 0;
    let Some(root) = nodes.first() else { return };
    if visitor.enter(&root.bounds).is_none() {
        return;
    }
    let mut at = 0;
    loop {
        tally.node();
        let next = match nodes[at as usize].link.target() {
            Target::Node(left) => {
                let right = left + 1;
                match (visitor.enter(&nodes[left as usize].bounds), visitor.enter(&nodes[right as usize].bounds)) {
                    (Some(one), Some(other)) => {
                        let (near, far) = if other < one { (right, (left, one)) } else { (left, (right, other)) };
                        stack[aside] = far;
                        aside += 1;
                        Some(near)
                    }
                    (Some(_), None) => Some(left),
                    (None, Some(_)) => Some(right),
                    (None, None) => None,
                }
            }
            Target::Primitives(places) => {
                tally.leaf();
                if visitor.leaf(places, tally).is_break() {
                    return;
                }
                None
            }
        };
        at = match next {
            Some(child) => child,
            None => loop {
                if aside == 0 {
                    return;
                }
                aside -= 1;
                let (node, entry) = stack[aside];
                if entry <= visitor.limit() {
                    break node;
                }
            },
        };
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::build::{BuildOptions, build_binned};
    use crate::geometry::slab::ErrorBound;
    use crate::geometry::{Ray, SafeRay};
    use crate::traverse::Work;

    /// Notes the primitives whose leaves are entered.
    struct Entered<'a> {
        ray: SafeRay,
        tree: &'a Bvh,
        found: Vec<u32>,
    }

    impl<T: Tally> Visitor<T> for Entered<'_> {
        fn enter(&mut self, bounds: &Aabb) -> Option<f32> {
            self.ray.enter(bounds, 50.0)
        }

        fn limit(&self) -> f32 {
            50.0
        }

        fn leaf(&mut self, places: Range<u32>, _: &mut T) -> ControlFlow<()> {
            self.found.extend(&self.tree.primitives()[places.start as usize..places.end as usize]);
            ControlFlow::Continue(())
        }
    }

    #[test]
    fn the_walk_comes_to_every_box_that_is_entered() {
        let boxes: Vec<Aabb> = (0..1000)
            .map(|i| {
                let at = [(i * 7 % 31) as f32, (i * 13 % 37) as f32, (i * 17 % 41) as f32];
                Aabb::new(at, at.map(|x| x + 0.8))
            })
            .collect();
        let options = BuildOptions { max_leaf: 1, ..BuildOptions::default() };
        let tree = build_binned(boxes.len(), |i| boxes[i as usize], &options);
        for i in 0..500 {
            let direction = [(i % 7) as f32 - 3.1, (i % 11) as f32 - 4.9, (i % 13) as f32 - 6.2];
            let ray = SafeRay::new(
                &Ray::new([15.0, 18.0, 20.0], direction).validated().unwrap(),
                &tree.bounds(),
                ErrorBound::TRIANGLES,
            );
            let mut work = Work::default();
            let mut visitor = Entered { ray, tree: &tree, found: Vec::new() };
            walk(&tree, &mut visitor, &mut work);
            visitor.found.sort_unstable();
            let expected: Vec<u32> = (0..1000).filter(|&i| ray.enter(&boxes[i as usize], 50.0).is_some()).collect();
            assert_eq!(visitor.found, expected);
            assert!(work.nodes < tree.node_count() as u64);
        }
    }
}
