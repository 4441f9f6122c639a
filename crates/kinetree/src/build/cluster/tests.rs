//! The promises of clustered trees, awkward input first.

use std::sync::Arc;

use super::pair::{Cluster, Kind};
use super::*;
use crate::test_random::Random;
use crate::threads::Backwards;
use crate::tree::{MAX_DEPTH, Target};

fn random_boxes(seed: u64, count: usize, spread: f32, size: f32) -> Vec<Aabb> {
    let mut generator = Random(seed);
    let mut unit = || generator.unit();
    let mut point = |size: f32| [0; 3].map(|_| (unit() * 2.0 - 1.0) * size);
    (0..count)
        .map(|_| {
            let (center, reach) = (point(spread), point(size));
            Aabb::from_points([center, [0, 1, 2].map(|axis| center[axis] + reach[axis])])
        })
        .collect()
}

/// Nested boxes with a common corner: the smallest two are always merged first, so the path is as
/// long as the list.
fn russian_dolls(count: i32) -> Vec<Aabb> {
    (0..count).map(|i| Aabb::new([0.0; 3], [1.1_f32.powi(i); 3])).collect()
}

/// Each input with each builder.
fn awkward_builds() -> impl Iterator<Item = (&'static str, Vec<Aabb>, Build)> {
    awkward().into_iter().flat_map(|(name, boxes)| BUILDS.map(|build| (name, boxes.clone(), build)))
}

fn awkward() -> Vec<(&'static str, Vec<Aabb>)> {
    let unit = Aabb::new([0.0; 3], [1.0; 3]);
    let nan = Aabb::new([f32::NAN; 3], [1.0; 3]);
    let row = |count: u32, step: f32| -> Vec<Aabb> {
        (0..count)
            .map(|i| Aabb::from_points([[i as f32 * step, 0.0, 0.0], [i as f32 * step + 0.5, 0.0, 0.0]]))
            .collect()
    };
    let huge = random_boxes(3, 700, 1e30, 1e30);
    let holes = random_boxes(4, 900, 1.0, 0.1).into_iter().enumerate();
    let holes = holes.map(|(i, bounds)| [bounds, Aabb::EMPTY, nan][i % 3]).collect();
    vec![
        ("nothing", vec![]),
        ("nothing but empty boxes", vec![Aabb::EMPTY; 40]),
        ("one", vec![unit]),
        ("two", vec![unit; 2]),
        ("all in the same place", vec![unit; 20_000]),
        ("points in the same place", vec![Aabb::new([3.0; 3], [3.0; 3]); 500]),
        ("flat", row(1000, 1.0)),
        ("flat and overlapping", row(1000, 0.01)),
        ("huge", huge),
        ("endless", vec![Aabb::new([f32::NEG_INFINITY; 3], [f32::INFINITY; 3]); 100]),
        (
            "the largest numbers",
            vec![Aabb::new([-f32::MAX; 3], [f32::MAX; 3]), unit, Aabb::new([f32::MAX; 3], [f32::MAX; 3])],
        ),
        ("tiny", random_boxes(5, 300, 1e-40, 1e-42)),
        ("empty boxes and no numbers between others", holes),
        ("russian dolls", russian_dolls(300)),
        ("some", random_boxes(6, 3000, 10.0, 0.3)),
        ("several chunks", random_boxes(7, 50_000, 10.0, 0.1)),
    ]
}

fn build(boxes: &[Aabb], max_leaf: u32, threads: Threads, level: Level) -> Bvh {
    let options = BuildOptions { max_leaf, threads, ..BuildOptions::default() };
    clustered_at(level, boxes.len(), |id| boxes[id as usize], &options, 1)
}

fn build_from_branches(boxes: &[Aabb], max_leaf: u32, threads: Threads, level: Level) -> Bvh {
    let options = BuildOptions { max_leaf, threads, ..BuildOptions::default() };
    clustered_at(level, boxes.len(), |id| boxes[id as usize], &options, max_leaf.min(FULL_LEAF))
}

type Build = fn(&[Aabb], u32, Threads, Level) -> Bvh;

const BUILDS: [Build; 2] = [build, build_from_branches];

#[test]
fn every_input_keeps_the_promises() {
    for (name, boxes) in awkward() {
        for (max_leaf, build) in [1, 2, 4, 15].into_iter().flat_map(|max_leaf| BUILDS.map(|build| (max_leaf, build))) {
            let bvh = build(&boxes, max_leaf, Threads::default(), Level::current());
            assert_eq!(bvh.validate(), Ok(()), "{name}");
            let mut primitives = bvh.primitives().to_vec();
            primitives.sort_unstable();
            let expected: Vec<u32> = (0..boxes.len() as u32).filter(|&id| boxes[id as usize].has_point()).collect();
            assert_eq!(primitives, expected, "{name}");
            for node in bvh.nodes() {
                if let Target::Primitives(range) = node.link.target() {
                    assert!(range.len() <= max_leaf as usize, "{name}");
                    let inside = &bvh.primitives()[range.start as usize..range.end as usize];
                    let around = inside.iter().fold(Aabb::EMPTY, |all, &id| all.union(&boxes[id as usize]));
                    assert_eq!(node.bounds, around, "{name}");
                }
            }
        }
    }
}

#[test]
fn primitives_stand_in_the_order_of_the_leaves() {
    for (name, boxes, build) in awkward_builds() {
        let bvh = build(&boxes, 2, Threads::default(), Level::current());
        let mut next = 0;
        let mut pending: Vec<u32> = (0..bvh.node_count().min(1) as u32).collect();
        while let Some(node) = pending.pop() {
            match bvh.nodes()[node as usize].link.target() {
                Target::Node(first) => pending.extend([first + 1, first]),
                Target::Primitives(range) => {
                    assert_eq!(range.start, next, "{name}");
                    next = range.end;
                }
            }
        }
        assert_eq!(next as usize, bvh.primitives().len(), "{name}");
    }
}

#[test]
fn the_tree_depends_on_neither_threads_nor_processor() {
    for (name, boxes, build) in awkward_builds() {
        let expected = build(&boxes, 4, Threads::one(), Level::available()[0]);
        for threads in [Threads::default(), Threads::of(Arc::new(Backwards))] {
            for level in Level::available() {
                let bvh = build(&boxes, 4, threads.clone(), level);
                assert!(bvh.nodes() == expected.nodes(), "{name}, {threads:?}, {level:?}");
                assert_eq!(bvh.primitives(), expected.primitives(), "{name}, {threads:?}, {level:?}");
            }
        }
    }
}

#[test]
fn endless_paths_are_cut_short_in_a_chunk_and_above() {
    let boxes = russian_dolls(300);
    let bvh = build(&boxes, 1, Threads::one(), Level::current());
    assert_eq!(bvh.depth(), MAX_DEPTH);

    let mut keys: Vec<u64> = (0..300).collect();
    let mut top = ChunkJoiner::new(Level::current());
    let mut chunks: Vec<Chunk<'_>> = Vec::new();
    for (bounds, keys) in boxes.iter().zip(keys.chunks_mut(1)) {
        chunks.push(Chunk {
            keys,
            pairs: Vec::new(),
            clusters: vec![Cluster { bounds: *bounds, kind: Kind::single(0) }],
        });
        top.then_chunk();
        if chunks.len() > 1 {
            top.then_join();
        }
    }
    let bvh = top.tree(&mut chunks, &Threads::one());
    assert_eq!(bvh.validate(), Ok(()));
    assert_eq!((bvh.primitive_count(), bvh.depth()), (300, 10));
}

#[test]
fn trees_are_about_as_good_as_those_of_binning() {
    for seed in 0..5 {
        let boxes = random_boxes(seed, 20_000, 10.0, 0.4);
        let options = BuildOptions { threads: Threads::one(), ..BuildOptions::default() };
        let binned = super::super::build_binned(boxes.len(), |id| boxes[id as usize], &options).cost(1.0, 1.0);
        for build in BUILDS {
            let cost = build(&boxes, 2, Threads::one(), Level::current()).cost(1.0, 1.0);
            assert!(cost < 1.15 * binned, "seed {seed}: {cost} against {binned}");
        }
    }
}
