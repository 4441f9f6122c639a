//! The node hierarchy: who hangs on whom, and where.
//!
//! Everything here walks arrays, since a file may hang a hundred thousand nodes on one another.

use gltf::json::Node;
use kinetree::Affine;

use crate::document::Document;
use crate::error::{Item, Problem};
use crate::notes::Notes;

/// The nodes of a file. Always: every node stands in `order` once, after its parent.
pub(crate) struct Hierarchy {
    pub(crate) order: Vec<usize>,
    pub(crate) parent: Vec<Option<usize>>,
    /// Whether the scene that is shown has the node.
    pub(crate) in_scene: Vec<bool>,
    pub(crate) local: Vec<Local>,
}

/// A placement relative to the parent.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Local {
    Matrix(Affine),
    Parts(Parts),
}

/// A placement by its parts, of which each can be animated alone: scaled first, then turned, then moved.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Parts {
    pub(crate) translation: [f32; 3],
    /// A unit quaternion, x y z w.
    pub(crate) rotation: [f32; 4],
    pub(crate) scale: [f32; 3],
}

impl Parts {
    pub(crate) fn affine(&self) -> Affine {
        Affine::from_scale_rotation_translation(self.scale, self.rotation, self.translation)
    }
}

impl Local {
    pub(crate) fn affine(&self) -> Affine {
        match self {
            Self::Matrix(affine) => *affine,
            Self::Parts(parts) => parts.affine(),
        }
    }

    /// A matrix is taken apart as well as it can be; shear is lost.
    pub(crate) fn parts(&self) -> Parts {
        match self {
            Self::Parts(parts) => *parts,
            Self::Matrix(affine) => {
                let columns = [affine.x_axis, affine.y_axis, affine.z_axis].map(glam::Vec3::from);
                let mirrored = affine.determinant() < 0.0;
                let lengths = columns.map(glam::Vec3::length);
                let scale = [if mirrored { -lengths[0] } else { lengths[0] }, lengths[1], lengths[2]];
                let mut axes =
                    glam::Mat3::from_cols(columns[0] / scale[0], columns[1] / scale[1], columns[2] / scale[2]);
                if !axes.is_finite() {
                    axes = glam::Mat3::IDENTITY;
                }
                let rotation = unit(glam::Quat::from_mat3(&axes).to_array()).unwrap_or(NO_TURN);
                Parts { translation: affine.translation, rotation, scale }
            }
        }
    }
}

/// The quaternion of no rotation.
pub(crate) const NO_TURN: [f32; 4] = [0.0, 0.0, 0.0, 1.0];

/// A quaternion of length one; `None` for one without a direction.
pub(crate) fn unit(quaternion: [f32; 4]) -> Option<[f32; 4]> {
    // In double precision, the length of a finite quaternion is finite.
    let quaternion = quaternion.map(f64::from);
    let length = quaternion.iter().map(|q| q * q).sum::<f64>().sqrt();
    (length.is_finite() && length > 0.0).then(|| quaternion.map(|q| (q / length) as f32))
}

impl Hierarchy {
    pub(crate) fn read(document: &Document, notes: &mut Notes) -> Result<Self, Problem> {
        let nodes = &document.root.nodes;
        let mut parent = vec![None; nodes.len()];
        for (index, node) in nodes.iter().enumerate() {
            for &child in node.children.iter().flatten() {
                document.get(child, "node", &document.node_item(index))?;
                if let Some(first) = parent[child.value()].replace(index) {
                    let reason = format!("is a child of both node {first} and node {index}");
                    return Err(document.node_item(child.value()).invalid(reason));
                }
            }
        }
        let order = parents_first(document, &parent)?;
        let mut is_root = vec![false; nodes.len()];
        for root in scene_roots(document, &parent)? {
            if parent[root].take().is_some() {
                notes.add(|| format!("{} is a root of the scene and is cut from its parent", document.node_item(root)));
            }
            is_root[root] = true;
        }
        let mut in_scene = is_root;
        for &node in &order {
            in_scene[node] |= parent[node].is_some_and(|parent| in_scene[parent]);
        }
        let local = |(index, node): (usize, &Node)| local(node, &document.node_item(index), notes);
        let local = nodes.iter().enumerate().map(local).collect::<Result<_, _>>()?;
        Ok(Self { order, parent, in_scene, local })
    }

    /// For every node, whether it or any node above it is among `movers`.
    pub(crate) fn below(&self, movers: impl Iterator<Item = usize>) -> Vec<bool> {
        let mut moves = vec![false; self.parent.len()];
        movers.for_each(|node| moves[node] = true);
        for &node in &self.order {
            moves[node] |= self.parent[node].is_some_and(|parent| moves[parent]);
        }
        moves
    }
}

/// Every node after its parent.
fn parents_first(document: &Document, parent: &[Option<usize>]) -> Result<Vec<usize>, Problem> {
    let mut order: Vec<usize> = (0..parent.len()).filter(|&node| parent[node].is_none()).collect();
    let mut next = 0;
    while let Some(&node) = order.get(next) {
        order.extend(document.root.nodes[node].children.iter().flatten().map(|child| child.value()));
        next += 1;
    }
    if order.len() == parent.len() {
        return Ok(order);
    }
    let mut reached = vec![false; parent.len()];
    order.iter().for_each(|&node| reached[node] = true);
    let lost = reached.iter().position(|reached| !reached).unwrap_or_default();
    Err(document.node_item(lost).invalid("is in a cycle of nodes, or below one"))
}

/// The roots of the default scene, of the first scene, or all roots.
fn scene_roots(document: &Document, parent: &[Option<usize>]) -> Result<Vec<usize>, Problem> {
    let root = &document.root;
    let scene = match root.scene {
        Some(index) => Some((index.value(), document.get(index, "scene", &Item::new("asset", 0))?)),
        None => root.scenes.first().map(|scene| (0, scene)),
    };
    let Some((index, scene)) = scene else {
        return Ok((0..parent.len()).filter(|&node| parent[node].is_none()).collect());
    };
    let item = Item::named("scene", index, scene.name.as_ref());
    scene.nodes.iter().map(|&node| document.get(node, "node", &item).map(|_| node.value())).collect()
}

fn local(node: &Node, item: &Item, notes: &mut Notes) -> Result<Local, Problem> {
    let unbounded = || item.invalid("has a transform that is not finite");
    if let Some(m) = node.matrix {
        if !m.iter().all(|number| number.is_finite()) {
            return Err(unbounded());
        }
        if [m[3], m[7], m[11], m[15]] != [0.0, 0.0, 0.0, 1.0] {
            notes.add(|| format!("{item}: the last row of its matrix is ignored"));
        }
        let column = |i: usize| [m[4 * i], m[4 * i + 1], m[4 * i + 2]];
        return Ok(Local::Matrix(Affine::from_columns(column(0), column(1), column(2), column(3))));
    }
    let translation = node.translation.unwrap_or([0.0; 3]);
    let scale = node.scale.unwrap_or([1.0; 3]);
    let rotation = node.rotation.unwrap_or_default().0;
    if !translation.iter().chain(&scale).chain(&rotation).all(|number| number.is_finite()) {
        return Err(unbounded());
    }
    let rotation = unit(rotation).unwrap_or_else(|| {
        notes.add(|| format!("{item}: its rotation is zero, and is ignored"));
        NO_TURN
    });
    Ok(Local::Parts(Parts { translation, rotation, scale }))
}
