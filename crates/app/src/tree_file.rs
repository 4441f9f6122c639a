//! Trees that were built before: many in one file, found by the meshes that they stand over.
//!
//! A file begins with eight letters, the version of the format and the number of trees; then each tree with its length before it. Numbers are
//! little-endian. Each tree brings its own digest and the fingerprint of its mesh, see [`MeshBvh::to_bytes`](kinetree::MeshBvh::to_bytes), and
//! the lengths must come out even, so there is no bit that could change unnoticed.

use std::collections::HashMap;
use std::fs;
use std::ops::Range;
use std::path::{Path, PathBuf};

use kinetree::wide::fingerprint_in;
use kinetree::{Motion, Scene};

use crate::failure::Failure;
use crate::figures;
use crate::trees::name_of;

const MAGIC: [u8; 8] = *b"kt-trees";
const VERSION: u32 = 1;

/// Whether meshes that move so have trees in files: those whose triangles stay where they are.
pub(crate) fn is_baked(motion: Motion) -> bool {
    matches!(motion, Motion::Static | Motion::Rigid)
}

/// One file of the trees, each of which is as [`kinetree::MeshBvh::to_bytes`] made it.
pub(crate) fn pack(trees: &[Vec<u8>]) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(16 + trees.iter().map(|tree| 8 + tree.len()).sum::<usize>());
    bytes.extend(MAGIC);
    bytes.extend(VERSION.to_le_bytes());
    bytes.extend((trees.len() as u32).to_le_bytes());
    for tree in trees {
        bytes.extend((tree.len() as u64).to_le_bytes());
        bytes.extend(tree);
    }
    bytes
}

/// A file of trees that has been read.
#[derive(Debug)]
pub(crate) struct TreeFile {
    path: PathBuf,
    bytes: Vec<u8>,
    /// Where in the bytes the tree of a mesh is, by the fingerprint of the mesh.
    places: HashMap<u64, Range<usize>>,
}

impl TreeFile {
    /// Reads a file. Every tree in it must be undamaged, also those that nobody will ask for.
    pub(crate) fn open(path: &Path) -> Result<Self, Failure> {
        let failure = |problem: String| Failure::work(format!("{}: {problem}", path.display()));
        let bytes = fs::read(path).map_err(|error| failure(format!("cannot be read: {error}")))?;
        let places = places(&bytes).map_err(failure)?;
        Ok(Self { path: path.to_owned(), bytes, places })
    }

    /// Hands the trees to the meshes of a scene whose triangles stay where they are.
    pub(crate) fn hand_to(&self, scene: &mut Scene, name: &str, scene_path: Option<&Path>) -> Result<(), Failure> {
        let meshes: Vec<_> = scene
            .meshes()
            .enumerate()
            .filter(|(_, (_, _, motion))| is_baked(*motion))
            .map(|(number, (id, mesh, motion))| {
                let triangles = figures::of(mesh.triangles().len() as u64, "triangle", "triangles");
                (id, mesh.fingerprint(), format!("mesh {number} of {name} ({}, {triangles})", name_of(motion)))
            })
            .collect();
        for (id, fingerprint, mesh) in meshes {
            let problem = match self.places.get(&fingerprint) {
                Some(place) => match scene.set_tree(id, &self.bytes[place.clone()]) {
                    Ok(()) => continue,
                    Err(error) => format!("the tree for {mesh} cannot be used: {error}"),
                },
                None => format!("there is no tree for {mesh}, as it is now"),
            };
            let scene = scene_path.map_or_else(String::new, |path| format!(" {}", path.display()));
            let file = self.path.display();
            return Err(Failure::work(format!(
                "{file}: {problem}: make the file again with `kinetree bake{scene} --out {file}`"
            )));
        }
        Ok(())
    }
}

/// Where the trees are, or what is wrong.
fn places(bytes: &[u8]) -> Result<HashMap<u64, Range<usize>>, String> {
    let no_file = || "is no file of trees; `kinetree bake` makes one".to_owned();
    let damaged = || "is damaged: it is not what `kinetree bake` wrote; make it again".to_owned();
    let word = |at: usize| bytes.get(at..)?.first_chunk::<4>().map(|four| u32::from_le_bytes(*four));
    if !bytes.starts_with(&MAGIC) {
        return Err(no_file());
    }
    let version = word(8).ok_or_else(damaged)?;
    if version != VERSION {
        return Err(format!("is in format {version}, and only format {VERSION} is read; make it again"));
    }
    let count = word(12).ok_or_else(damaged)?;
    let (mut at, mut places) = (16, HashMap::new());
    for number in 0..count {
        let length = bytes.get(at..).and_then(|rest| rest.first_chunk::<8>()).ok_or_else(damaged)?;
        let length = usize::try_from(u64::from_le_bytes(*length)).map_err(|_| damaged())?;
        let end = (at + 8).checked_add(length).filter(|&end| end <= bytes.len()).ok_or_else(damaged)?;
        let place = at + 8..end;
        let fingerprint = fingerprint_in(&bytes[place.clone()]).map_err(|error| format!("tree {number}: {error}"))?;
        places.insert(fingerprint, place);
        at = end;
    }
    if at == bytes.len() { Ok(places) } else { Err(damaged()) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use kinetree::Mesh;
    use kinetree::build::BuildOptions;

    fn trees() -> [Vec<u8>; 2] {
        let triangle = Mesh::new(&[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], &[0_u32, 1, 2]).unwrap();
        [triangle, Mesh::empty()].map(|mesh| mesh.bake(&BuildOptions::default()))
    }

    #[test]
    fn what_is_packed_is_found() {
        let trees = trees();
        let bytes = pack(&trees);
        let places = places(&bytes).unwrap();
        assert_eq!(places.len(), 2);
        for tree in &trees {
            let place = &places[&fingerprint_in(tree).unwrap()];
            assert_eq!(&bytes[place.clone()], tree);
        }
        assert!(super::places(&pack(&[])).unwrap().is_empty());
    }

    #[test]
    fn every_flipped_bit_and_every_cut_is_refused() {
        let bytes = pack(&trees());
        for bit in 0..bytes.len() * 8 {
            let mut flipped = bytes.clone();
            flipped[bit / 8] ^= 1 << (bit % 8);
            assert!(places(&flipped).is_err(), "bit {bit}");
        }
        for length in 0..bytes.len() {
            assert!(places(&bytes[..length]).is_err(), "{length} bytes");
        }
        assert!(places(&[&bytes[..], &[0]].concat()).is_err());
    }
}
