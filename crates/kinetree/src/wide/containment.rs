//! Checks that the boxes of a tree contain its triangles, for trees that were built, refitted or
//! read.

use super::{MeshBvh, WideTarget};
use crate::geometry::Aabb;
use crate::tree::{Location, Violation};

impl MeshBvh {
    /// Checks promises 1 to 10: those of the tree, and that its boxes bound its triangles tightly.
    ///
    /// # Errors
    /// The first promise that is broken, and where.
    pub fn validate(&self) -> Result<(), Violation> {
        self.tree().validate()?;
        if self.tree().item_count() != self.blocks().len() {
            return Err(Violation::new(8, "blocks that are in no leaf", Location::Item(self.tree().item_count())));
        }
        self.check_triangles()
    }

    fn check_triangles(&self) -> Result<(), Violation> {
        let violation = |promise, what, location| Err(Violation::new(promise, what, location));
        // For each triangle, the union of the boxes of its leaves; `None` while no leaf was found.
        let last = self.blocks().iter().flat_map(|block| block.primitives()).max();
        let mut leaves: Vec<Option<Aabb>> = vec![None; last.map_or(0, |&last| last as usize + 1)];
        let mut distinct = 0;
        for node in self.tree().nodes() {
            for (lane, link) in node.lanes() {
                let WideTarget::Items(blocks) = link.target() else { continue };
                for block in &self.blocks()[blocks.start as usize..blocks.end as usize] {
                    for &primitive in block.primitives() {
                        let so_far = &mut leaves[primitive as usize];
                        distinct += usize::from(so_far.is_none());
                        *so_far = Some(so_far.unwrap_or(Aabb::EMPTY).union(&node.bounds(lane)));
                    }
                }
            }
        }
        if distinct != self.primitive_count() {
            let missing = leaves.iter().position(Option::is_none).unwrap_or(leaves.len());
            return violation(8, "a triangle in no leaf", Location::Primitive(missing as u32));
        }
        let mut all = Aabb::EMPTY;
        for block in self.blocks() {
            for (lane, &primitive) in block.primitives().iter().enumerate() {
                let triangle = block.bounds_of(lane);
                if !leaves[primitive as usize].is_some_and(|leaves| leaves.contains(&triangle)) {
                    return violation(9, "a triangle that reaches out of its leaves", Location::Primitive(primitive));
                }
                all = all.union(&triangle);
            }
        }
        // By promise 3, all other boxes are within this one.
        match all.contains(&self.bounds()) {
            true => Ok(()),
            false => violation(10, "a box that reaches beyond all triangles", Location::Node(0)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::build::{self, BuildOptions, Quality};
    use crate::geometry::Triangles;
    use crate::wide::LANES;

    /// The number of test triangles.
    const COUNT: u32 = 300;

    /// Long thin diagonal triangles.
    fn needles() -> Triangles {
        // Steps of irrational length fill a range evenly.
        let within = |i: u32, step: f32| (i as f32 * step).fract() * 2.0 - 1.0;
        let corner = |i: u32| {
            let at = |which: f32| [0.618, 0.414, 0.732].map(|step| within(i / 3, step + which));
            let (from, to) = (at(0.0), at(0.145));
            match i % 3 {
                0 => from,
                1 => [0, 1, 2].map(|axis| from[axis] + to[axis]),
                _ => [0, 1, 2].map(|axis| from[axis] + to[axis] + 0.01 * axis as f32),
            }
        };
        let indices: Vec<[u32; 3]> = (0..COUNT).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
        let triangles = Triangles::new((0..3 * COUNT).map(corner).collect(), indices.into());
        triangles.expect("all indices are in range")
    }

    fn tree(quality: Quality) -> MeshBvh {
        let options = BuildOptions { quality, ..BuildOptions::default() };
        MeshBvh::new(&build::build_triangles(&needles(), &options), &needles())
    }

    /// The result of `validate` after the box of a leaf is replaced, with its ancestors' boxes
    /// updated for promise 3.
    fn verdict(tree: &MeshBvh, node: usize, lane: usize, bounds: Aabb) -> Result<(), Violation> {
        let mut changed = tree.clone();
        changed.tree.nodes[node].set_box(lane, &bounds);
        let mut at = node;
        while at > 0 {
            let (all, up) = (changed.tree.nodes[at].all_bounds(), changed.tree.nodes[at].parent_lane as usize);
            at = up / LANES;
            changed.tree.nodes[at].set_box(up % LANES, &all);
        }
        changed.tree.bounds = changed.tree.nodes[0].all_bounds();
        changed.validate()
    }

    #[test]
    fn a_leaf_that_is_a_rounding_too_small_or_a_root_that_is_too_large_is_found() {
        for quality in [Quality::Fastest, Quality::Fast, Quality::Balanced] {
            let tree = tree(quality);
            assert_eq!(tree.validate(), Ok(()));
            for (node, wide) in tree.tree().nodes().iter().enumerate() {
                for (lane, _) in wide.lanes().filter(|(_, link)| link.is_leaf()) {
                    for axis in 0..3 {
                        let mut small = wide.bounds(lane);
                        small.min[axis] = small.min[axis].next_up();
                        let promise = verdict(&tree, node, lane, small).map_err(|violation| violation.promise);
                        assert_eq!(promise, Err(9), "{quality:?}, node {node}, lane {lane}, axis {axis}");
                        for far in [tree.bounds().max[axis].next_up(), f32::INFINITY] {
                            let mut large = wide.bounds(lane);
                            large.max[axis] = far;
                            let promise = verdict(&tree, node, lane, large).map_err(|violation| violation.promise);
                            assert_eq!(promise, Err(10), "{quality:?}, node {node}, lane {lane}, up to {far}");
                        }
                    }
                }
            }
        }
    }

    #[test]
    fn triangles_that_spatial_splits_cut_lie_in_their_leaves_together() {
        let tree = tree(Quality::Best);
        let held: usize = tree.blocks().iter().map(|block| block.primitives().len()).sum();
        assert!(held > tree.primitive_count(), "some are cut");
        assert_eq!(tree.validate(), Ok(()));
    }

    #[test]
    fn a_triangle_in_no_leaf_is_named() {
        let mut tree = tree(Quality::Fast);
        tree.triangles += 1;
        let missing = Violation::new(8, "a triangle in no leaf", Location::Primitive(COUNT));
        assert_eq!(tree.validate(), Err(missing));
    }
}
