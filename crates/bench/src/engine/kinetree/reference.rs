//! The tree with which all engines are compared.

use kinetree::build::Quality;
use kinetree::{Mesh, Motion};

use super::built_tree::BuiltTree;
use super::scene::scene_of;
use crate::agree::refined;
use crate::engine::interface::Tree;
use crate::failure::Failure;
use crate::ray::{Answer, Ray};
use crate::soup::Soup;

/// A kinetree tree from whose hits rays are made, and with which all engines are compared. Where an
/// engine disagrees, an exact search decides.
pub(crate) struct Reference(BuiltTree);

impl Reference {
    /// Builds the tree.
    ///
    /// # Errors
    /// The triangles are not a valid mesh.
    pub(crate) fn of(soup: &Soup) -> Result<Self, Failure> {
        let mesh = Mesh::new(&soup.positions, &soup.triangles)?.with_quality(Quality::Fast);
        let (mut scene, _) = scene_of(mesh, Motion::Static)?;
        Ok(Self(BuiltTree { view: scene.commit() }))
    }

    /// The nearest hits, with distances in double precision.
    pub(crate) fn closest(&self, soup: &Soup, rays: &[Ray]) -> Vec<Answer> {
        let mut answers = vec![Answer::MISS; rays.len()];
        Tree::closest(&self.0, rays, &mut answers);
        refined(soup, rays, &answers)
    }
}
