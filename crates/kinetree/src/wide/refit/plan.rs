//! The data that all refits of a tree share: the vertex indices of its blocks, and its chunks.

use std::ops::Range;
use std::sync::Arc;

use super::super::block::BLOCK;
use super::super::node::LANES;
use super::super::{MeshBvh, WideBvh, WideTarget};
use crate::geometry::Triangles;
use crate::memory::vec_in_large_pages;

/// The largest numbers of blocks and nodes in a chunk: their boxes stay in the first-level cache
/// until the nodes above them have been written.
pub(super) const MAX_BLOCKS: u32 = 1024;
pub(super) const MAX_NODES: u32 = 512;

/// Vertex indices of four triangles, `[corner][lane]`. Unused lanes repeat the first.
pub(super) type Corners = [[u32; BLOCK]; 3];

/// A subtree that one task refits. Its nodes and its blocks are contiguous (promise 7).
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Chunk {
    pub(super) nodes: Range<u32>,
    pub(super) blocks: Range<u32>,
}

/// How a tree is refitted. Trees that share a plan have the same topology and the same triangles in
/// the same blocks.
#[derive(Debug)]
pub(in super::super) struct Plan {
    corners: Vec<Corners>,
    /// In the order of their nodes.
    pub(super) chunks: Vec<Chunk>,
    /// Nodes that are in no chunk, parents first.
    pub(super) above: Vec<u32>,
    /// The vertex indices that `corners` was made of.
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

    /// Whether it was made for triangles with these vertex indices.
    pub(super) fn fits(&self, triangles: &Triangles) -> bool {
        Arc::ptr_eq(&self.indices, triangles.shared_indices())
    }

    pub(super) fn corners_of(&self, blocks: &Range<u32>) -> &[Corners] {
        &self.corners[blocks.start as usize..blocks.end as usize]
    }

    /// Bytes of heap memory held.
    pub(in super::super) fn heap_bytes(&self) -> usize {
        self.corners.capacity() * size_of::<Corners>()
            + self.chunks.capacity() * size_of::<Chunk>()
            + self.above.capacity() * size_of::<u32>()
    }
}

/// The maximal subtrees that fit in a chunk, and the nodes above them.
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
        if chunk.nodes.len() as u32 <= MAX_NODES && chunk.blocks.len() as u32 <= MAX_BLOCKS {
            at = chunk.nodes.end as usize;
            chunks.push(chunk);
        } else {
            above.push(at as u32);
            at += 1;
        }
    }
    (chunks, above)
}
