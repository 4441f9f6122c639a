//! Trees are the same on every machine, at every processor level and for any number of threads.
//! Their hashes are stored here.
//!
//! The input is made of whole numbers: no sine, cosine or logarithm of a platform's library has a
//! say in it. After an intended change of a builder or of padding, take the hashes from the
//! failure's message.

use std::process::Command;
use std::sync::Arc;

use kinetree::build::{BuildOptions, Quality, build_triangles};
use kinetree::geometry::Triangles;
use kinetree::simd::Level;
use kinetree::wide::{WideBvh, WideTarget};
use kinetree::{Affine, Mesh, MeshBvh, Motion, Scene, Threads, TopLevelMethod};

const QUALITIES: [Quality; 4] = [Quality::Fastest, Quality::Fast, Quality::Balanced, Quality::Best];

/// Of each mesh of [`meshes`], the trees of each quality.
const TREES: [(&str, [u64; 4]); 5] = [
    ("loose", [0x0076_f7c0_795a_8826, 0xfd02_e1f1_60dd_dc63, 0xb214_d8a3_6835_648b, 0x0bed_3dec_7c71_f5b7]),
    ("hills", [0xb571_735f_d139_3cf6, 0x2ca1_22f4_cc9a_7758, 0xbc03_a6fd_7bc5_5ce6, 0x4a03_c34d_628d_93fe]),
    ("needles", [0xbb8c_2939_503d_2bee, 0x93cf_2c71_dc88_5789, 0xef72_7455_6c23_8dcd, 0xe3ff_0a67_5f87_6489]),
    (
        "a heap in one place",
        [0x363c_c120_72bf_a451, 0xcb57_cc02_ba74_fedf, 0xf7cd_8283_f484_5027, 0xa824_bb40_396d_0a88],
    ),
    ("one", [0x7b52_7b7f_2daf_d894; 4]),
];

/// The trees over so many instances.
const TOP_LEVELS: [(usize, TopLevelMethod, u64); 2] =
    [(300, TopLevelMethod::Clustered, 0xf373_37af_94f9_6877), (900, TopLevelMethod::Binned, 0x6f82_7d92_dc6e_ca7f)];

/// A linear congruential generator (Knuth, "The Art of Computer Programming", volume 2, 3.3.4).
struct Whole(u64);

impl Whole {
    /// From `-most` to `most`.
    fn next(&mut self, most: i64) -> i64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) as i64 % (2 * most + 1) - most
    }

    fn point(&mut self, most: i64) -> [f32; 3] {
        [0; 3].map(|_| self.next(most) as f32)
    }
}

fn plus(a: [f32; 3], b: [f32; 3]) -> [f32; 3] {
    [0, 1, 2].map(|axis| a[axis] + b[axis])
}

fn loose(corners: impl IntoIterator<Item = [[f32; 3]; 3]>) -> Triangles {
    let positions: Vec<[f32; 3]> = corners.into_iter().flatten().collect();
    let indices: Arc<[[u32; 3]]> = (0..positions.len() as u32 / 3).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    Triangles::new(positions, indices).unwrap()
}

fn hills(side: u32) -> Triangles {
    let mut whole = Whole(2);
    let place = |i: u32| (i % (side + 1), i / (side + 1));
    let positions = (0..(side + 1) * (side + 1)).map(place);
    let positions = positions.map(|(x, z)| [4.0 * x as f32, whole.next(6) as f32, 4.0 * z as f32]).collect();
    let cell = |(x, z): (u32, u32)| {
        let corner = z * (side + 1) + x;
        let [a, b, c, d] = [corner, corner + 1, corner + side + 1, corner + side + 2];
        [[a, c, b], [b, c, d]]
    };
    let cells = (0..side * side).map(|i| (i % side, i / side));
    Triangles::new(positions, cells.flat_map(cell).collect()).unwrap()
}

fn meshes() -> [Triangles; 5] {
    let (mut a, mut b, mut c) = (Whole(1), Whole(3), Whole(4));
    let near = |whole: &mut Whole, least: i64, most: i64| {
        let from = whole.point(least);
        [from, plus(from, whole.point(most)), plus(from, whole.point(most))]
    };
    [
        loose((0..3000).map(|_| near(&mut a, 1000, 12))),
        hills(40),
        loose((0..1500).map(|_| {
            let [from, to, _] = near(&mut b, 1000, 700);
            [from, to, plus(to, b.point(1))]
        })),
        loose((0..200).map(|i| if i % 2 == 0 { [[5.0, 6.0, 7.0]; 3] } else { near(&mut c, 1, 1) })),
        loose([[[0.0, 0.0, 0.0], [8.0, 0.0, 0.0], [0.0, 8.0, 0.0]]]),
    ]
}

/// Fowler, Noll and Vo 1991, "FNV-1a".
struct Hash(u64);

impl Hash {
    fn new() -> Self {
        Self(0xcbf2_9ce4_8422_2325)
    }

    fn word(&mut self, word: u32) {
        for byte in word.to_le_bytes() {
            self.0 = (self.0 ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
        }
    }

    /// Boxes to the bit, and where lanes lead.
    fn tree(&mut self, tree: &WideBvh) {
        for node in tree.nodes() {
            for (lane, link) in node.lanes() {
                let bounds = node.bounds(lane);
                bounds.min.iter().chain(&bounds.max).for_each(|x| self.word(x.to_bits()));
                let [kind, from, to] = match link.target() {
                    WideTarget::Node(number) => [0, number, 0],
                    WideTarget::Items(range) => [1, range.start, range.end],
                };
                [lane as u32, kind, from, to].into_iter().for_each(|word| self.word(word));
            }
        }
        self.word(tree.nodes().len() as u32);
    }
}

fn hash_of_mesh(mesh: &Triangles, quality: Quality, threads: Threads) -> u64 {
    let mut options = BuildOptions::default();
    (options.quality, options.threads) = (quality, threads);
    let tree = MeshBvh::new(&build_triangles(mesh, &options), mesh);
    let mut hash = Hash::new();
    hash.tree(tree.tree());
    for block in tree.blocks() {
        block.primitives().iter().for_each(|primitive| hash.word(*primitive));
    }
    hash.0
}

#[test]
fn trees_are_those_whose_hashes_are_stored() {
    for threads in [Threads::one(), Threads::default()] {
        let found: Vec<(&str, [u64; 4])> = TREES
            .iter()
            .zip(&meshes())
            .map(|((name, _), mesh)| (*name, QUALITIES.map(|quality| hash_of_mesh(mesh, quality, threads.clone()))))
            .collect();
        assert!(found == TREES, "at level {:?} they are {found:#x?}", Level::current());
    }
}

/// Quarter turns, whole steps, and sizes that are powers of two.
fn placement(whole: &mut Whole) -> Affine {
    let mut placement = Affine::IDENTITY;
    let size = [0.5, 1.0, 2.0, -1.0][whole.next(1000).unsigned_abs() as usize % 4];
    let columns = [[size, 0.0, 0.0], [0.0, size, 0.0], [0.0, 0.0, size]];
    let turn = whole.next(1000).unsigned_abs() as usize % 3;
    placement.x_axis = columns[turn];
    placement.y_axis = columns[(turn + 1) % 3];
    placement.z_axis = columns[(turn + 2) % 3];
    placement.translation = whole.point(5000);
    placement
}

#[test]
fn top_levels_are_those_whose_hashes_are_stored() {
    let found = TOP_LEVELS.map(|(count, ..)| {
        let mut scene = Scene::new();
        let (root, mut whole) = (scene.root(), Whole(5));
        let handles = meshes().map(|mesh| {
            let mesh = Mesh::new(mesh.positions(), mesh.indices()).unwrap().with_quality(Quality::Fast);
            scene.add_mesh(mesh, Motion::Rigid).unwrap()
        });
        for number in 0..count {
            scene.add_instance(root, handles[number % handles.len()], placement(&mut whole)).unwrap();
        }
        let view = scene.commit();
        let mut hash = Hash::new();
        hash.tree(view.top_level().tree());
        view.top_level().instances().iter().for_each(|instance| hash.word(*instance));
        (count, view.report().top_level.method, hash.0)
    });
    assert!(found == TOP_LEVELS, "at level {:?} they are {found:#x?}", Level::current());
}

/// The level of builds is one per process.
#[test]
fn hashes_are_the_same_at_every_level() {
    for level in Level::available() {
        for test in ["trees_are_those_whose_hashes_are_stored", "top_levels_are_those_whose_hashes_are_stored"] {
            let mut command = Command::new(std::env::current_exe().unwrap());
            let output = command.args([test, "--exact"]).env("KINETREE_SIMD", level.name()).output().unwrap();
            let text = String::from_utf8_lossy(&output.stdout);
            assert!(output.status.success() && text.contains("1 passed"), "{level:?}: {text}");
        }
    }
}
