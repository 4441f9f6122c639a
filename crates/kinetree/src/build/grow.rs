//! The top-down recursion: threads, node order and leaf sizes.
//!
//! The two sides of a large set grow in parallel. One thread grows a small set, into its own lists,
//! which are joined at the end. With spatial splits, free slots follow the references; a cut
//! divides the slots that are left between the sides in proportion to their counts, so that the
//! result does not depend on which side grows first (compare Fuetterling et al. 2016, "Parallel
//! Spatial Splits in Bounding Volume Hierarchies").

use super::BuildOptions;
use super::cut::{Chooser, Cut, Side, median};
use super::reference::{GRAIN, Reference, bounds_of};
use crate::geometry::Aabb;
use crate::memory::vec_in_large_pages;
use crate::threads::Threads;
use crate::tree::{Bvh, Link, MAX_DEPTH, Node, Target};

/// Grows a tree over references to distinct primitives.
pub(crate) fn grow(references: Vec<Reference>, chooser: &impl Chooser, options: &BuildOptions) -> Bvh {
    let distinct = references.len();
    grow_with_spare(references, distinct, 0, chooser, options)
}

/// Grows a tree over references to `distinct` primitives. Splits may add up to `spare` references.
pub(crate) fn grow_with_spare(
    mut references: Vec<Reference>,
    distinct: usize,
    spare: usize,
    chooser: &impl Chooser,
    options: &BuildOptions,
) -> Bvh {
    let count = references.len();
    if count == 0 {
        return Bvh::default();
    }
    let bounds = bounds_of(&references, &options.threads);
    options.threads.begin_stage(STAGE_FRACTION, count);
    references.reserve_exact(spare);
    references.resize(count + spare, Reference::new(Aabb::EMPTY, 0));
    let growth = Growth { chooser, leaf_limit: options.leaf_limit(), threads: &options.threads };
    let tree = growth.grow(ReferenceSet { references: &mut references, count, bounds, depth: 1 });
    if options.threads.is_cancelled() {
        return unfinished(bounds, references[0].id);
    }
    drop(references);
    let (nodes, primitives) = tree.joined();
    Bvh::from_parts(nodes, primitives, distinct as u32)
}

/// The result of a cancelled build: a valid tree over a single primitive, so that later stages need
/// no special case.
pub(super) fn unfinished(bounds: Aabb, primitive: u32) -> Bvh {
    Bvh::from_parts(vec![Node { bounds, link: Link::primitives(0..1) }], vec![primitive], 1)
}

/// The fraction of a build's remaining time that growing takes, for progress.
const STAGE_FRACTION: f32 = 0.7;

/// The children of nodes with more references than this are grown in parallel.
const PARALLEL_ABOVE: usize = GRAIN / 4;

struct Growth<'a, C> {
    chooser: &'a C,
    leaf_limit: usize,
    threads: &'a Threads,
}

/// A set of references to grow a subtree over.
struct ReferenceSet<'a> {
    /// The references are the first `count`; the slots after them are free.
    references: &'a mut [Reference],
    count: usize,
    bounds: Aabb,
    depth: usize,
}

impl<'a> ReferenceSet<'a> {
    /// The sets of the two sides, each with its part of the free slots.
    fn divided(self, [left, right]: [Side; 2]) -> [Self; 2] {
        let Self { references, depth, .. } = self;
        let spare = spare_for_left(references.len() - left.count - right.count, left.count, right.count);
        if spare > 0 {
            references.copy_within(left.count..left.count + right.count, left.count + spare);
        }
        let (left_slots, right_slots) = references.split_at_mut(left.count + spare);
        let set = |references: &'a mut [Reference], side: Side| Self {
            references,
            count: side.count,
            bounds: side.bounds,
            depth: depth + 1,
        };
        [set(left_slots, left), set(right_slots, right)]
    }
}

/// How many of the free slots the left side gets, in proportion to the counts of references. (In
/// proportion to the areas of the boxes, more slots stayed unused where all large boxes were flat,
/// and rays visited more nodes.)
fn spare_for_left(spare: usize, left: usize, right: usize) -> usize {
    match (left, right) {
        // A single reference is a leaf.
        (1, _) => 0,
        (_, 1) => spare,
        _ => (spare as u64 * left as u64 / (left + right) as u64) as usize,
    }
}

impl<C: Chooser> Growth<'_, C> {
    fn grow(&self, mut set: ReferenceSet<'_>) -> Grown {
        let count = set.count;
        if count > PARALLEL_ABOVE
            && let Cut::Sides(sides) = self.cut(&mut set)
        {
            let bounds = set.bounds;
            let [left, right] = set.divided(sides);
            let (left, right) = self.threads.join(|| self.grow(left), || self.grow(right));
            return Grown::Large { bounds, sides: Box::new([left, right]) };
        }
        let mut small = Small { nodes: vec![PLACEHOLDER], primitives: Vec::with_capacity(count) };
        self.grow_small(set, 0, &mut small);
        // Fewer than `count` if the build was cancelled.
        self.threads.advance(small.primitives.len().min(count));
        Grown::Small(small)
    }

    /// Writes the subtree of a set: its root at index `at`, the other nodes at the end.
    fn grow_small(&self, mut set: ReferenceSet<'_>, at: usize, tree: &mut Small) {
        let bounds = set.bounds;
        let Cut::Sides(sides) = self.cut(&mut set) else {
            let first = tree.primitives.len() as u32;
            tree.primitives.extend(set.references[..set.count].iter().map(|reference| reference.id));
            tree.nodes[at] = Node { bounds, link: Link::primitives(first..first + set.count as u32) };
            return;
        };
        let pair = tree.nodes.len();
        tree.nodes[at] = Node { bounds, link: Link::node(pair as u32) };
        tree.nodes.extend([PLACEHOLDER; 2]);
        let [left, right] = set.divided(sides);
        self.grow_small(left, pair, tree);
        self.grow_small(right, pair + 1, tree);
    }

    fn cut(&self, set: &mut ReferenceSet<'_>) -> Cut {
        let ReferenceSet { references, count, bounds, depth } = set;
        let count = *count;
        if count == 1 {
            return Cut::Leaf;
        }
        if self.threads.is_cancelled() {
            // The tree will be dropped, but a leaf must have a valid link.
            set.count = 1;
            return Cut::Leaf;
        }
        // The depth limit (promise 6) leaves just enough levels for median splits.
        let halvings = count.next_power_of_two().ilog2() as usize;
        if *depth + halvings >= MAX_DEPTH {
            return if count <= self.leaf_limit { Cut::Leaf } else { median(&mut references[..count]) };
        }
        match self.chooser.choose_with_spare(references, count, bounds, self.threads) {
            Cut::Leaf if count > self.leaf_limit => median(&mut references[..count]),
            cut => cut,
        }
    }
}

/// A subtree, in one or several parts.
enum Grown {
    Small(Small),
    /// A node with two subtrees.
    Large {
        bounds: Aabb,
        sides: Box<[Grown; 2]>,
    },
}

/// A subtree whose links are relative to its root and its first primitive.
struct Small {
    nodes: Vec<Node>,
    primitives: Vec<u32>,
}

/// Reserves the slot of a node that is written later.
const PLACEHOLDER: Node = Node { bounds: Aabb::EMPTY, link: Link::UNUSED };

impl Grown {
    fn joined(self) -> (Vec<Node>, Vec<u32>) {
        let (nodes, primitives) = self.counts();
        let mut output = Small { nodes: vec_in_large_pages(nodes), primitives: vec_in_large_pages(primitives) };
        output.nodes.push(PLACEHOLDER);
        self.append(0, &mut output);
        (output.nodes, output.primitives)
    }

    fn counts(&self) -> (usize, usize) {
        match self {
            Self::Small(small) => (small.nodes.len(), small.primitives.len()),
            Self::Large { sides, .. } => {
                let [(nodes, primitives), (more_nodes, more_primitives)] = [0, 1].map(|side| sides[side].counts());
                (1 + nodes + more_nodes, primitives + more_primitives)
            }
        }
    }

    /// Writes the root at index `at`, and all other nodes at the end.
    fn append(self, at: usize, output: &mut Small) {
        match self {
            Self::Large { bounds, sides } => {
                let pair = output.nodes.len();
                output.nodes[at] = Node { bounds, link: Link::node(pair as u32) };
                output.nodes.extend([PLACEHOLDER; 2]);
                let [left, right] = *sides;
                left.append(pair, output);
                right.append(pair + 1, output);
            }
            Self::Small(small) => {
                // The root is written elsewhere, so the other nodes move up by one.
                let (nodes, primitives) = (output.nodes.len() as u32 - 1, output.primitives.len() as u32);
                let mut moved = small.nodes.iter().map(|node| Node {
                    link: match node.link.target() {
                        Target::Node(first) => Link::node(first + nodes),
                        Target::Primitives(range) => Link::primitives(range.start + primitives..range.end + primitives),
                    },
                    ..*node
                });
                if let Some(root) = moved.next() {
                    output.nodes[at] = root;
                }
                output.nodes.extend(moved);
                output.primitives.extend_from_slice(&small.primitives);
            }
        }
    }
}
