//! A snapshot: one frame of a scene, which no later edit changes, and which queries trace.
//!
//! `resolve` tells what a hit says about it, `views` what it holds.

use std::fmt;

use super::frame::Frame;
use super::published::Published;
use super::report::FrameReport;
use super::views::{InstanceView, MeshView};
use crate::geometry::{Aabb, Ray};
use crate::handle::{InstanceId, MeshId};
use crate::query::{Coherence, Hit, Query};
use crate::simd::Level;
use crate::traverse::{FrameBvh, FrameStamp};
use crate::wide::TopLevelBvh;

/// One frame of a scene. It borrows nothing: keep it, send it, drop it anywhere. Clones share the
/// frame.
///
/// Queries need no lock. Any thread may trace a snapshot while the next frame is edited and
/// committed.
#[derive(Clone)]
pub struct Snapshot(Published<Frame>);

const _: () = {
    const fn travels<T: Clone + Send + Sync + 'static>() {}
    travels::<Snapshot>();
};

impl Snapshot {
    pub(crate) fn of(frame: Published<Frame>) -> Self {
        Self(frame)
    }

    /// The nearest hit; at equal distance the one with the smaller (instance, primitive).
    #[doc(alias = "intersect")]
    #[must_use]
    pub fn closest_hit(&self, ray: &Ray) -> Option<Hit> {
        self.query().closest_hit(ray)
    }

    /// Whether anything is hit.
    #[doc(alias = "any-hit")]
    #[must_use]
    pub fn occluded(&self, ray: &Ray) -> bool {
        self.query().occluded(ray)
    }

    /// Queries with a mask, culling, a filter or exclusions.
    pub fn query(&self) -> Query<'_> {
        Query::new(&self.0.world)
    }

    /// The nearest hit of each ray, on the calling thread. What the caller knows about the rays
    /// changes the speed, never the hits.
    ///
    /// # Panics
    /// When there are not as many hits as rays.
    pub fn closest_hits(&self, rays: &[Ray], hits: &mut [Option<Hit>], coherence: Coherence) {
        self.query().closest_hits(rays, hits, coherence);
    }

    /// Whether each ray hits anything, on the calling thread.
    ///
    /// # Panics
    /// When there are not as many answers as rays.
    pub fn occluded_each(&self, rays: &[Ray], answers: &mut [bool], coherence: Coherence) {
        self.query().occluded_each(rays, answers, coherence);
    }

    /// The same frame, traced by the kernels of another processor level. For tests: answers are the
    /// same at every level.
    #[doc(hidden)]
    #[must_use]
    pub fn at_level(&self, level: Level) -> Self {
        let world = FrameBvh { level, ..self.0.world.clone() };
        let (normals, placed, boxes) = (self.0.normals.clone(), self.0.placed.clone(), self.0.boxes.clone());
        let (report, original) = (self.0.report.clone(), Some(self.0.clone()));
        Self(Published::alone(Frame { world, normals, placed, boxes, report, owners: Vec::new(), original }))
    }

    /// What the commit did that made this frame.
    pub fn report(&self) -> &FrameReport {
        &self.0.report
    }

    /// The box around everything that can be hit, world space.
    pub fn bounds(&self) -> Aabb {
        self.0.world.top.bounds()
    }

    /// The tree over the instances.
    #[doc(alias = "TLAS")]
    pub fn top_level(&self) -> &TopLevelBvh {
        &self.0.world.top
    }

    /// An instance of this frame. `None` if the handle is of another scene, or what it names was
    /// not shown in this frame: removed before it, added after it, or left out
    /// ([`FrameReport::left_out`]).
    pub fn find(&self, id: InstanceId) -> Option<InstanceView<'_>> {
        let index = self.0.placed.binary_search_by_key(&id.0.slot, |placed| placed.id.0.slot).ok()?;
        (self.0.placed[index].id == id).then(|| self.instance_at(index as u32))
    }

    /// A mesh as it is in this frame, whether or not an instance shows it. `None` if the handle is
    /// of another scene, or what it names was removed before this frame or added after it.
    pub fn mesh(&self, id: MeshId) -> Option<MeshView<'_>> {
        let meshes = &self.report().meshes;
        let index = meshes.binary_search_by_key(&id.0.slot, |report| report.mesh.0.slot).ok()?;
        (meshes[index].mesh == id).then(|| self.mesh_at(index))
    }

    /// The meshes of the scene, shown or not, in the order of [`FrameReport::meshes`].
    pub fn meshes(&self) -> impl ExactSizeIterator<Item = MeshView<'_>> {
        (0..self.report().meshes.len()).map(|index| self.mesh_at(index))
    }

    /// The instances of this frame.
    pub fn instances(&self) -> impl ExactSizeIterator<Item = InstanceView<'_>> {
        (0..self.0.placed.len()).map(|index| self.instance_at(index as u32))
    }

    /// An instance by its number in this frame.
    ///
    /// # Panics
    /// When there are not as many.
    pub fn instance_at(&self, index: u32) -> InstanceView<'_> {
        let at = index as usize;
        let placed = &self.0.placed[at];
        let (record, bounds) = (&self.0.world.instances[at], &self.0.boxes[at]);
        InstanceView { index, record, placed, bounds, mesh: self.mesh_at(placed.mesh as usize) }
    }

    /// By its place in the report.
    fn mesh_at(&self, index: usize) -> MeshView<'_> {
        let report = &self.report().meshes[index];
        let slot = report.mesh.0.slot;
        MeshView { report, frame: &self.0.world.meshes[slot as usize], normals: self.0.normals_of(slot) }
    }

    pub(super) fn stamp(&self) -> FrameStamp {
        self.0.world.stamp
    }
}

/// In short: which frame, and how large it is.
impl fmt::Debug for Snapshot {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Snapshot")
            .field("frame", &self.report().frame)
            .field("meshes", &self.report().meshes.len())
            .field("instances", &self.0.placed.len())
            .finish_non_exhaustive()
    }
}
