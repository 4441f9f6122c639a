//! What belongs to a question besides the ray.

use std::fmt;

use super::candidate::{DynFilter, NoFilter, QueryFilter};
use super::collector::{DynamicCollector, Wanted};
use super::two_level::Rules;
use super::without::Without;
use super::{Candidate, Hit, batch, brute_force, trace_ray};
use crate::geometry::Ray;
use crate::handle::Placed;
use crate::traverse::{FrameBvh, Work};

/// Which sides of triangles are ignored.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "snake_case"))]
pub enum Cull {
    /// Both sides count.
    #[default]
    None,
    /// Only sides from which the vertices run counter-clockwise count.
    Back,
    /// Only sides from which the vertices run clockwise count.
    Front,
}

/// What the caller knows about the rays of a batch. It affects the speed, never the answers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
#[non_exhaustive]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "snake_case"))]
pub enum Coherence {
    /// Neighbours start and go nearly alike, such as the rays of a camera, tile by tile.
    Coherent,
    /// Neighbours have nothing in common.
    Incoherent,
    /// The caller does not know.
    #[default]
    Unknown,
}

/// A query with options, from [`Snapshot::query`](crate::Snapshot::query).
#[derive(Clone, Copy)]
#[must_use]
pub struct Query<'a> {
    world: &'a FrameBvh,
    mask: u32,
    cull: Cull,
    filter: Option<&'a DynFilter<'a>>,
    without: Without<'a>,
}

/// In short: the options, without the frame.
impl fmt::Debug for Query<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Query")
            .field("mask", &self.mask)
            .field("cull", &self.cull)
            .field("has_filter", &self.filter.is_some())
            .finish_non_exhaustive()
    }
}

// Many threads may use the same query.
const _: () = {
    const fn is_shared<T: Send + Sync>() {}
    is_shared::<Query<'_>>();
    is_shared::<BruteForce<'_>>();
};

impl<'a> Query<'a> {
    pub(crate) fn new(world: &'a FrameBvh) -> Self {
        Self { world, mask: u32::MAX, cull: Cull::None, filter: None, without: Without::default() }
    }

    /// Only instances whose mask shares a bit with this one. All, unless told.
    pub fn mask(self, mask: u32) -> Self {
        Self { mask, ..self }
    }

    /// Which sides of triangles are ignored. Both count, unless told.
    pub fn cull(self, cull: Cull) -> Self {
        Self { cull, ..self }
    }

    /// Decides about hits on instances that are not opaque, such as leaves and fences with holes.
    /// It must give the same answer whenever it is called with the same candidate, since it may be
    /// called more than once, and in any order.
    pub fn filter(self, filter: &'a (dyn Fn(&Candidate<'_>) -> bool + Sync)) -> Self {
        Self { filter: Some(filter), ..self }
    }

    /// Leaves out an instance, or all instances below a node: one's own body, for rays that start
    /// inside it. Unlike a filter this holds for opaque instances too, and costs nothing for each
    /// triangle. A handle that is not in this frame, because what it names was removed before or
    /// added later or is of another scene, leaves out nothing. Of several calls the last one
    /// counts.
    ///
    /// ```
    /// use kinetree::{Affine, Mesh, Motion, Ray, Scene};
    ///
    /// # fn main() -> Result<(), kinetree::EditError> {
    /// let mut scene = Scene::new();
    /// let quad = [[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0]];
    /// let plate = scene.add_mesh(Mesh::new(&quad, &[[0, 1, 2], [0, 2, 3]])?, Motion::Rigid)?;
    /// let car = scene.add_node(scene.root(), Affine::IDENTITY)?;
    /// let wheel = scene.add_node(car, Affine::IDENTITY)?;
    /// scene.add_instance(wheel, plate, Affine::from_translation([0.0, 0.0, 1.0]))?;
    /// let wall = scene.add_instance(scene.root(), plate, Affine::from_translation([0.0, 0.0, 5.0]))?;
    ///
    /// let view = scene.commit();
    /// let ahead = Ray::new([0.0, 0.3, 0.0], [0.0, 0.0, 1.0]);
    /// assert_eq!(view.closest_hit(&ahead).map(|hit| hit.t), Some(1.0)); // the car's own wheel
    /// let hit = view.query().without(car).closest_hit(&ahead).unwrap();
    /// assert_eq!((hit.t, view.instance_id(&hit)), (5.0, wall));
    /// # Ok(())
    /// # }
    /// ```
    pub fn without(self, what: impl Into<Placed>) -> Self {
        let all_rays = self.world.hierarchy.interval_of(what.into());
        Self { without: Without { all_rays, ..self.without }, ..self }
    }

    /// Leaves out something else for each ray of a batch, as [`Query::without`] does for all. Both
    /// hold where both are given. A ray that is asked about alone is a batch of one.
    ///
    /// Queries then panic when there are not as many rays as `each` has entries.
    pub fn without_each(self, each: &'a [Placed]) -> Self {
        Self { without: Without { each_ray: Some(each), ..self.without }, ..self }
    }

    /// The nearest hit; at equal distance the one with the smaller (instance, primitive).
    #[must_use]
    pub fn closest_hit(&self, ray: &Ray) -> Option<Hit> {
        if self.has_filter(1) {
            return self.closest_hit_counted(ray, &mut Work::default());
        }
        trace_ray::closest(self.world, ray, self.rules_without_filter())
    }

    /// As [`Query::closest_hit`], and adds to `work` what it took.
    pub fn closest_hit_counted(&self, ray: &Ray, work: &mut Work) -> Option<Hit> {
        self.trace(ray, Wanted::Closest, work)?.hit(self.world.stamp)
    }

    /// Whether anything is hit.
    #[doc(alias = "any-hit")]
    #[must_use]
    pub fn occluded(&self, ray: &Ray) -> bool {
        if self.has_filter(1) {
            return self.occluded_counted(ray, &mut Work::default());
        }
        trace_ray::occluded(self.world, ray, self.rules_without_filter())
    }

    /// As [`Query::occluded`], and adds to `work` what it took.
    pub fn occluded_counted(&self, ray: &Ray, work: &mut Work) -> bool {
        self.trace(ray, Wanted::Any, work).is_some_and(|collector| collector.is_hit())
    }

    /// The nearest hit of each ray, on the calling thread. What the caller knows about the rays
    /// changes the speed, never the hits. [`Candidate::ray_index`] tells a filter which ray it is
    /// asked about.
    ///
    /// # Panics
    /// When there are not as many hits as rays, or as entries of [`Query::without_each`].
    pub fn closest_hits(&self, rays: &[Ray], hits: &mut [Option<Hit>], coherence: Coherence) {
        batch::closest_hits(self.world, rays, self.batch_rules(rays), hits, coherence);
    }

    /// Whether each ray hits anything, on the calling thread.
    ///
    /// # Panics
    /// When there are not as many answers as rays, or as entries of [`Query::without_each`].
    pub fn occluded_each(&self, rays: &[Ray], answers: &mut [bool], coherence: Coherence) {
        batch::occluded_each(self.world, rays, self.batch_rules(rays), answers, coherence);
    }

    /// Every hit once, near to far.
    #[must_use]
    pub fn all_hits(&self, ray: &Ray) -> Vec<Hit> {
        self.all_hits_counted(ray, &mut Work::default())
    }

    /// As [`Query::all_hits`], and adds to `work` what it took.
    pub fn all_hits_counted(&self, ray: &Ray, work: &mut Work) -> Vec<Hit> {
        self.trace(ray, Wanted::All, work).map_or_else(Vec::new, |collector| collector.all_hits(self.world.stamp))
    }

    /// The slow twin: the same queries, answered by testing every triangle.
    pub fn brute_force(self) -> BruteForce<'a> {
        BruteForce(self)
    }

    #[inline(always)]
    fn rules_without_filter(&self) -> Rules<NoFilter> {
        Rules { mask: self.mask, cull: self.cull, filter: NoFilter }
    }

    fn rules(&self) -> Rules<QueryFilter<'a>> {
        Rules { mask: self.mask, cull: self.cull, filter: QueryFilter::new(self.world, self.filter, self.without) }
    }

    /// The rules of a batch, and whether the filter may decide anything.
    fn batch_rules(&self, rays: &[Ray]) -> (Rules<QueryFilter<'a>>, bool) {
        (self.rules(), self.has_filter(rays.len()))
    }

    /// Whether there is a filter, or something to leave out, for so many rays.
    ///
    /// # Panics
    /// When there are not as many entries of [`Query::without_each`].
    #[inline(always)]
    fn has_filter(&self, rays: usize) -> bool {
        if self.filter.is_none() && self.without.is_nothing() {
            return false;
        }
        let entries = self.without.each_ray.map_or(rays, |each| each.len());
        assert_eq!(entries, rays, "one entry of `without_each` per ray");
        true
    }

    fn trace(&self, ray: &Ray, wanted: Wanted, work: &mut Work) -> Option<DynamicCollector> {
        self.has_filter(1);
        trace_ray::dynamic(self.world, ray, self.rules(), wanted, work)
    }
}

/// The queries of a [`Query`], answered without any tree. Slow, and short enough to be believed:
/// for tests.
#[derive(Debug, Clone, Copy)]
#[must_use]
pub struct BruteForce<'a>(Query<'a>);

impl BruteForce<'_> {
    /// The nearest hit; at equal distance the one with the smaller (instance, primitive).
    #[must_use]
    pub fn closest_hit(&self, ray: &Ray) -> Option<Hit> {
        self.trace(ray, Wanted::Closest)?.hit(self.0.world.stamp)
    }

    /// Whether anything is hit.
    #[must_use]
    pub fn occluded(&self, ray: &Ray) -> bool {
        self.trace(ray, Wanted::Any).is_some_and(|collector| collector.is_hit())
    }

    /// Every hit once, near to far.
    #[must_use]
    pub fn all_hits(&self, ray: &Ray) -> Vec<Hit> {
        self.trace(ray, Wanted::All).map_or_else(Vec::new, |collector| collector.all_hits(self.0.world.stamp))
    }

    fn trace(&self, ray: &Ray, wanted: Wanted) -> Option<DynamicCollector> {
        self.0.has_filter(1);
        brute_force::trace(self.0.world, ray, self.0.rules(), wanted)
    }
}
