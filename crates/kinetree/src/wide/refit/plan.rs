//! What all refits of a tree have in common: the vertices of its blocks, and its chunks.

use std::ops::Range;
use std::sync::Arc;

use super::super::block::BLOCK;
use super::super::node::LANES;
use super::super::{MeshBvh, WideBvh, WideTarget};
use crate::geometry::Triangles;
use crate::memory::vec_in_large_pages;

/// The most blocks in a chunk, and the most nodes: its boxes stay in the nearest cache until the nodes above them have been written.
pub(super) const MOST_BLOCKS: u32 = 1024;
pub(super) const MOST_NODES: u32 = 512;

/// Vertex numbers of four triangles, `[corner][lane]`. Lanes that are not in use repeat the first.
pub(super) type Corners = [[u32; BLOCK]; 3];

/// A subtree that is refitted at one go. It stands together, and so do its blocks (promise 7).
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Chunk {
    pub(super) nodes: Range<u32>,
    pub(super) blocks: Range<u32>,
}

/// How a tree is refitted. Trees that share one have the same nodes, links and triangles, in the same places.
#[derive(Debug)]
pub(in super::super) struct Plan {
    corners: Vec<Corners>,
    /// In the order of their nodes.
    pub(super) chunks: Vec<Chunk>,
    /// Nodes in no chunk, parents first.
    pub(super) above: Vec<u32>,
    /// The vertex numbers that `corners` was made of.
    indices: Arc<[[u32; 3]]>,
}

impl Plan {
    pub(super) fn of(mesh: &MeshBvh, triangles: &Triangles) -> Self {
        let mut corners: Vec<Corners> = vec_in_large_pages(mesh.blocks.len());
        for block in &mesh.blocks {
            let vertices = block.primitives.map(|triangle| triangles.indices()[triangle as usize]);
            corners.push([0, 1, 2].map(|corner| vertices.map(|vertices| vertices[corner])));
        }
        let (chunks, above) = cut(&mesh.tree);
        Self { corners, chunks, above, indices: triangles.shared_indices().clone() }
    }

    /// Whether it was made for triangles with these vertex numbers.
    pub(super) fn fits(&self, triangles: &Triangles) -> bool {
        Arc::ptr_eq(&self.indices, triangles.shared_indices())
    }

    pub(super) fn corners_of(&self, blocks: &Range<u32>) -> &[Corners] {
        &self.corners[blocks.start as usize..blocks.end as usize]
    }

    /// Bytes held.
    pub(in super::super) fn heap_bytes(&self) -> usize {
        self.corners.capacity() * size_of::<Corners>()
            + self.chunks.capacity() * size_of::<Chunk>()
            + self.above.capacity() * size_of::<u32>()
    }
}

/// The largest subtrees that are small enough for a chunk, and the nodes above them.
fn cut(tree: &WideBvh) -> (Vec<Chunk>, Vec<u32>) {
    // Promise 7: a subtree ends where the one after it begins.
    let mut ends: Vec<(u32, u32)> = Vec::with_capacity(tree.nodes.len());
    ends.resize(tree.nodes.len(), (0, 0));
    let mut first_item = tree.items;
    let mut firsts = vec![0; tree.nodes.len()];
    for (at, node) in tree.nodes.iter().enumerate().rev() {
        let mut end = (at as u32 + 1, first_item);
        for lane in 0..LANES {
            match node.link(lane).map(|link| link.target()) {
                Some(WideTarget::Node(child)) => {
                    let of_child = ends[child as usize];
                    end = (end.0.max(of_child.0), end.1.max(of_child.1));
                }
                Some(WideTarget::Items(items)) => first_item = first_item.min(items.start),
                None => {}
            }
        }
        ends[at] = end;
        firsts[at] = first_item;
    }
    let (mut chunks, mut above) = (Vec::new(), Vec::new());
    let mut at = 0;
    while at < tree.nodes.len() {
        let chunk = Chunk { nodes: at as u32..ends[at].0, blocks: firsts[at]..ends[at].1 };
        if chunk.nodes.len() as u32 <= MOST_NODES && chunk.blocks.len() as u32 <= MOST_BLOCKS {
            at = chunk.nodes.end as usize;
            chunks.push(chunk);
        } else {
            above.push(at as u32);
            at += 1;
        }
    }
    (chunks, above)
}
