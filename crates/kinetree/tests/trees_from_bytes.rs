//! Trees that were written come back as they were; whatever else is read is refused, or is a tree
//! all the same.

mod common;

use common::{Random, alone, cube, rays, worlds};
use kinetree::build::{self, BuildOptions, Quality};
use kinetree::geometry::Triangles;
use kinetree::wide::{TreeFileError, fingerprint_in};
use kinetree::{Mesh, MeshBvh, Ray, Work};

const QUALITIES: [Quality; 4] = [Quality::Fastest, Quality::Fast, Quality::Balanced, Quality::Best];

fn triangles_of(mesh: &Mesh) -> Triangles {
    Triangles::new(mesh.positions().to_vec(), mesh.triangles().into()).unwrap()
}

fn grown(triangles: &Triangles, quality: Quality) -> MeshBvh {
    let mut options = BuildOptions::default();
    options.quality = quality;
    MeshBvh::new(&build::build_triangles(triangles, &options), triangles)
}

/// Long thin triangles that lie askew, which spatial splits cut.
fn diagonals(count: usize, seed: u64) -> Triangles {
    let mut random = Random::new(seed);
    let mut positions = Vec::new();
    for _ in 0..count {
        let (from, along, aside) = (random.point(1.0), random.direction(), random.direction());
        positions.push(from);
        positions.push([0, 1, 2].map(|axis| from[axis] + along[axis]));
        positions.push([0, 1, 2].map(|axis| from[axis] + along[axis] + aside[axis] * 0.01));
    }
    let indices: Vec<[u32; 3]> = (0..count as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    Triangles::new(positions, indices.into()).unwrap()
}

/// The same nodes and the same blocks, to the bit.
fn assert_same(one: &MeshBvh, other: &MeshBvh, name: &str) {
    assert_eq!(one.tree().nodes(), other.tree().nodes(), "{name}");
    assert_eq!(one.bounds(), other.bounds(), "{name}");
    assert_eq!(one.primitive_count(), other.primitive_count(), "{name}");
    // Lanes that are not in use hold no numbers, which are not equal to themselves but print alike.
    assert_eq!(format!("{:?}", one.blocks()), format!("{:?}", other.blocks()), "{name}");
}

/// Writes another digest behind bytes that were changed, as a forger would.
fn with_right_digest(bytes: &[u8]) -> Vec<u8> {
    let body = &bytes[..bytes.len() - 8];
    let mut state = 0xCBF2_9CE4_8422_2325_u64;
    let mut word = |word: u64| {
        state = (state ^ word).wrapping_mul(0x9E37_79B9_7F4A_7C15);
        state ^= state >> 32;
        state
    };
    for chunk in body.chunks(8) {
        let mut bytes = [0; 8];
        bytes[..chunk.len()].copy_from_slice(chunk);
        word(u64::from_le_bytes(bytes));
    }
    if body.len() % 8 == 0 {
        word(0);
    }
    word(body.len() as u64);
    let digest = word(0);
    [body, &digest.to_le_bytes()].concat()
}

#[test]
fn what_was_written_comes_back_to_the_bit() {
    for world in worlds(41) {
        for view in world.view.instances().take(3) {
            let triangles = Triangles::new(view.positions().to_vec(), view.triangles().into()).unwrap();
            for quality in QUALITIES {
                let tree = grown(&triangles, quality);
                let bytes = tree.to_bytes(&triangles);
                let name = format!("{}, {quality:?}", world.name);
                let read = MeshBvh::from_bytes(&bytes, &triangles).unwrap_or_else(|error| panic!("{name}: {error}"));
                assert_same(&read, &tree, &name);
                assert_eq!(read.validate(), Ok(()), "{name}");
                assert_eq!(read.to_bytes(&triangles), bytes, "{name}");
                assert_eq!(fingerprint_in(&bytes), Ok(triangles.fingerprint()), "{name}");
            }
        }
    }
}

#[test]
fn trees_with_triangles_in_many_leaves_come_back_to_the_bit() {
    for seed in 0..6 {
        let triangles = diagonals(4000, seed);
        let tree = grown(&triangles, Quality::Best);
        let held: usize = tree.blocks().iter().map(|block| block.primitives().len()).sum();
        assert!(held > triangles.len() * 11 / 10, "only {held} of {} were cut", triangles.len());
        let read = MeshBvh::from_bytes(&tree.to_bytes(&triangles), &triangles).unwrap();
        assert_same(&read, &tree, &format!("seed {seed}"));
    }
}

#[test]
fn nothing_at_all_is_a_tree_too() {
    let nothing = Triangles::default();
    let bytes = MeshBvh::default().to_bytes(&nothing);
    let read = MeshBvh::from_bytes(&bytes, &nothing).unwrap();
    assert_eq!((read.node_count(), read.primitive_count(), read.validate()), (0, 0, Ok(())));
    let one = triangles_of(&cube());
    assert!(matches!(MeshBvh::from_bytes(&bytes, &one), Err(TreeFileError::OtherMesh)));
    assert!(matches!(
        MeshBvh::from_bytes(&grown(&one, Quality::Best).to_bytes(&one), &nothing),
        Err(TreeFileError::OtherMesh)
    ));
}

#[test]
fn every_flipped_bit_is_refused() {
    let triangles = triangles_of(&Random::new(5).soup(40, 3.0, 0.6));
    let bytes = grown(&triangles, Quality::Best).to_bytes(&triangles);
    for bit in 0..bytes.len() * 8 {
        let mut flipped = bytes.clone();
        flipped[bit / 8] ^= 1 << (bit % 8);
        assert!(MeshBvh::from_bytes(&flipped, &triangles).is_err(), "bit {bit}");
        assert!(fingerprint_in(&flipped).is_err(), "bit {bit}");
    }
}

#[test]
fn every_cut_and_every_appendix_is_refused() {
    let triangles = triangles_of(&cube());
    let bytes = grown(&triangles, Quality::Fast).to_bytes(&triangles);
    for length in 0..bytes.len() {
        assert!(MeshBvh::from_bytes(&bytes[..length], &triangles).is_err(), "{length} bytes");
        if length >= 8 {
            let forged = with_right_digest(&bytes[..length]);
            assert!(MeshBvh::from_bytes(&forged, &triangles).is_err(), "{length} bytes, right digest");
        }
    }
    for more in 1..20 {
        let longer = [&bytes[..], &vec![0; more]].concat();
        assert!(MeshBvh::from_bytes(&longer, &triangles).is_err());
        assert!(MeshBvh::from_bytes(&with_right_digest(&longer), &triangles).is_err());
    }
}

#[test]
fn another_mesh_is_refused_however_little_it_differs() {
    let triangles = triangles_of(&cube());
    let bytes = grown(&triangles, Quality::Fast).to_bytes(&triangles);
    let differs = |positions: Vec<[f32; 3]>, indices: Vec<[u32; 3]>| {
        let other = Triangles::new(positions, indices.into()).unwrap();
        assert_eq!(MeshBvh::from_bytes(&bytes, &other).err(), Some(TreeFileError::OtherMesh));
    };
    let (positions, indices) = (triangles.positions().to_vec(), triangles.indices().to_vec());
    for vertex in 0..positions.len() {
        for axis in 0..3 {
            let mut moved = positions.clone();
            moved[vertex][axis] = moved[vertex][axis].next_up();
            differs(moved, indices.clone());
        }
    }
    for triangle in 0..indices.len() {
        let mut turned = indices.clone();
        turned[triangle].rotate_left(1);
        differs(positions.clone(), turned);
        let mut fewer = indices.clone();
        fewer.remove(triangle);
        differs(positions.clone(), fewer);
    }
    let more = [&positions[..], &[[0.0; 3]]].concat();
    differs(more, indices);
}

#[test]
fn another_format_is_named() {
    let triangles = triangles_of(&cube());
    let mut bytes = grown(&triangles, Quality::Fast).to_bytes(&triangles);
    bytes[8] = 77;
    let error = MeshBvh::from_bytes(&bytes, &triangles).unwrap_err();
    assert_eq!(error, TreeFileError::OtherVersion { found: 77, supported: 1 });
    assert!(error.to_string().contains("77") && error.to_string().contains("bake"), "{error}");
    bytes[0] ^= 1;
    assert_eq!(MeshBvh::from_bytes(&bytes, &triangles).err(), Some(TreeFileError::NotATree));
}

/// Traces what was accepted; says how many rays hit something. No ray may see anything of the tree
/// twice.
fn trace(tree_bytes: &[u8], mesh: &Mesh, rays: &[Ray]) -> usize {
    let view = alone(mesh.clone().with_tree(tree_bytes).unwrap());
    let tree = view.instance_at(0).bvh();
    assert_eq!(tree.validate(), Ok(()));
    // Each node, each leaf and each block once, and the node and the leaf of the top level.
    let leaves = tree.tree().nodes().iter().flat_map(|node| node.lanes()).filter(|(_, link)| link.is_leaf()).count();
    let [nodes, leaves, blocks] = [tree.node_count() + 1, leaves + 1, tree.blocks().len()].map(|count| count as u64);
    let mut answers = vec![None; rays.len()];
    view.closest_hits(rays, &mut answers, kinetree::Coherence::Coherent);
    for ray in rays {
        let mut works = [Work::default(); 3];
        view.query().closest_hit_counted(ray, &mut works[0]);
        view.query().all_hits_counted(ray, &mut works[1]);
        view.query().occluded_counted(ray, &mut works[2]);
        let has_valid_range = |work: &Work| work.nodes <= nodes && work.leaves <= leaves && work.blocks <= blocks;
        assert!(works.iter().all(has_valid_range), "{works:?} in {nodes} nodes, {leaves} leaves, {blocks} blocks");
    }
    rays.iter().filter(|ray| view.closest_hit(ray).is_some()).count()
}

#[test]
fn a_forged_tree_is_refused_or_one_that_can_be_traced() {
    let (mut accepted, mut refused) = (0, 0);
    for (mesh, quality) in [(Random::new(6).soup(30, 2.0, 1.5), Quality::Best), (cube(), Quality::Fastest)] {
        let triangles = triangles_of(&mesh);
        let bytes = grown(&triangles, quality).to_bytes(&triangles);
        assert_eq!(with_right_digest(&bytes), bytes, "the test forges as the library writes");
        let world = common::World { name: "forged".into(), view: alone(mesh.clone()), size: 2.0 };
        let rays = rays(&world, 40, &mut Random::new(7));
        let expected = trace(&bytes, &mesh, &rays);
        for bit in 0..(bytes.len() - 8) * 8 {
            let mut forged = bytes.clone();
            forged[bit / 8] ^= 1 << (bit % 8);
            let forged = with_right_digest(&forged);
            match MeshBvh::from_bytes(&forged, &triangles) {
                Ok(tree) => {
                    assert_eq!(tree.validate(), Ok(()), "bit {bit}");
                    // Triangles that stand in one leaf are hit as ever, whichever bit was flipped.
                    let hits = trace(&forged, &mesh, &rays);
                    let whole =
                        tree.blocks().iter().map(|block| block.primitives().len()).sum::<usize>() == triangles.len();
                    assert!(!whole || hits == expected, "bit {bit}: {hits} hits, not {expected}");
                    accepted += 1;
                }
                Err(_) => refused += 1,
            }
        }
    }
    assert!(accepted > 0 && refused > accepted, "{accepted} accepted, {refused} refused");
}

#[test]
fn forged_bytes_at_random_places_do_no_harm() {
    let seed = 8;
    let mut random = Random::new(seed);
    let mesh = Random::new(9).soup(200, 2.0, 1.5);
    let triangles = triangles_of(&mesh);
    let bytes = grown(&triangles, Quality::Best).to_bytes(&triangles);
    let rays: Vec<Ray> = (0..20).map(|_| Ray::new(random.point(4.0), random.direction())).collect();
    for round in 0..4000 {
        let mut forged = bytes.clone();
        for _ in 0..1 + random.below(4) {
            // Words that are likely to reach somewhere: small numbers, and words of the same file.
            let at = random.below(bytes.len() - 12);
            let word = match random.below(3) {
                0 => (random.below(300) as u32).to_le_bytes(),
                1 => (0x8000_0000 | random.bits() as u32 & 0x7000_00FF).to_le_bytes(),
                _ => {
                    let from = random.below(bytes.len() - 12);
                    [bytes[from], bytes[from + 1], bytes[from + 2], bytes[from + 3]]
                }
            };
            forged[at..at + 4].copy_from_slice(&word);
        }
        let forged = with_right_digest(&forged);
        if let Ok(tree) = MeshBvh::from_bytes(&forged, &triangles) {
            assert_eq!(tree.validate(), Ok(()), "seed {seed}, round {round}");
            trace(&forged, &mesh, &rays);
        }
    }
}

#[test]
fn sizes_are_not_believed() {
    let triangles = triangles_of(&cube());
    let bytes = grown(&triangles, Quality::Fast).to_bytes(&triangles);
    for at in [24, 28] {
        for count in [u32::MAX, 1 << 28, 1 << 20, 0] {
            let mut forged = bytes.clone();
            forged[at..at + 4].copy_from_slice(&count.to_le_bytes());
            let error = MeshBvh::from_bytes(&with_right_digest(&forged), &triangles);
            assert!(error.is_err(), "{count} at byte {at}");
        }
    }
}

#[test]
fn boxes_that_reach_beyond_the_mesh_are_refused() {
    for (mesh, quality) in [(Random::new(10).soup(60, 2.0, 1.5), Quality::Best), (cube(), Quality::Fastest)] {
        let triangles = triangles_of(&mesh);
        let bytes = grown(&triangles, quality).to_bytes(&triangles);
        // All boxes of all nodes, and the box around everything, as large as numbers go: inner ones
        // contain outer ones.
        for far in [1e30, f32::MAX, f32::INFINITY] {
            let mut forged = bytes.clone();
            let head = 32;
            let widen = |forged: &mut Vec<u8>, at: usize| {
                for plane in 0..6 {
                    let value = if plane < 3 { -far } else { far };
                    forged[at + 4 * plane..][..4].copy_from_slice(&value.to_le_bytes());
                }
            };
            widen(&mut forged, head);
            let nodes = u32::from_le_bytes(forged[24..28].try_into().unwrap());
            let mut at = head + 24;
            for _ in 0..nodes {
                let lanes = usize::from(forged[at]);
                (0..lanes).for_each(|lane| widen(&mut forged, at + 1 + 28 * lane));
                at += 1 + 28 * lanes;
            }
            let error = MeshBvh::from_bytes(&with_right_digest(&forged), &triangles).unwrap_err();
            assert!(
                matches!(error, TreeFileError::Broken(violation) if violation.promise == 10),
                "{error}, up to {far}"
            );
        }
    }
}
