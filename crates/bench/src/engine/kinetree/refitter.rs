//! Refits by commits of moved vertices.

use kinetree::{Action, MeshId, Scene, Snapshot};

use crate::engine::interface::Refit;
use crate::failure::Failure;

/// A scene with a deforming mesh.
pub(super) struct Refitter {
    pub(super) scene: Scene,
    pub(super) mesh: MeshId,
    /// Held as a renderer would hold it, so that the next frame is written into the other buffer.
    pub(super) frame: Snapshot,
}

impl Refit for Refitter {
    fn refit(&mut self, positions: &[[f32; 3]]) -> Result<(), Failure> {
        self.scene.set_positions(self.mesh, positions)?;
        self.frame = self.scene.commit();
        match self.frame.report().count(Action::Refitted) {
            1 => Ok(()),
            _ => Err("it was built anew, not refitted".into()),
        }
    }
}
