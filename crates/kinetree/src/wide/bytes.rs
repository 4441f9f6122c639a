//! Serialization of a tree, bound to its mesh by a fingerprint.
//!
//! Redundant data are not written: corners come from the mesh, parents from the links. All numbers
//! are little-endian. The format is:
//!
//! | what | bytes |
//! |---|---|
//! | `kinetree` | 8 |
//! | version, number of triangles | 4 each |
//! | fingerprint of the mesh | 8 |
//! | number of nodes, number of blocks | 4 each |
//! | the box around everything: least corner, greatest corner | 24 |
//! | each node: number of lanes; each lane: box, link | 1; 24, 4 |
//! | each block: number of triangles; the triangles | 1; 4 each |
//! | digest of the bytes before | 8 |
//!
//! Reading validates everything: lengths are compared with the number of bytes before anything is
//! allocated, and the tree must keep all promises. So reading any bytes gives an error or a tree
//! that is safe to traverse.

use thiserror::Error;

use super::block::BLOCK;
use super::node::LANES;
use super::{MeshBvh, TriangleBlock, WideBvh, WideLink, WideNode, WideTarget};
use crate::digest::Digest;
use crate::geometry::{Aabb, Triangles};
use crate::memory::vec_in_large_pages;
use crate::tree::Violation;

const MAGIC: [u8; 8] = *b"kinetree";
const VERSION: u32 = 1;
const BOX_BYTES: usize = 24;
const LANE_BYTES: usize = BOX_BYTES + 4;
const MIN_NODE_BYTES: usize = 1 + LANE_BYTES;
const MIN_BLOCK_BYTES: usize = 1 + 4;
const HEADER_BYTES: usize = 8 + 4 + 4 + 8 + 4 + 4 + BOX_BYTES;
const DIGEST_BYTES: usize = 8;

/// Why bytes were refused as a tree, or as a [file of trees](crate::tree_file::TreeFile).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum TreeFileError {
    /// The magic bytes of a tree are missing.
    #[error("this is no tree of kinetree's")]
    NotATree,
    /// The magic bytes of a file of trees are missing.
    #[error("this is no file of trees; `kinetree bake` makes one")]
    NotATreeFile,
    /// The bytes have another version of the format.
    #[error("the trees were written in format {found}, and only format {supported} is read; bake them again")]
    OtherVersion {
        /// The version of the bytes.
        found: u32,
        /// The only version that is read.
        supported: u32,
    },
    /// The bytes are truncated, or have changed since they were written.
    #[error("the trees are damaged: they are not what was written; bake them again")]
    Damaged,
    /// The tree was built over other positions or other triangles.
    #[error("the tree is one of another mesh, or the mesh has changed since; bake it again")]
    OtherMesh,
    /// The digest is right, but the tree is invalid.
    #[error("the tree is not sound: {what}; bake it again")]
    Unsound {
        /// What was found.
        what: &'static str,
    },
    /// The digest is right, but the tree breaks a promise of [`MeshBvh`].
    #[error("the tree is not sound: {0}; bake it again")]
    Broken(#[from] Violation),
}

/// The [fingerprint](Triangles::fingerprint) of the mesh of a serialized tree. Checks the digest,
/// but not the tree.
///
/// # Errors
/// The bytes are not a tree, or damaged.
pub fn fingerprint_in(bytes: &[u8]) -> Result<u64, TreeFileError> {
    Ok(Header::read(&mut Reader::open(bytes)?)?.fingerprint)
}

impl MeshBvh {
    /// Serializes the tree, for [`MeshBvh::from_bytes`]. `triangles` must be those of the tree.
    pub fn to_bytes(&self, triangles: &Triangles) -> Vec<u8> {
        let (nodes, blocks) = (self.tree().nodes(), self.blocks());
        let lanes: usize = nodes.iter().map(|node| node.lanes().count()).sum();
        let primitives: usize = blocks.iter().map(|block| block.primitives().len()).sum();
        let body = nodes.len() + lanes * LANE_BYTES + blocks.len() + primitives * 4;
        let mut to = Vec::with_capacity(HEADER_BYTES + body + DIGEST_BYTES);
        to.extend(MAGIC);
        to.extend(VERSION.to_le_bytes());
        to.extend((triangles.len() as u32).to_le_bytes());
        to.extend(triangles.fingerprint().to_le_bytes());
        to.extend((nodes.len() as u32).to_le_bytes());
        to.extend((blocks.len() as u32).to_le_bytes());
        write_box(&mut to, &self.bounds());
        for node in nodes {
            to.push(node.lanes().count() as u8);
            for (lane, link) in node.lanes() {
                write_box(&mut to, &node.bounds(lane));
                to.extend(serialized(link).to_le_bytes());
            }
        }
        for block in blocks {
            to.push(block.primitives().len() as u8);
            block.primitives().iter().for_each(|primitive| to.extend(primitive.to_le_bytes()));
        }
        to.extend(digest(&to).to_le_bytes());
        to
    }

    /// Reads a tree that [`MeshBvh::to_bytes`] wrote, for the same triangles: the same nodes and
    /// blocks, bit by bit.
    ///
    /// The result keeps promises 1 to 10 of [`MeshBvh`], as checked by [`MeshBvh::validate`]. That
    /// the boxes of a triangle which spatial splits cut leave no gap is not checked; it relies on
    /// the digest.
    ///
    /// # Errors
    /// The bytes are not a tree, are damaged, belong to other triangles, or break a promise.
    pub fn from_bytes(bytes: &[u8], triangles: &Triangles) -> Result<Self, TreeFileError> {
        let mut from = Reader::open(bytes)?;
        let header = Header::read(&mut from)?;
        if header.triangles as usize != triangles.len() || header.fingerprint != triangles.fingerprint() {
            return Err(TreeFileError::OtherMesh);
        }
        let min_bytes = header.nodes.checked_mul(MIN_NODE_BYTES).zip(header.blocks.checked_mul(MIN_BLOCK_BYTES));
        let fits =
            min_bytes.and_then(|(nodes, blocks)| nodes.checked_add(blocks)).is_some_and(|all| all <= from.0.len());
        if !fits || header.nodes > WideLink::MAX_NODE as usize || header.blocks > WideLink::MAX_ITEM as usize {
            return Err(TreeFileError::Unsound { what: "more nodes or blocks than there are bytes for" });
        }
        let nodes = read_nodes(&mut from, header.nodes)?;
        let blocks = read_blocks(&mut from, header.blocks, triangles)?;
        if !from.0.is_empty() {
            return Err(TreeFileError::Unsound { what: "bytes behind the last block" });
        }
        let tree = WideBvh { nodes, items: blocks.len() as u32, bounds: header.bounds };
        let mesh = Self::from_parts(tree, blocks, header.triangles);
        mesh.validate()?;
        Ok(mesh)
    }
}

/// The header after the version.
struct Header {
    triangles: u32,
    fingerprint: u64,
    nodes: usize,
    blocks: usize,
    bounds: Aabb,
}

impl Header {
    fn read(from: &mut Reader<'_>) -> Result<Self, TreeFileError> {
        Ok(Self {
            triangles: from.u32()?,
            fingerprint: u64::from_le_bytes(from.take()?),
            nodes: from.u32()? as usize,
            blocks: from.u32()? as usize,
            bounds: from.bounds()?,
        })
    }
}

fn read_nodes(from: &mut Reader<'_>, count: usize) -> Result<Vec<WideNode>, TreeFileError> {
    let mut nodes: Vec<WideNode> = vec_in_large_pages(count);
    for _ in 0..count {
        let [lanes] = from.take()?;
        if !(1..=LANES).contains(&lanes.into()) {
            return Err(TreeFileError::Unsound { what: "a node with no lane, or more than eight" });
        }
        let mut node = WideNode::new(u32::MAX);
        for lane in 0..lanes.into() {
            node.set_box(lane, &from.bounds()?);
            node.links[lane] = from.link()?.bits();
            node.in_use |= 1 << lane;
        }
        nodes.push(node);
    }
    for at in 0..count {
        for lane in 0..LANES {
            let Some(link) = nodes[at].link(lane).filter(|link| !link.is_leaf()) else { continue };
            let child = link.node_index();
            if !(at + 1..count).contains(&child) {
                return Err(TreeFileError::Unsound { what: "a node that leads backwards, or nowhere" });
            }
            nodes[child].parent_lane = (at * LANES + lane) as u32;
        }
    }
    Ok(nodes)
}

fn read_blocks(
    from: &mut Reader<'_>,
    count: usize,
    triangles: &Triangles,
) -> Result<Vec<TriangleBlock>, TreeFileError> {
    let mut blocks = vec_in_large_pages(count);
    for _ in 0..count {
        let [lanes] = from.take()?;
        if !(1..=BLOCK).contains(&lanes.into()) {
            return Err(TreeFileError::Unsound { what: "a block with no triangle, or more than four" });
        }
        let mut primitives = [0; BLOCK];
        let primitives = &mut primitives[..lanes.into()];
        for primitive in &mut *primitives {
            *primitive = from.u32()?;
        }
        if primitives.iter().any(|&primitive| primitive as usize >= triangles.len()) {
            return Err(TreeFileError::Unsound { what: "a triangle that the mesh does not have" });
        }
        blocks.push(TriangleBlock::new(primitives, |triangle| triangles.get(triangle)));
    }
    Ok(blocks)
}

/// The bytes that have not been read yet, without the digest.
struct Reader<'a>(&'a [u8]);

impl<'a> Reader<'a> {
    /// Checks magic, version and digest, and returns a reader of what follows the version.
    fn open(bytes: &'a [u8]) -> Result<Self, TreeFileError> {
        let mut from = Self(bytes);
        if from.take().ok() != Some(MAGIC) {
            return Err(TreeFileError::NotATree);
        }
        let version = from.u32()?;
        if version != VERSION {
            return Err(TreeFileError::OtherVersion { found: version, supported: VERSION });
        }
        let (body, expected) = bytes.split_last_chunk::<DIGEST_BYTES>().ok_or(TreeFileError::Damaged)?;
        if digest(body) != u64::from_le_bytes(*expected) {
            return Err(TreeFileError::Damaged);
        }
        body.get(MAGIC.len() + 4..).map(Self).ok_or(TreeFileError::Damaged)
    }

    fn take<const N: usize>(&mut self) -> Result<[u8; N], TreeFileError> {
        let (taken, rest) = self.0.split_first_chunk::<N>().ok_or(TreeFileError::Damaged)?;
        self.0 = rest;
        Ok(*taken)
    }

    fn u32(&mut self) -> Result<u32, TreeFileError> {
        self.take().map(u32::from_le_bytes)
    }

    fn link(&mut self) -> Result<WideLink, TreeFileError> {
        let link = WideLink::from_bits(self.u32()?);
        match link.is_leaf() {
            true => Ok(link),
            false if link.bits() <= WideLink::MAX_NODE => Ok(WideLink::node(link.bits())),
            false => Err(TreeFileError::Unsound { what: "a node that leads nowhere" }),
        }
    }

    /// Reads a box that is not inverted, or the empty one.
    fn bounds(&mut self) -> Result<Aabb, TreeFileError> {
        let mut planes = [0.0; 6];
        for plane in &mut planes {
            *plane = f32::from_bits(self.u32()?);
        }
        let [a, b, c, d, e, f] = planes;
        let bounds = Aabb::new([a, b, c], [d, e, f]);
        let is_box = (0..3).all(|axis| bounds.min[axis] <= bounds.max[axis]) || bounds == Aabb::EMPTY;
        if is_box { Ok(bounds) } else { Err(TreeFileError::Unsound { what: "a box that is inside out, or no number" }) }
    }
}

/// The serialized form of a link: the index of a node, or the bits of a link to items.
fn serialized(link: WideLink) -> u32 {
    match link.target() {
        WideTarget::Node(node) => node,
        WideTarget::Items(_) => link.bits(),
    }
}

fn write_box(to: &mut Vec<u8>, bounds: &Aabb) {
    bounds.min.iter().chain(&bounds.max).for_each(|plane| to.extend(plane.to_le_bytes()));
}

fn digest(bytes: &[u8]) -> u64 {
    let mut digest = Digest::new();
    digest.bytes(bytes);
    digest.finish()
}
