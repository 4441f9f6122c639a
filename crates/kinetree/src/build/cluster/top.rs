//! The top of the tree: merges the clusters that the chunks have left, and writes the whole tree.

use super::super::reference::GRAIN;
use super::active_clusters::{ActiveClusters, Merger, RADIUS, REDUCED};
use super::chunk::Chunk;
use super::emit::{self, Subtree, balanced_height};
use super::pair::{Cluster, Half, Kind, Pair, half};
use crate::geometry::Aabb;
use crate::memory::vec_in_large_pages;
use crate::simd::Level;
use crate::threads::Threads;
use crate::tree::{Bvh, Link, MAX_DEPTH, Node};

/// The order in which chunks are joined.
pub(super) struct ChunkJoiner {
    steps: Vec<Step>,
    level: Level,
}

enum Step {
    /// Pushes the clusters of the next chunk.
    Chunk,
    /// Joins the last two branches.
    Join,
}

/// A cluster of a chunk: a leaf of the top.
struct TopLeaf {
    chunk: usize,
    kind: Kind,
}

/// Leaves of the top are never joined.
const NO_CHAINS: u32 = 1;

impl ChunkJoiner {
    pub(super) fn new(level: Level) -> Self {
        Self { steps: Vec::new(), level }
    }

    pub(super) fn then_chunk(&mut self) {
        self.steps.push(Step::Chunk);
    }

    pub(super) fn then_join(&mut self) {
        self.steps.push(Step::Join);
    }

    /// The tree over all chunks.
    pub(super) fn tree(&self, chunks: &mut [Chunk<'_>], threads: &Threads) -> Bvh {
        let (mut top_leaves, mut clusters) = (Vec::new(), Vec::new());
        for (number, chunk) in chunks.iter().enumerate() {
            for cluster in &chunk.clusters {
                clusters.push(Cluster { bounds: cluster.bounds, kind: Kind::single(top_leaves.len()) });
                top_leaves.push(TopLeaf { chunk: number, kind: cluster.kind });
            }
        }
        let mut pairs = Vec::with_capacity(top_leaves.len());
        let mut root = self.merge(&clusters, chunks, &mut pairs);
        // Each chunk must be able to fit a balanced tree below its root.
        if root.kind.height as usize + balanced_height(GRAIN) > MAX_DEPTH {
            pairs.clear();
            root = balanced(&clusters, &mut pairs);
        }
        write(self.level, &root, &pairs, &top_leaves, chunks, threads)
    }

    fn merge(&self, clusters: &[Cluster], chunks: &[Chunk<'_>], pairs: &mut Vec<Pair>) -> Cluster {
        let mut active = ActiveClusters::new();
        let mut merger = Merger { pairs, chains: &mut [], leaf_limit: NO_CHAINS, node_cost: 0.0 };
        let (mut sizes, mut chunks) = (chunks.iter().map(|chunk| chunk.clusters.len()), Vec::<usize>::new());
        let (mut rest, mut waiting) = (clusters, Vec::<Cluster>::new());
        for step in &self.steps {
            match step {
                Step::Chunk => {
                    let (next, others) = rest.split_at(sizes.next().unwrap_or(0));
                    waiting.extend(next);
                    rest = others;
                    chunks.push(next.len());
                }
                Step::Join => {
                    let both = chunks.pop().unwrap_or(0) + chunks.pop().unwrap_or(0);
                    active.clear();
                    waiting.drain(waiting.len() - both..).for_each(|cluster| active.push(&cluster));
                    active.reduce(REDUCED, RADIUS, self.level, &mut merger);
                    let before = waiting.len();
                    waiting.extend(active.clusters());
                    chunks.push(waiting.len() - before);
                }
            }
        }
        active.clear();
        waiting.iter().for_each(|cluster| active.push(cluster));
        active.reduce(1, RADIUS, self.level, &mut merger);
        active.clusters().next().expect("there is a primitive, and so a cluster")
    }
}

/// Merges clusters into a balanced tree.
fn balanced(clusters: &[Cluster], pairs: &mut Vec<Pair>) -> Cluster {
    if let [cluster] = clusters {
        return *cluster;
    }
    let (left, right) = clusters.split_at(clusters.len().div_ceil(2));
    let pair = [balanced(left, pairs), balanced(right, pairs)];
    let [left, right] = pair.map(|cluster| cluster.kind);
    pairs.push(Pair::of(&pair));
    let kind = Kind {
        link: pairs.len() as u32 - 1,
        primitives: left.primitives + right.primitives,
        leaves: left.leaves + right.leaves,
        height: left.height.max(right.height) + 1,
    };
    Cluster { bounds: pair[0].bounds.union(&pair[1].bounds), kind }
}

fn write(
    level: Level,
    root: &Cluster,
    pairs: &[Pair],
    top_leaves: &[TopLeaf],
    chunks: &[Chunk<'_>],
    threads: &Threads,
) -> Bvh {
    let leaves: u32 = top_leaves.iter().map(|top_leaf| top_leaf.kind.leaves).sum();
    let count: u32 = top_leaves.iter().map(|top_leaf| top_leaf.kind.primitives).sum();
    let size = 2 * leaves as usize - 1;
    let mut nodes = vec_in_large_pages(size);
    nodes.resize(size, Node { bounds: Aabb::EMPTY, link: Link::UNUSED });
    let mut primitives = vec![0; count as usize];
    let top_size = 2 * top_leaves.len() - 1;
    let (top, below) = nodes.split_at_mut(top_size);
    let mut plan = TopWriter { pairs, top_leaves, chunks, top, used: 1, jobs: Vec::with_capacity(top_leaves.len()) };
    let mut output = Output { below, below_at: top_size as u32, primitives: &mut primitives, primitives_at: 0 };
    plan.visit(root.bounds, root.kind.link, 0, 1, &mut output);
    let TopWriter { mut jobs, .. } = plan;
    threads.for_each(&mut jobs, 4, &|_, job| job.run(level));
    let roots: Vec<(usize, Node)> = jobs.into_iter().map(|job| (job.at, job.node)).collect();
    roots.into_iter().for_each(|(at, node)| nodes[at] = node);
    Bvh::from_parts(nodes, primitives, count)
}

/// The task of writing the subtree of a chunk's cluster.
struct Job<'a> {
    subtree: Option<Subtree<'a>>,
    root: emit::SubtreeRoot,
    depth: usize,
    /// The index of its root.
    at: usize,
    node: Node,
}

impl Job<'_> {
    fn run(&mut self, level: Level) {
        if let Some(subtree) = self.subtree.take() {
            self.node = subtree.write(level, self.root, self.depth);
        }
    }
}

struct TopWriter<'a, 'b> {
    pairs: &'a [Pair],
    top_leaves: &'a [TopLeaf],
    chunks: &'a [Chunk<'a>],
    top: &'b mut [Node],
    used: usize,
    jobs: Vec<Job<'b>>,
}

/// The output that is not assigned to a subtree yet.
struct Output<'a> {
    below: &'a mut [Node],
    below_at: u32,
    primitives: &'a mut [u32],
    primitives_at: u32,
}

impl<'a> Output<'a> {
    fn take(&mut self, kind: &Kind, chunk: &'a Chunk<'_>) -> Subtree<'a> {
        let nodes = 2 * kind.leaves as usize - 2;
        let below = self.below.split_off_mut(..nodes).expect("there are nodes for all leaves");
        let primitives =
            self.primitives.split_off_mut(..kind.primitives as usize).expect("there are slots for all primitives");
        let subtree = Subtree {
            pairs: &chunk.pairs,
            chains: chunk.keys,
            below,
            below_at: self.below_at,
            primitives,
            primitives_at: self.primitives_at,
        };
        self.below_at += nodes as u32;
        self.primitives_at += kind.primitives;
        subtree
    }
}

impl<'a: 'b, 'b> TopWriter<'a, 'b> {
    /// Writes the nodes of the top, from left to right, and assigns each subtree its part of the
    /// output.
    fn visit(&mut self, bounds: Aabb, link: u32, at: usize, depth: usize, output: &mut Output<'b>) {
        match half(link) {
            Half::Leaf { index, .. } => {
                let TopLeaf { chunk, kind } = &self.top_leaves[index];
                let root = emit::SubtreeRoot { bounds, link: kind.link, height: kind.height };
                let subtree = Some(output.take(kind, &self.chunks[*chunk]));
                self.jobs.push(Job { subtree, root, depth, at, node: self.top[at] });
            }
            Half::Pair(pair) => {
                let pair = &self.pairs[pair];
                let first = self.used;
                self.used += 2;
                self.top[at] = Node { bounds, link: Link::node(first as u32) };
                for half in 0..2 {
                    self.visit(pair.bounds[half], pair.links[half], first + half, depth + 1, output);
                }
            }
        }
    }
}
