//! Carrying out cuts: the one place that knows about threads, node order and leaf sizes.
//!
//! A tree over n references has at most 2n - 1 nodes. The nodes below a child get a slice of their own beforehand, so that subtrees grow
//! at the same time without knowing of each other; what stays unused is closed up at the end.

use super::BuildOptions;
use super::cut::{Chooser, Cut, median};
use super::reference::{GRAIN, Reference, bounds_of};
use crate::geometry::Aabb;
use crate::threads::Threads;
use crate::tree::{Bvh, Link, MAX_DEPTH, Node, Target};

/// Grows a tree over references, of `distinct` different primitives.
pub(crate) fn grow(mut references: Vec<Reference>, chooser: &impl Chooser, options: &BuildOptions) -> Bvh {
    let count = references.len();
    if count == 0 {
        return Bvh::default();
    }
    let mut nodes = vec![UNUSED; 2 * count - 1];
    let bounds = bounds_of(&references, &options.threads);
    let (root, below) = nodes.split_first_mut().expect("there is a reference, so there is a node");
    let plot = Plot { references: &mut references, first_place: 0, root, below, below_at: 1, bounds, depth: 1 };
    Growth { chooser, leaf_limit: options.leaf_limit(), threads: &options.threads }.grow(plot);
    let primitives: Vec<u32> = references.iter().map(|reference| reference.id).collect();
    Bvh::from_parts(close_up(nodes), primitives, count as u32)
}

/// No node leads to the root, so this link is free to mean that a node is not in use.
const UNUSED: Node = Node { bounds: Aabb::EMPTY, link: Link::UNUSED };

struct Growth<'a, C> {
    chooser: &'a C,
    leaf_limit: usize,
    threads: &'a Threads,
}

/// A subtree to grow, and where.
struct Plot<'a> {
    references: &'a mut [Reference],
    /// Where these references stand among all.
    first_place: u32,
    root: &'a mut Node,
    /// Room for 2n - 2 nodes.
    below: &'a mut [Node],
    /// Number of the first of them.
    below_at: u32,
    bounds: Aabb,
    depth: usize,
}

impl<C: Chooser> Growth<'_, C> {
    fn grow(&self, plot: Plot<'_>) {
        let Plot { references, first_place, root, below, below_at, bounds, depth } = plot;
        let count = references.len();
        let cut = self.cut(references, &bounds, depth);
        let Cut::Object { left } = cut else {
            *root = Node { bounds, link: Link::primitives(first_place..first_place + count as u32) };
            return;
        };
        *root = Node { bounds, link: Link::node(below_at) };
        let (here, there) = references.split_at_mut(left);
        let (pair, rest) = below.split_at_mut(2);
        let (one, other) = pair.split_at_mut(1);
        let (below_here, below_there) = rest.split_at_mut(2 * left - 2);
        let here = Plot {
            bounds: bounds_of(here, self.threads),
            references: here,
            first_place,
            root: &mut one[0],
            below: below_here,
            below_at: below_at + 2,
            depth: depth + 1,
        };
        let there = Plot {
            bounds: bounds_of(there, self.threads),
            references: there,
            first_place: first_place + left as u32,
            root: &mut other[0],
            below: below_there,
            below_at: below_at + 2 * left as u32,
            depth: depth + 1,
        };
        if count > GRAIN / 4 {
            self.threads.join(|| self.grow(here), || self.grow(there));
        } else {
            self.grow(here);
            self.grow(there);
        }
    }

    fn cut(&self, references: &mut [Reference], bounds: &Aabb, depth: usize) -> Cut {
        let count = references.len();
        if count == 1 {
            return Cut::Leaf;
        }
        // Halving from here on just keeps promise 6.
        let halvings = count.next_power_of_two().ilog2() as usize;
        if depth + halvings >= MAX_DEPTH {
            return if count <= self.leaf_limit { Cut::Leaf } else { median(references) };
        }
        match self.chooser.choose(references, bounds, self.threads) {
            Cut::Leaf if count > self.leaf_limit => median(references),
            cut => cut,
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
    let mut kept = Vec::with_capacity(used as usize);
    kept.extend(nodes.into_iter().filter(|node| *node != UNUSED).map(|node| match node.link.target() {
        Target::Node(first) => Node { link: Link::node(place_of[first as usize]), ..node },
        Target::Primitives(_) => node,
    }));
    kept
}
