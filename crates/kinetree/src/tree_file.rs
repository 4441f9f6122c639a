//! Trees that were built before the game runs: many in one file, each found by its mesh.
//!
//! `kinetree bake` writes such a file; a game that has read it hands each tree to the mesh that it
//! was built for, and the first commit builds nothing. All numbers are little-endian. In this
//! order:
//!
//! | what | bytes |
//! |---|---|
//! | `kt-trees` | 8 |
//! | version, number of trees | 4 each |
//! | each tree: its length; the bytes of the tree | 8; length |
//!
//! The bytes of a tree are those of [`Mesh::bake`] or
//! [`MeshBvh::to_bytes`](crate::MeshBvh::to_bytes). A tree carries a digest of itself and the
//! fingerprint of its mesh, and the lengths must add up to the length of the file, so every changed
//! bit is noticed.

use std::borrow::Cow;
use std::collections::HashMap;
use std::fmt;
use std::ops::Range;

use crate::scene::Mesh;
use crate::wide::{TreeFileError, fingerprint_in};

const MAGIC: [u8; 8] = *b"kt-trees";
const VERSION: u32 = 1;
/// Letters, version and number of trees.
const HEADER_BYTES: usize = MAGIC.len() + 4 + 4;

/// Baked trees of many meshes, as `kinetree bake` writes them into one file.
///
/// ```
/// use kinetree::build::BuildOptions;
/// use kinetree::{Action, Mesh, Motion, Scene, TreeFile};
///
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
/// let load_track = || Mesh::new(&corners, &[[0, 1, 2]]);
///
/// // Once, before the game runs; `kinetree bake` does the same for a glTF file.
/// let bytes = TreeFile::write(&[load_track()?.bake(&BuildOptions::default())]);
///
/// // At every start: `bytes` would come from `std::fs::read`.
/// let trees = TreeFile::read(bytes)?;
/// let mut track = load_track()?;
/// if let Some(tree) = trees.tree_of(&track) {
///     track = track.with_tree(tree)?;
/// }
/// let mut scene = Scene::new();
/// scene.add_mesh(track, Motion::Static)?;
/// assert_eq!(scene.commit().report().count(Action::Loaded), 1);
/// # Ok(())
/// # }
/// ```
///
/// Meshes that are in a scene already, for example those of a loaded glTF file, take their trees
/// before the first commit:
///
/// ```
/// use kinetree::{EditError, Scene, TreeFile};
///
/// fn take_trees(scene: &mut Scene, trees: &TreeFile<'_>) -> Result<(), EditError> {
///     let meshes: Vec<_> = scene.meshes().collect();
///     for id in meshes {
///         if let Some(tree) = trees.tree_of(scene.mesh(id)?) {
///             scene.set_tree(id, tree)?;
///         }
///     }
///     Ok(())
/// }
/// ```
#[derive(Clone)]
pub struct TreeFile<'a> {
    bytes: Cow<'a, [u8]>,
    /// Where in the bytes each tree is, by the fingerprint of its mesh.
    trees: HashMap<u64, Range<usize>>,
}

impl<'a> TreeFile<'a> {
    /// Reads the bytes of a file, which may be borrowed (from a mapped file or `include_bytes!`) or
    /// owned.
    ///
    /// The digest of every tree is compared here; whether a tree keeps its promises is checked when
    /// a mesh takes it. Any bytes are safe to read: the time and memory that this takes are bounded
    /// by their number, whatever lengths and counts they claim.
    ///
    /// # Errors
    /// The bytes are no file of trees, of another version, or damaged.
    pub fn read(bytes: impl Into<Cow<'a, [u8]>>) -> Result<Self, TreeFileError> {
        let bytes = bytes.into();
        let trees = find_trees(&bytes)?;
        Ok(Self { bytes, trees })
    }

    /// The bytes of a file that holds these trees, each of which is as [`Mesh::bake`] gave it. Of
    /// several trees of equal meshes, the last is the one that will be found.
    ///
    /// # Panics
    /// There are 2^32 trees or more.
    pub fn write(trees: &[impl AsRef<[u8]>]) -> Vec<u8> {
        let count = u32::try_from(trees.len()).expect("a file holds fewer than 2^32 trees");
        let length = |tree: &dyn AsRef<[u8]>| 8 + tree.as_ref().len();
        let mut bytes = Vec::with_capacity(HEADER_BYTES + trees.iter().map(|tree| length(tree)).sum::<usize>());
        bytes.extend(MAGIC);
        bytes.extend(VERSION.to_le_bytes());
        bytes.extend(count.to_le_bytes());
        for tree in trees.iter().map(AsRef::as_ref) {
            bytes.extend((tree.len() as u64).to_le_bytes());
            bytes.extend(tree);
        }
        bytes
    }

    /// The tree that was baked for this mesh, for [`Mesh::with_tree`]; `None` if there is none, or
    /// the mesh has other positions or triangles than when it was baked.
    pub fn tree_of(&self, mesh: &Mesh) -> Option<&[u8]> {
        self.trees.get(&mesh.fingerprint()).map(|range| &self.bytes[range.clone()])
    }

    /// How many meshes have a tree in the file.
    pub fn len(&self) -> usize {
        self.trees.len()
    }

    /// Whether there is no tree in the file.
    pub fn is_empty(&self) -> bool {
        self.trees.is_empty()
    }
}

impl fmt::Debug for TreeFile<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("TreeFile").field("bytes", &self.bytes.len()).field("trees", &self.trees.len()).finish()
    }
}

/// Where in the bytes each tree is.
fn find_trees(bytes: &[u8]) -> Result<HashMap<u64, Range<usize>>, TreeFileError> {
    use TreeFileError::{Damaged, NotATreeFile, OtherVersion};
    let mut rest = bytes.strip_prefix(&MAGIC).ok_or(NotATreeFile)?;
    let found = u32::from_le_bytes(take(&mut rest)?);
    if found != VERSION {
        return Err(OtherVersion { found, supported: VERSION });
    }
    // Every turn of the loop takes bytes or fails, however large the count claims to be.
    let count = u32::from_le_bytes(take(&mut rest)?);
    let mut trees = HashMap::new();
    for _ in 0..count {
        let length = usize::try_from(u64::from_le_bytes(take(&mut rest)?)).map_err(|_| Damaged)?;
        let start = bytes.len() - rest.len();
        let (tree, behind) = rest.split_at_checked(length).ok_or(Damaged)?;
        trees.insert(fingerprint_in(tree)?, start..start + length);
        rest = behind;
    }
    if rest.is_empty() { Ok(trees) } else { Err(Damaged) }
}

fn take<const N: usize>(rest: &mut &[u8]) -> Result<[u8; N], TreeFileError> {
    let (taken, behind) = rest.split_first_chunk::<N>().ok_or(TreeFileError::Damaged)?;
    *rest = behind;
    Ok(*taken)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::build::BuildOptions;

    fn meshes() -> [Mesh; 2] {
        [Mesh::new(&[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], &[0_u32, 1, 2]).unwrap(), Mesh::empty()]
    }

    fn file() -> Vec<u8> {
        TreeFile::write(&meshes().map(|mesh| mesh.bake(&BuildOptions::default())))
    }

    #[test]
    fn each_mesh_finds_its_tree_and_other_meshes_find_none() {
        let bytes = file();
        let trees = TreeFile::read(bytes.as_slice()).unwrap();
        assert_eq!((trees.len(), trees.is_empty()), (2, false));
        for mesh in meshes() {
            let tree = trees.tree_of(&mesh).unwrap();
            assert_eq!(tree, mesh.bake(&BuildOptions::default()));
            assert!(mesh.with_tree(tree).is_ok());
        }
        let moved = Mesh::new(&[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 2.0, 0.0]], &[0_u32, 1, 2]).unwrap();
        assert_eq!(trees.tree_of(&moved), None);
        assert_eq!(format!("{trees:?}"), format!("TreeFile {{ bytes: {}, trees: 2 }}", bytes.len()));
    }

    #[test]
    fn a_file_without_trees_is_a_file() {
        let bytes = TreeFile::write(&[] as &[&[u8]]);
        assert_eq!(bytes, *b"kt-trees\x01\0\0\0\0\0\0\0");
        assert!(TreeFile::read(bytes).unwrap().is_empty());
    }

    #[test]
    fn every_flipped_bit_and_every_cut_is_refused() {
        let bytes = file();
        for bit in 0..bytes.len() * 8 {
            let mut flipped = bytes.clone();
            flipped[bit / 8] ^= 1 << (bit % 8);
            assert!(TreeFile::read(flipped).is_err(), "bit {bit}");
        }
        for length in 0..bytes.len() {
            assert!(TreeFile::read(&bytes[..length]).is_err(), "{length} bytes");
        }
        assert_eq!(TreeFile::read([&bytes[..], &[0]].concat()).err(), Some(TreeFileError::Damaged));
    }

    #[test]
    fn what_is_wrong_is_named_and_claims_of_size_cost_nothing() {
        let error = |bytes: &[u8]| TreeFile::read(bytes).unwrap_err();
        let [tree, _] = meshes().map(|mesh| mesh.bake(&BuildOptions::default()));
        assert_eq!(error(b""), TreeFileError::NotATreeFile);
        assert_eq!(error(&tree), TreeFileError::NotATreeFile);
        assert_eq!(error(b"kt-trees\x02\0\0\0\0\0\0\0"), TreeFileError::OtherVersion { found: 2, supported: 1 });
        assert_eq!(error(&TreeFile::write(&[b"no tree at all"])), TreeFileError::NotATree);
        for length in [0, 1, u64::from(u32::MAX), u64::MAX] {
            let claimed = [&b"kt-trees\x01\0\0\0\xff\xff\xff\xff"[..], &length.to_le_bytes()].concat();
            assert!(matches!(error(&claimed), TreeFileError::Damaged | TreeFileError::NotATree), "{length}");
        }
    }
}
