//! Carrying out cuts: the one place that knows about threads, node order and leaf sizes.
//!
//! A tree over n references has at most 2n - 1 nodes. The nodes below a child get a slice of their own beforehand, so that subtrees grow
//! at the same time without knowing of each other; what stays unused is closed up at the end. Where references may be cut in two, n counts the
//! room for more of them too; a cut shares the room that is left between the sides by their numbers, so that it does not matter which
//! side grows first (compare Fuetterling et al. 2016, "Parallel Spatial Splits in Bounding Volume Hierarchies").

use super::BuildOptions;
use super::cut::{Chooser, Cut, median};
use super::reference::{GRAIN, Reference, bounds_of};
use crate::arena::with_room;
use crate::geometry::Aabb;
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
    options.threads.stage(SHARE, count);
    if room > 0 {
        let mut larger = with_room(count + room);
        larger.extend_from_slice(&references);
        larger.resize(count + room, Reference { bounds: Aabb::EMPTY, id: 0 });
        references = larger;
    }
    let mut nodes = with_room(2 * references.len() - 1);
    nodes.resize(2 * references.len() - 1, UNUSED);
    let (root, below) = nodes.split_first_mut().expect("there is a reference, so there is a node");
    let plot = Plot { references: &mut references, count, first_place: 0, root, below, below_at: 1, bounds, depth: 1 };
    Growth { chooser, leaf_limit: options.leaf_limit(), threads: &options.threads }.grow(plot);
    if options.threads.is_cancelled() {
        return unfinished(bounds, references[0].id);
    }
    if room > 0 {
        close_up_references(&mut references, &mut nodes);
    }
    let primitives: Vec<u32> = references.iter().map(|reference| reference.id).collect();
    Bvh::from_parts(close_up(nodes), primitives, distinct as u32)
}

/// No node leads to the root, so this link is free to mean that a node is not in use.
const UNUSED: Node = Node { bounds: Aabb::EMPTY, link: Link::UNUSED };

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

/// A subtree to grow, and where.
struct Plot<'a> {
    /// The first `count` are in the subtree; the others are room for more.
    references: &'a mut [Reference],
    count: usize,
    /// Where these references stand among all.
    first_place: u32,
    root: &'a mut Node,
    /// Room for 2n - 2 nodes, for n references with the room for more.
    below: &'a mut [Node],
    /// Number of the first of them.
    below_at: u32,
    bounds: Aabb,
    depth: usize,
}

impl<C: Chooser> Growth<'_, C> {
    fn grow(&self, plot: Plot<'_>) {
        let Plot { references, count, first_place, root, below, below_at, bounds, depth } = plot;
        if self.threads.is_cancelled() {
            *root = Node { bounds, link: Link::primitives(first_place..first_place + 1) };
            return;
        }
        let (left, right) = match self.cut(references, count, &bounds, depth) {
            Cut::Leaf => {
                *root = Node { bounds, link: Link::primitives(first_place..first_place + count as u32) };
                return;
            }
            Cut::Object { left } => (left, count - left),
            Cut::Spatial { left, right } => (left, right),
        };
        *root = Node { bounds, link: Link::node(below_at) };
        let sides = [&references[..left], &references[left..left + right]];
        let sides = sides.map(|side| bounds_of(side, self.threads));
        let room = room_on_the_left(references.len() - left - right, left, right);
        if room > 0 {
            references.copy_within(left..left + right, left + room);
        }
        let (here, there) = references.split_at_mut(left + room);
        let (pair, rest) = below.split_at_mut(2);
        let (one, other) = pair.split_at_mut(1);
        let (below_here, below_there) = rest.split_at_mut(2 * here.len() - 2);
        let there = Plot {
            count: right,
            first_place: first_place + here.len() as u32,
            root: &mut other[0],
            below: below_there,
            below_at: below_at + 2 * here.len() as u32,
            bounds: sides[1],
            depth: depth + 1,
            references: there,
        };
        let here = Plot {
            references: here,
            count: left,
            first_place,
            root: &mut one[0],
            below: below_here,
            below_at: below_at + 2,
            bounds: sides[0],
            depth: depth + 1,
        };
        if count > SHARED_ABOVE {
            self.threads.join(|| self.grow_and_tell(here), || self.grow_and_tell(there));
        } else {
            self.grow(here);
            self.grow(there);
        }
    }

    fn grow_and_tell(&self, plot: Plot<'_>) {
        let count = plot.count;
        self.grow(plot);
        if count <= SHARED_ABOVE {
            self.threads.tick(count);
        }
    }

    fn cut(&self, references: &mut [Reference], count: usize, bounds: &Aabb, depth: usize) -> Cut {
        if count == 1 {
            return Cut::Leaf;
        }
        // Halving from here on just keeps promise 6.
        let halvings = count.next_power_of_two().ilog2() as usize;
        if depth + halvings >= MAX_DEPTH {
            return if count <= self.leaf_limit { Cut::Leaf } else { median(&mut references[..count]) };
        }
        match self.chooser.choose_with_room(references, count, bounds, self.threads) {
            Cut::Leaf if count > self.leaf_limit => median(&mut references[..count]),
            cut => cut,
        }
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

/// Moves the references that stand in leaves to the front, in their order.
fn close_up_references(references: &mut Vec<Reference>, nodes: &mut [Node]) {
    let mut place_of = vec![u32::MAX; references.len()];
    let leaves: Vec<usize> = (0..nodes.len()).filter(|&at| nodes[at] != UNUSED && nodes[at].link.is_leaf()).collect();
    for &leaf in &leaves {
        if let Target::Primitives(places) = nodes[leaf].link.target() {
            place_of[places.start as usize..places.end as usize].fill(0);
        }
    }
    let mut used = 0;
    for place in 0..references.len() {
        if place_of[place] == 0 {
            references[used] = references[place];
            place_of[place] = used as u32;
            used += 1;
        }
    }
    references.truncate(used);
    for &leaf in &leaves {
        if let Target::Primitives(places) = nodes[leaf].link.target() {
            let first = place_of[places.start as usize];
            nodes[leaf].link = Link::primitives(first..first + places.len() as u32);
        }
    }
}

/// Removes unused nodes; the others keep their order.
fn close_up(nodes: Vec<Node>) -> Vec<Node> {
    let mut used = 0;
    let place_of: Vec<u32> = nodes
        .iter()
        .map(|node| {
            used += u32::from(*node != UNUSED);
            used.wrapping_sub(1)
        })
        .collect();
    let mut kept = with_room(used as usize);
    kept.extend(nodes.into_iter().filter(|node| *node != UNUSED).map(|node| match node.link.target() {
        Target::Node(first) => Node { link: Link::node(place_of[first as usize]), ..node },
        Target::Primitives(_) => node,
    }));
    kept
}
