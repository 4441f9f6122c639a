//! The node hierarchy: the parent of every node, and its transform relative to it.
//!
//! Nothing here recurses: a file may nest a hundred thousand nodes.

use crate::document::Document;
use crate::error::{Item, Problem};
use crate::extensions;
use crate::json::Node;
use crate::notes::Notes;
use crate::transform::normalized;

/// The nodes of a file. Always: every node stands in `order` once, after its parent.
pub(crate) struct Hierarchy {
    order: Vec<u32>,
    /// [`NONE`] for a root.
    parents: Vec<u32>,
    /// Whether the scene that is shown has the node.
    pub(crate) in_scene: Vec<bool>,
}

/// No node.
const NONE: u32 = u32::MAX;

impl Hierarchy {
    pub(crate) fn read(document: &Document, notes: &mut Notes) -> Result<Self, Problem> {
        let nodes = &document.root.nodes;
        let mut parents = vec![NONE; nodes.len()];
        for (index, node) in nodes.iter().enumerate() {
            for child in node.children() {
                document.get(child, "node", &document.node_item(index))?;
                let first = std::mem::replace(&mut parents[child.value()], index as u32);
                if first != NONE {
                    let reason = format!("is a child of both node {first} and node {index}");
                    return Err(document.node_item(child.value()).invalid(reason));
                }
            }
            check_placement(node, || document.node_item(index), notes)?;
            if node.is_hidden() {
                extensions::note_ignored_one("KHR_node_visibility", Some(&document.node_item(index)), notes);
            }
        }
        let order = parents_first(document, &parents)?;
        let mut in_scene = vec![false; nodes.len()];
        for root in scene_roots(document, &parents)? {
            if std::mem::replace(&mut parents[root], NONE) != NONE {
                notes.add(|| format!("{} is a root of the scene and is cut from its parent", document.node_item(root)));
            }
            in_scene[root] = true;
        }
        let mut hierarchy = Self { order, parents, in_scene };
        let roots = std::mem::take(&mut hierarchy.in_scene);
        hierarchy.in_scene = hierarchy.spread_down(roots);
        Ok(hierarchy)
    }

    /// Every node once, parents first.
    pub(crate) fn parents_first(&self) -> impl DoubleEndedIterator<Item = usize> {
        self.order.iter().map(|&node| node as usize)
    }

    pub(crate) fn len(&self) -> usize {
        self.order.len()
    }

    pub(crate) fn parent(&self, node: usize) -> Option<usize> {
        Some(self.parents[node]).filter(|&parent| parent != NONE).map(|parent| parent as usize)
    }

    /// For every node, whether it or any of its ancestors is among `roots`.
    pub(crate) fn below(&self, roots: impl Iterator<Item = usize>) -> Vec<bool> {
        let mut marks = vec![false; self.len()];
        roots.for_each(|node| marks[node] = true);
        self.spread_down(marks)
    }

    /// For every node, whether it or any of its descendants is marked.
    pub(crate) fn above(&self, mut marks: Vec<bool>) -> Vec<bool> {
        for node in self.parents_first().rev() {
            if let Some(parent) = self.parent(node) {
                marks[parent] |= marks[node];
            }
        }
        marks
    }

    fn spread_down(&self, mut marks: Vec<bool>) -> Vec<bool> {
        for node in self.parents_first() {
            marks[node] |= self.parent(node).is_some_and(|parent| marks[parent]);
        }
        marks
    }
}

/// Every node after its parent.
fn parents_first(document: &Document, parents: &[u32]) -> Result<Vec<u32>, Problem> {
    let mut order: Vec<u32> = Vec::with_capacity(parents.len());
    order.extend((0..parents.len() as u32).filter(|&node| parents[node as usize] == NONE));
    let mut next = 0;
    while let Some(&node) = order.get(next) {
        order.extend(document.root.nodes[node as usize].children().map(|child| child.value() as u32));
        next += 1;
    }
    if order.len() == parents.len() {
        return Ok(order);
    }
    let mut reached = vec![false; parents.len()];
    order.iter().for_each(|&node| reached[node as usize] = true);
    let lost = reached.iter().position(|reached| !reached).unwrap_or_default();
    Err(document.node_item(lost).invalid("is in a cycle of nodes, or below one"))
}

/// The roots of the default scene, of the first scene, or all roots.
fn scene_roots(document: &Document, parents: &[u32]) -> Result<Vec<usize>, Problem> {
    let root = &document.root;
    let scene = match root.scene {
        Some(index) => Some((index.value(), document.get(index, "scene", &Item::new("asset", 0))?)),
        None => root.scenes.first().map(|scene| (0, scene)),
    };
    let Some((index, scene)) = scene else {
        return Ok((0..parents.len()).filter(|&node| parents[node] == NONE).collect());
    };
    let item = Item::named("scene", index, scene.name.as_deref());
    scene.nodes.iter().map(|&node| document.get(node, "node", &item).map(|_| node.value())).collect()
}

/// Refuses a placement that is not finite, and notes what [`Local::of`] leaves out.
fn check_placement(node: &Node, item: impl Fn() -> Item, notes: &mut Notes) -> Result<(), Problem> {
    let matrix = node.matrix.iter().flat_map(|matrix| matrix.iter());
    let vectors = node.translation.iter().chain(&node.scale).flat_map(|vector| vector.iter());
    let rotation = node.rotation.iter().flat_map(|rotation| rotation.iter());
    if !matrix.chain(vectors).chain(rotation).all(|number| number.is_finite()) {
        return Err(item().invalid("has a transform that is not finite"));
    }
    if node.matrix.as_ref().is_some_and(|m| [m[3], m[7], m[11], m[15]] != [0.0, 0.0, 0.0, 1.0]) {
        notes.add(|| format!("{}: the last row of its matrix is ignored", item()));
    }
    if node.matrix.is_none() && node.rotation.as_ref().is_some_and(|rotation| normalized(**rotation).is_none()) {
        notes.add(|| format!("{}: its rotation is zero, and is ignored", item()));
    }
    Ok(())
}
