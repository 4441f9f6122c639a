//! A frame prepared for rendering: its lights collected, its alpha-tested materials known.

use std::fmt;

use kinetree::{Candidate, Query};
use kinetree_world::{Alpha, Frame};

use crate::lights::LightTable;
use crate::shading_attributes::{ShadingAttributes, alpha_test};
use crate::thin_glass::ThinGlass;

/// A frame, with all that is computed once before its first ray. Shared by all threads.
pub struct SceneContext<'a> {
    pub(crate) frame: &'a Frame,
    pub(crate) lights: LightTable<'a>,
    /// Whether any material has holes.
    has_alpha: bool,
    /// Where light may go straight through.
    pub(crate) thin_glass: ThinGlass,
}

/// Prints the frame, not what was computed from it.
impl fmt::Debug for SceneContext<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("SceneContext").field("frame", &self.frame).finish_non_exhaustive()
    }
}

impl<'a> SceneContext<'a> {
    /// Collects the lights of a frame; takes time in proportion to its emitting triangles.
    pub fn new(frame: &'a Frame) -> Self {
        let materials = &frame.material_set.materials;
        Self {
            frame,
            lights: LightTable::new(frame),
            has_alpha: materials.iter().any(|material| material.alpha != Alpha::Opaque),
            thin_glass: ThinGlass::new(frame),
        }
    }

    /// The frame.
    pub fn frame(&self) -> &'a Frame {
        self.frame
    }
}

impl SceneContext<'_> {
    /// A query with the filter, which is left out when no material has alpha.
    pub(crate) fn query<'b>(&'b self, filter: &'b (dyn Fn(&Candidate<'_>) -> bool + Sync)) -> Query<'b> {
        let query = self.frame.snapshot.query();
        if self.has_alpha { query.filter(filter) } else { query }
    }

    /// As [`SceneContext::passes_alpha_test`], for a run of rays that begins at `start`.
    pub(crate) fn passes_alpha_test_in_run(
        &self,
        candidate: &Candidate<'_>,
        start: usize,
        salts: &(dyn Fn(usize) -> u32 + Sync),
    ) -> bool {
        self.passes_alpha_test(candidate, salts(start + candidate.ray_index() as usize))
    }

    /// The filter: whether a candidate passes the alpha test of its material.
    pub(crate) fn passes_alpha_test(&self, candidate: &Candidate<'_>, salt: u32) -> bool {
        let frame = self.frame;
        let instance = frame.snapshot.instance_at(candidate.instance_index());
        if ShadingAttributes::material_at(frame, &instance, candidate.primitive()).alpha == Alpha::Opaque {
            return true;
        }
        let at = [candidate.u(), candidate.v()];
        let opacity = ShadingAttributes::at(frame, &instance, candidate.primitive(), at).opacity();
        alpha_test(opacity, candidate.instance_index(), candidate.primitive(), at, salt)
    }
}
