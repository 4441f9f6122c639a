//! What has been read of a file before its nodes.

use kinetree::Motion;

use crate::channels::Animations;
use crate::clip::Clips;
use crate::document::Document;
use crate::json::Node;
use crate::mesh::Meshes;
use crate::nodes::Hierarchy;

/// What has been read so far, and the way to the meshes.
pub(crate) struct Input<'a> {
    pub(crate) document: &'a Document,
    pub(crate) hierarchy: &'a Hierarchy,
    pub(crate) clips: Clips,
    pub(crate) animations: Animations,
    pub(crate) meshes: Meshes<'a>,
    /// The motion of meshes that no animation moves.
    pub(crate) unanimated: Motion,
}

impl<'a> Input<'a> {
    /// The nodes of the scene, parents first.
    pub(crate) fn nodes(&self) -> impl Iterator<Item = (usize, &'a Node)> + use<'a> {
        let (document, hierarchy) = (self.document, self.hierarchy);
        let shown = hierarchy.parents_first().filter(|&index| hierarchy.in_scene[index]);
        shown.map(|index| (index, &document.root.nodes[index]))
    }
}
