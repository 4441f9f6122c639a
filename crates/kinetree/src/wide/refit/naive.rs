//! The slow twin of refitting: corner by corner, box by box, without chunks or SIMD.

use super::super::node::LANES;
use super::super::{MeshBvh, WideTarget};
use super::set_in_parent;
use crate::geometry::{Aabb, Triangles};

/// The same tree for triangles that have moved.
pub(super) fn refit(tree: &MeshBvh, triangles: &Triangles) -> MeshBvh {
    let mut moved = tree.clone();
    moved.chunks.clear();
    for block in &mut moved.blocks {
        block.move_to(|triangle| triangles.get(triangle));
    }
    let (nodes, blocks) = (&mut moved.tree.nodes, &moved.blocks);
    moved.tree.bounds = Aabb::EMPTY;
    for at in (0..nodes.len()).rev() {
        let mut all = Aabb::EMPTY;
        for lane in 0..LANES {
            let Some(link) = nodes[at].link(lane) else { break };
            if let WideTarget::Items(items) = link.target() {
                let bounds = items.fold(Aabb::EMPTY, |all, item| all.union(&blocks[item as usize].bounds()));
                nodes[at].set_box(lane, &bounds);
            }
            // The boxes of lanes that lead to nodes were written when those were visited.
            all = all.union(&nodes[at].bounds(lane));
        }
        match at {
            0 => moved.tree.bounds = all,
            _ => set_in_parent(nodes, at, &all),
        }
    }
    moved
}
