//! The slow and the fast algorithm agree, trees keep their promises, and work stays far below
//! quadratic.

use super::dendrogram::{Dendrogram, Pair};
use super::*;
use crate::test_random::Random;
use crate::tree::{MAX_DEPTH, Target};

/// Never scans all clusters.
const ALWAYS_INDEX: usize = 0;
/// Never uses the index.
const NEVER_INDEX: usize = usize::MAX;

/// Random boxes.
trait Boxes {
    fn point(&mut self, size: f32) -> [f32; 3];

    /// A box in a cube of this size, with edges up to `edge`.
    fn brick(&mut self, size: f32, edge: f32) -> Aabb;
}

impl Boxes for Random {
    fn point(&mut self, size: f32) -> [f32; 3] {
        std::array::from_fn(|_| self.unit() * size)
    }

    fn brick(&mut self, size: f32, edge: f32) -> Aabb {
        let (min, extent) = (self.point(size), self.point(edge));
        Aabb::new(min, std::array::from_fn(|axis| min[axis] + extent[axis]))
    }
}

/// Boxes with edges up to 1, in a cube of ten cubic metres per box.
fn scattered(count: usize, seed: u64) -> Vec<Aabb> {
    let mut random = Random(seed);
    let size = (count as f32 * 10.0).cbrt();
    (0..count).map(|_| random.brick(size, 1.0)).collect()
}

/// Boxes in groups of the same density for any count, with sizes over four orders of magnitude.
fn bunched(count: usize, seed: u64) -> Vec<Aabb> {
    let mut random = Random(seed);
    let size = 100.0 * (count as f32).cbrt();
    let middles: Vec<[f32; 3]> = (0..1 + count / 50).map(|_| random.point(size)).collect();
    let brick = |_| {
        let middle = middles[random.below(middles.len())];
        let edge = 10.0_f32.powf(random.unit() * 4.0 - 3.0);
        let brick = random.brick(20.0, edge);
        let moved = |corner: [f32; 3]| std::array::from_fn(|axis| corner[axis] + middle[axis]);
        Aabb::new(moved(brick.min), moved(brick.max))
    };
    (0..count).map(brick).collect()
}

fn point(at: [f32; 3]) -> Aabb {
    Aabb::new(at, at)
}

/// Unit cubes on a grid: nearly everything is a tie.
fn grid(across: usize, step: f32) -> Vec<Aabb> {
    let cell = |i: usize| [i % across, i / across % across, i / across / across].map(|x| x as f32 * step);
    (0..across.pow(3)).map(cell).map(|min| Aabb::new(min, min.map(|x| x + 1.0))).collect()
}

/// Every box contains the one before.
fn nested(count: usize) -> Vec<Aabb> {
    (1..=count).map(|i| Aabb::new([-(i as f32); 3], [i as f32 * 2.0; 3])).collect()
}

/// Corner to corner, each larger than the last.
fn growing(count: usize, factor: f32) -> Vec<Aabb> {
    let corner = |i: usize| [factor.powi(i as i32); 3];
    (0..count).map(|i| Aabb::new(corner(i), corner(i + 1))).collect()
}

/// All the kinds of boxes that both algorithms must agree on, with names.
fn worlds(seed: u64) -> Vec<(&'static str, Vec<Aabb>)> {
    let mut random = Random(seed);
    let count = 2 + random.below(150);
    let mut worlds = vec![
        ("scattered", scattered(count, seed)),
        ("bunched", bunched(count, seed)),
        ("dense", (0..count).map(|_| random.brick(1.0, 1.0)).collect()),
        ("points", (0..count).map(|_| point(random.point(5.0))).collect()),
        ("points on few places", (0..count).map(|_| point(random.point(3.0).map(f32::floor))).collect()),
        ("collinear points", (0..count).map(|_| point([0.0, random.unit(), 7.0])).collect()),
        (
            "points on both zeros",
            (0..count).map(|_| point([0; 3].map(|_| [0.0, -0.0, 1.0][random.below(3)]))).collect(),
        ),
        ("diagonal points", (0..count).map(|_| point([random.unit(); 3])).collect()),
        ("tiny", (0..count).map(|_| random.brick(1e-20, 1e-22)).collect()),
        ("beyond the tiniest area", (0..count).map(|_| random.brick(3e-22, 1e-22)).collect()),
        ("far from the origin", (0..count).map(|_| random.brick(1.0, 0.1)).collect()),
        ("around zero", (0..count).map(|_| random.brick(2.0, 1.0)).collect()),
    ];
    let moved = |brick: &mut Aabb, by: f32| {
        brick.min = brick.min.map(|x| x + by);
        brick.max = brick.max.map(|x| x + by);
    };
    worlds[10].1.iter_mut().for_each(|brick| moved(brick, 1e6));
    worlds[11].1.iter_mut().for_each(|brick| {
        moved(brick, -1.0);
        // Both zeros, at either end.
        let axis = random.below(3);
        brick.min[axis] = if random.below(2) == 0 { 0.0 } else { -0.0 };
        brick.max[axis] = if random.below(2) == 0 { 0.0 } else { -0.0 };
    });

    let mut flat = scattered(count, seed ^ 1);
    flat.iter_mut().for_each(|brick| brick.max[1] = brick.min[1]);
    worlds.push(("flat", flat.clone()));
    flat.iter_mut().for_each(|brick| (brick.min[1], brick.max[1]) = (2.0, 2.0));
    worlds.push(("in one plane", flat));

    let mut large_among_small = scattered(count, seed ^ 2);
    for _ in 0..1 + count / 20 {
        let place = random.below(count);
        large_among_small[place] = random.brick(10.0, 1e4);
    }
    worlds.push(("large among small", large_among_small));

    let mut awkward = scattered(count, seed ^ 3);
    for brick in &mut awkward {
        match random.below(12) {
            0 => *brick = Aabb::EMPTY,
            1 => *brick = Aabb::new([-f32::MAX; 3], [f32::MAX; 3]),
            2 => brick.max[random.below(3)] = f32::INFINITY,
            3 => brick.min[random.below(3)] = f32::NAN,
            4 => *brick = Aabb::new([f32::NEG_INFINITY; 3], [f32::INFINITY; 3]),
            5 => brick.max[random.below(3)] = -1.0,
            6 => *brick = point([f32::INFINITY; 3]),
            7 => brick.max = brick.max.map(|x| x * 1e19),
            8 => brick.max[random.below(3)] = 3e38,
            _ => {}
        }
    }
    worlds.push(("awkward", awkward));
    worlds
}

/// The same merges, with the same bits.
fn assert_same_merges(a: &Dendrogram, b: &Dendrogram, what: &str) {
    let bits = |pair: &Pair| (pair.distance.to_bits(), pair.left, pair.right);
    let (a, b) = (a.sorted(), b.sorted());
    assert_eq!(a.len(), b.len(), "{what}");
    for (a, b) in a.iter().zip(&b) {
        assert_eq!(bits(a), bits(b), "{what}");
    }
}

/// The same trees, with the same bits.
fn assert_same_trees(a: &Agglomerated, b: &Agglomerated, what: &str) {
    assert_eq!(a.rebalanced, b.rebalanced, "{what}");
    assert_eq!(a.bvh.primitives(), b.bvh.primitives(), "{what}");
    assert_eq!(a.bvh.node_count(), b.bvh.node_count(), "{what}");
    for (a, b) in a.bvh.nodes().iter().zip(b.bvh.nodes()) {
        assert_eq!(a.link, b.link, "{what}");
        assert_eq!(a.bounds.min.map(f32::to_bits), b.bounds.min.map(f32::to_bits), "{what}");
        assert_eq!(a.bounds.max.map(f32::to_bits), b.bounds.max.map(f32::to_bits), "{what}");
    }
}

/// Checks the promises of a tree, and those of this builder: one primitive per leaf, with its own
/// box.
fn assert_sound(made: &Agglomerated, boxes: &[Aabb], what: &str) {
    assert_eq!(made.bvh.validate(), Ok(()), "{what}");
    assert_eq!(made.bvh.node_count(), (2 * boxes.len()).saturating_sub(1), "{what}");
    assert!(made.bvh.depth() <= MAX_DEPTH, "{what}");
    assert!(!made.bvh.has_duplicates() && made.bvh.primitive_count() == boxes.len(), "{what}");
    for node in made.bvh.nodes() {
        if let Target::Primitives(places) = node.link.target() {
            assert_eq!(places.len(), 1, "{what}");
            let given = &boxes[made.bvh.primitives()[places.start as usize] as usize];
            assert!(node.bounds == *given || !given.has_point(), "{what}");
        }
    }
}

/// Compares both algorithms, with and without the index.
fn assert_twins_agree(boxes: &[Aabb], what: &str) {
    let (slow, _) = naive::naive(boxes);
    // The naive search makes its merges in ascending order.
    assert!(slow.merges.is_sorted(), "{what}");
    for linear_up_to in [ALWAYS_INDEX, 40, NEVER_INDEX] {
        let (fast, _) = chain::best_match_chain(boxes, linear_up_to);
        assert_same_merges(&slow, &fast, what);
    }
    let (slow, fast) = (agglomerate_naive(boxes), agglomerate(boxes));
    assert_same_trees(&slow, &fast, what);
    assert_sound(&fast, boxes, what);
}

#[test]
fn nothing_one_and_two_make_trees() {
    let boxes = [point([1.0; 3]), point([2.0, 3.0, 4.0])];
    for count in 0..=2 {
        assert_twins_agree(&boxes[..count], "few points");
        assert_eq!(agglomerate(&boxes[..count]).work.queries, 2 * count.saturating_sub(1) as u64);
    }
    assert_eq!(agglomerate(&boxes).bvh.bounds(), Aabb::new([1.0; 3], [2.0, 3.0, 4.0]));
}

#[test]
fn the_twins_agree_on_all_kinds_of_worlds() {
    for seed in 0..60 {
        for (name, boxes) in worlds(seed) {
            assert_twins_agree(&boxes, &format!("{name}, seed {seed}"));
        }
    }
}

#[test]
fn the_twins_agree_where_everything_is_a_tie() {
    for (across, step) in [(2, 1.0), (3, 2.0), (4, 1.0), (5, 1.5), (6, 0.5)] {
        assert_twins_agree(&grid(across, step), &format!("grid {across} by {step}"));
    }
    for count in [3, 16, 17, 63, 64, 65, 150] {
        assert_twins_agree(&vec![Aabb::new([1.0; 3], [2.0; 3]); count], &format!("{count} times the same"));
        assert_twins_agree(&vec![Aabb::EMPTY; count], &format!("{count} empty"));
        assert_twins_agree(&vec![Aabb::new([f32::NAN; 3], [1.0; 3]); count], &format!("{count} NaN"));
        let all = Aabb::new([f32::NEG_INFINITY; 3], [f32::INFINITY; 3]);
        assert_twins_agree(&vec![all; count], &format!("{count} infinite"));
        assert_twins_agree(&nested(count), &format!("{count} nested"));
    }
}

/// Greedy merging by size alone: each new box joins all that are smaller.
#[test]
fn growing_boxes_make_a_long_path_and_both_twins_make_it() {
    let boxes = growing(90, 1.5);
    assert_twins_agree(&boxes, "growing");
    let made = agglomerate(&boxes);
    assert!((40..=MAX_DEPTH).contains(&made.bvh.depth()), "depth {}", made.bvh.depth());
    assert_eq!(made.rebalanced, 0);
}

#[test]
fn paths_beyond_the_bound_are_rebalanced_and_counted() {
    for count in [MAX_DEPTH, MAX_DEPTH + 1, 300, 20_000] {
        let boxes = vec![Aabb::new([0.0; 3], [1.0; 3]); count];
        let made = agglomerate(&boxes);
        assert_sound(&made, &boxes, &format!("{count} times the same"));
        assert_eq!(made.bvh.depth(), MAX_DEPTH);
        assert_eq!(made.rebalanced, usize::from(count > MAX_DEPTH), "{count} times the same");
    }
}

#[test]
fn a_subtree_that_is_too_deep_leaves_the_others_as_they_were() {
    // A hundred equal boxes, which make a long path, and far away some that do not.
    let mut boxes = vec![Aabb::new([0.0; 3], [1.0; 3]); 100];
    boxes.extend(grid(3, 4.0).iter().map(|cell| {
        let moved = |corner: [f32; 3]| corner.map(|x| x + 1000.0);
        Aabb::new(moved(cell.min), moved(cell.max))
    }));
    let (made, alone) = (agglomerate(&boxes), agglomerate(&boxes[100..]));
    assert_sound(&made, &boxes, "path and grid");
    assert_eq!(made.rebalanced, 1);
    let Target::Node(first) = made.bvh.nodes()[0].link.target() else { panic!("the root is an inner node") };
    // In depth-first order, all nodes below the right child come last.
    let last = made.bvh.node_count() - (alone.bvh.node_count() - 1);
    let right = [made.bvh.nodes()[first as usize + 1].bounds];
    let below = made.bvh.nodes()[last..].iter().map(|node| node.bounds);
    assert!(right.into_iter().chain(below).eq(alone.bvh.nodes().iter().map(|node| node.bounds)));
}

#[test]
fn the_left_child_holds_the_smaller_number() {
    let made = agglomerate(&scattered(500, 5));
    let nodes = made.bvh.nodes();
    let mut smallest = vec![u32::MAX; nodes.len()];
    for at in (0..nodes.len()).rev() {
        smallest[at] = match nodes[at].link.target() {
            Target::Node(first) => {
                let (left, right) = (smallest[first as usize], smallest[first as usize + 1]);
                assert!(left < right);
                left
            }
            Target::Primitives(places) => made.bvh.primitives()[places.start as usize],
        };
    }
}

#[test]
fn the_index_finds_what_looking_at_each_finds() {
    let worlds = [
        ("scattered", scattered(20_000, 1)),
        ("bunched", bunched(8_000, 2)),
        ("grid", grid(18, 1.25)),
        ("nested", nested(3_000)),
        (
            "flat",
            scattered(6_000, 3)
                .iter()
                .map(|b| Aabb::new([b.min[0], 0.0, b.min[2]], [b.max[0], 0.0, b.max[2]]))
                .collect(),
        ),
    ];
    for (name, boxes) in worlds {
        let (by_index, _) = chain::best_match_chain(&boxes, ALWAYS_INDEX);
        let (brute_force, _) = chain::best_match_chain(&boxes, NEVER_INDEX);
        assert_same_merges(&by_index, &brute_force, name);
        assert_sound(&agglomerate(&boxes), &boxes, name);
    }
}

/// The work, bounds included, grows by less than the power 1.3.
fn assert_work_stays_far_below_quadratic(counts: [usize; 3], world: impl Fn(usize) -> Vec<Aabb>) {
    let work = counts.map(|count| {
        let (dendrogram, work) = chain::best_match_chain(&world(count), ALWAYS_INDEX);
        assert_eq!(dendrogram.merges.len(), count - 1);
        assert!(work.queries < 4 * count as u64, "{count} boxes: {work:?}");
        println!("{count} boxes: {work:?}");
        (work.distances + work.bounds) as f64
    });
    for step in 1..3 {
        let growth = (counts[step] as f64 / counts[step - 1] as f64).powf(1.3);
        assert!(work[step] < growth * work[step - 1], "{counts:?} boxes: {work:?}");
    }
}

#[test]
fn work_on_scattered_boxes_stays_far_below_quadratic() {
    assert_work_stays_far_below_quadratic([1_000, 10_000, 100_000], |count| scattered(count, 11));
}

#[test]
fn work_on_bunches_of_all_sizes_stays_far_below_quadratic() {
    assert_work_stays_far_below_quadratic([1_000, 10_000, 100_000], |count| bunched(count, 12));
}

#[test]
fn work_with_very_large_boxes_among_small_ones_stays_far_below_quadratic() {
    // The world of the smallest count is wider than its largest boxes; in a smaller one all would
    // overlap.
    assert_work_stays_far_below_quadratic([4_000, 20_000, 100_000], |count| {
        let mut random = Random(13);
        let mut boxes = scattered(count, 13);
        boxes.iter_mut().step_by(100).for_each(|brick| *brick = random.brick((count as f32 * 10.0).cbrt(), 30.0));
        boxes
    });
}

#[test]
fn work_stays_far_below_quadratic_where_everything_is_a_tie() {
    assert_work_stays_far_below_quadratic([1_000, 10_000, 100_000], |count| vec![point([1.0; 3]); count]);
    let on_a_line = |count: usize| (0..count).map(|i| point([0.0, (i * 7919 % count) as f32, 0.0])).collect();
    assert_work_stays_far_below_quadratic([1_000, 10_000, 100_000], on_a_line);
    assert_work_stays_far_below_quadratic([1_000, 10_000, 100_000], nested);
    assert_work_stays_far_below_quadratic([1_000, 8_000, 64_000], |count| grid((count as f64).cbrt() as usize, 1.5));
}
