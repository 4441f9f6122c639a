//! Growing trees: the one place that knows about threads, node order and leaf sizes.
//!
//! Large sets are cut one after the other, and both sides grow at the same time. A small set is grown by one thread, into lists of its own; in the end these are
//! joined. Where references may be cut in two, there is room behind them; a cut shares what is left of it between the sides by their numbers, so that it
//! does not matter which side grows first (compare Fuetterling et al. 2016, "Parallel Spatial Splits in Bounding Volume Hierarchies").

use super::BuildOptions;
use super::cut::{Chooser, Cut, Side, median};
use super::reference::{GRAIN, Reference, bounds_of};
use crate::geometry::Aabb;
use crate::memory::vec_in_large_pages;
use crate::threads::Threads;
use crate::tree::{Bvh, Link, MAX_DEPTH, Node, Target};

/// Grows a tree over references, of as many different primitives.
pub(crate) fn grow(references: Vec<Reference>, chooser: &impl Chooser, options: &BuildOptions) -> Bvh {
    let distinct = references.len();
    grow_with_room(references, distinct, 0, chooser, options)
}

/// Grows a tree over references to `distinct` different primitives, where cuts may make up to `room` more.
pub(crate) fn grow_with_room(
    mut references: Vec<Reference>,
    distinct: usize,
    room: usize,
    chooser: &impl Chooser,
    options: &BuildOptions,
) -> Bvh {
    let count = references.len();
    if count == 0 {
        return Bvh::default();
    }
    let bounds = bounds_of(&references, &options.threads);
    options.threads.begin_stage(SHARE, count);
    references.reserve_exact(room);
    references.resize(count + room, Reference::new(Aabb::EMPTY, 0));
    let growth = Growth { chooser, leaf_limit: options.leaf_limit(), threads: &options.threads };
    let tree = growth.grow(Plot { references: &mut references, count, bounds, depth: 1 });
    if options.threads.is_cancelled() {
        return unfinished(bounds, references[0].id);
    }
    drop(references);
    let (nodes, primitives) = tree.joined();
    Bvh::from_parts(nodes, primitives, distinct as u32)
}

/// What a cancelled build ends with: a tree, so that nothing has to ask whether it is one, over a single primitive.
pub(super) fn unfinished(bounds: Aabb, primitive: u32) -> Bvh {
    Bvh::from_parts(vec![Node { bounds, link: Link::primitives(0..1) }], vec![primitive], 1)
}

/// Of the time that a build has left, for whoever watches it.
const SHARE: f32 = 0.7;

/// Subtrees with more references than this are grown at the same time.
const SHARED_ABOVE: usize = GRAIN / 4;

struct Growth<'a, C> {
    chooser: &'a C,
    leaf_limit: usize,
    threads: &'a Threads,
}

/// References to grow a tree over.
struct Plot<'a> {
    /// The first `count`; the others are room for more.
    references: &'a mut [Reference],
    count: usize,
    bounds: Aabb,
    depth: usize,
}

impl<'a> Plot<'a> {
    /// A plot for either side. They share the room.
    fn divided(self, [left, right]: [Side; 2]) -> [Self; 2] {
        let Self { references, depth, .. } = self;
        let room = room_on_the_left(references.len() - left.count - right.count, left.count, right.count);
        if room > 0 {
            references.copy_within(left.count..left.count + right.count, left.count + room);
        }
        let (here, there) = references.split_at_mut(left.count + room);
        let plot = |references: &'a mut [Reference], side: Side| Self {
            references,
            count: side.count,
            bounds: side.bounds,
            depth: depth + 1,
        };
        [plot(here, left), plot(there, right)]
    }
}

/// How much of the room behind two sides the left one gets: by their numbers. (By the areas of the boxes, more of it stayed unused where all
/// large boxes were flat, and rays met more nodes.)
fn room_on_the_left(room: usize, left: usize, right: usize) -> usize {
    match (left, right) {
        // A single reference is a leaf.
        (1, _) => 0,
        (_, 1) => room,
        _ => (room as u64 * left as u64 / (left + right) as u64) as usize,
    }
}

impl<C: Chooser> Growth<'_, C> {
    fn grow(&self, mut plot: Plot<'_>) -> Grown {
        let count = plot.count;
        if count > SHARED_ABOVE
            && let Cut::Sides(sides) = self.cut(&mut plot)
        {
            let bounds = plot.bounds;
            let [here, there] = plot.divided(sides);
            let (here, there) = self.threads.join(|| self.grow(here), || self.grow(there));
            return Grown::Large { bounds, sides: Box::new([here, there]) };
        }
        let mut small = Small { nodes: vec![NOT_YET], primitives: Vec::with_capacity(count) };
        self.grow_small(plot, 0, &mut small);
        // Of a build that was called off, hardly any.
        self.threads.advance(small.primitives.len().min(count));
        Grown::Small(small)
    }

    /// As the node `at` and those that follow.
    fn grow_small(&self, mut plot: Plot<'_>, at: usize, tree: &mut Small) {
        let bounds = plot.bounds;
        let Cut::Sides(sides) = self.cut(&mut plot) else {
            let first = tree.primitives.len() as u32;
            tree.primitives.extend(plot.references[..plot.count].iter().map(|reference| reference.id));
            tree.nodes[at] = Node { bounds, link: Link::primitives(first..first + plot.count as u32) };
            return;
        };
        let pair = tree.nodes.len();
        tree.nodes[at] = Node { bounds, link: Link::node(pair as u32) };
        tree.nodes.extend([NOT_YET; 2]);
        let [here, there] = plot.divided(sides);
        self.grow_small(here, pair, tree);
        self.grow_small(there, pair + 1, tree);
    }

    fn cut(&self, plot: &mut Plot<'_>) -> Cut {
        let Plot { references, count, bounds, depth } = plot;
        let count = *count;
        if count == 1 {
            return Cut::Leaf;
        }
        if self.threads.is_cancelled() {
            // Nobody will see the leaf, but its link has to hold.
            plot.count = 1;
            return Cut::Leaf;
        }
        // Halving from here on just keeps promise 6.
        let halvings = count.next_power_of_two().ilog2() as usize;
        if *depth + halvings >= MAX_DEPTH {
            return if count <= self.leaf_limit { Cut::Leaf } else { median(&mut references[..count]) };
        }
        match self.chooser.choose_with_room(references, count, bounds, self.threads) {
            Cut::Leaf if count > self.leaf_limit => median(&mut references[..count]),
            cut => cut,
        }
    }
}

/// A tree in pieces.
enum Grown {
    Small(Small),
    /// A node above two subtrees.
    Large {
        bounds: Aabb,
        sides: Box<[Grown; 2]>,
    },
}

/// A subtree whose links count from its own root and its own first primitive.
struct Small {
    nodes: Vec<Node>,
    primitives: Vec<u32>,
}

/// Stands where a node will be.
const NOT_YET: Node = Node { bounds: Aabb::EMPTY, link: Link::UNUSED };

impl Grown {
    fn joined(self) -> (Vec<Node>, Vec<u32>) {
        let (nodes, primitives) = self.counts();
        let mut whole = Small { nodes: vec_in_large_pages(nodes), primitives: vec_in_large_pages(primitives) };
        whole.nodes.push(NOT_YET);
        self.append(0, &mut whole);
        (whole.nodes, whole.primitives)
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

    /// Writes the root at `at`, and all others behind what is there.
    fn append(self, at: usize, whole: &mut Small) {
        match self {
            Self::Large { bounds, sides } => {
                let pair = whole.nodes.len();
                whole.nodes[at] = Node { bounds, link: Link::node(pair as u32) };
                whole.nodes.extend([NOT_YET; 2]);
                let [here, there] = *sides;
                here.append(pair, whole);
                there.append(pair + 1, whole);
            }
            Self::Small(small) => {
                // The root has gone elsewhere.
                let (nodes, primitives) = (whole.nodes.len() as u32 - 1, whole.primitives.len() as u32);
                let mut moved = small.nodes.iter().map(|node| Node {
                    link: match node.link.target() {
                        Target::Node(first) => Link::node(first + nodes),
                        Target::Primitives(places) => {
                            Link::primitives(places.start + primitives..places.end + primitives)
                        }
                    },
                    ..*node
                });
                if let Some(root) = moved.next() {
                    whole.nodes[at] = root;
                }
                whole.nodes.extend(moved);
                whole.primitives.extend_from_slice(&small.primitives);
            }
        }
    }
}
