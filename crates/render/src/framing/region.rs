//! The region of interest: the box in which the surface area of a frame is dense, found along each
//! axis.
//!
//! Along each axis the region is a [dense interval](dense_interval). Hills and stray triangles stay
//! outside, and so do sky domes, however finely they are tessellated.
//!
//! If most of the region belongs to instances that are not much larger than it, the region becomes
//! these instances as a whole, so that a head or a tail with little area is in the picture too.

use std::collections::BTreeMap;

use glam::Vec3;
use kinetree_world::Frame;

use super::backdrop;
use super::dense::dense_interval;
use super::samples::{Sample, bounding_box, samples};

/// The region of interest, with points that represent the surfaces in it.
#[derive(Debug, Clone)]
pub(super) struct Region {
    min: Vec3,
    max: Vec3,
    points: Vec<Vec3>,
    objects: Option<Objects>,
}

/// Instances to be shown as a whole.
#[derive(Debug, Clone)]
pub(super) struct Objects {
    /// The number of instances.
    pub(super) count: usize,
    /// Vertices of their sampled triangles.
    pub(super) corners: Vec<Vec3>,
}

/// The approximate number of points that represent the region.
const POINTS: usize = 256;

/// The largest weight of a triangle, in median areas: a ground of two triangles must not outweigh
/// what stands on it.
const MAX_WEIGHT: f64 = 8.0;

/// An instance counts as an object of the region if this part of its weight lies in the region ...
const MOSTLY_INSIDE: f64 = 0.5;
/// ... and it is at most this many times as large as the region.
const MAX_RELATIVE_SIZE: f32 = 2.5;
/// The region becomes its objects if they make up this part of its weight.
const NEARLY_ALL: f64 = 0.8;

impl Region {
    /// `None` for a frame without triangles.
    pub(super) fn of(frame: &Frame) -> Option<Self> {
        let mut samples = backdrop::without_backdrops(samples(frame));
        samples.sort_unstable_by(|a, b| a.area.total_cmp(&b.area));
        let median = samples.get(samples.len() / 2)?.area;
        let weights: Vec<f64> =
            samples.iter().map(|sample| sample.represents * sample.area.min(MAX_WEIGHT * median)).collect();
        let range =
            |axis: usize| dense_interval(samples.iter().map(|sample| sample.center[axis]).zip(weights.iter().copied()));
        let [x, y, z] = [range(0), range(1), range(2)];
        let (min, max) = (Vec3::new(x.0, y.0, z.0), Vec3::new(x.1, y.1, z.1));
        let objects = Objects::of(&samples, &weights, min, max);
        // A margin: surfaces at the ends are shown whole, and a flat region has a size too.
        let (min, max) = objects.as_ref().map_or((min, max), |objects| bounding_box(&objects.corners));
        let margin = 0.1 * (max - min) + Vec3::splat(0.02 * (max - min).max_element());
        let margin = margin.max((min.abs().max(max.abs()) * 1e-5).max(Vec3::splat(1e-6)));
        let mut region = Self { min: min - margin, max: max + margin, points: Vec::new(), objects };
        let within: Vec<Vec3> =
            samples.iter().map(|sample| sample.center).filter(|&center| region.contains(center)).collect();
        region.points = within.iter().copied().step_by(within.len().div_ceil(POINTS).max(1)).collect();
        Some(region)
    }

    /// The objects that the region consists of, if it does.
    pub(super) fn objects(&self) -> Option<&Objects> {
        self.objects.as_ref()
    }

    pub(super) fn center(&self) -> Vec3 {
        self.min * 0.5 + self.max * 0.5
    }

    /// Half extents: from the centre to a face, per axis.
    pub(super) fn half(&self) -> Vec3 {
        self.max * 0.5 - self.min * 0.5
    }

    /// Half the diagonal: from the centre to a corner.
    pub(super) fn radius(&self) -> f32 {
        self.half().length()
    }

    /// Points of surfaces in the region, more of them where there are more triangles.
    pub(super) fn points(&self) -> &[Vec3] {
        &self.points
    }

    pub(super) fn contains(&self, point: Vec3) -> bool {
        point.cmpge(self.min).all() && point.cmple(self.max).all()
    }
}

impl Objects {
    /// The objects of a box, or `None` if much in the box belongs to larger instances. `weights`
    /// has one entry per sample.
    fn of(samples: &[Sample], weights: &[f64], min: Vec3, max: Vec3) -> Option<Self> {
        let reach = Vec3::splat(1e-3 * (max - min).max_element());
        let is_inside =
            |sample: &Sample| sample.center.cmpge(min - reach).all() && sample.center.cmple(max + reach).all();
        let mut instances: BTreeMap<u32, InstanceSamples> = BTreeMap::new();
        for (sample, &weight) in samples.iter().zip(weights) {
            instances.entry(sample.instance).or_default().add(sample, weight, is_inside(sample));
        }
        let inside: f64 = instances.values().map(|samples| samples.inside).sum();
        let largest = MAX_RELATIVE_SIZE * min.distance(max);
        instances.retain(|_, samples| {
            samples.inside >= MOSTLY_INSIDE * samples.weight && samples.min.distance(samples.max) <= largest
        });
        let covered: f64 = instances.values().map(|samples| samples.inside).sum();
        if covered < NEARLY_ALL * inside || instances.is_empty() {
            return None;
        }
        let own = samples.iter().filter(|sample| instances.contains_key(&sample.instance));
        Some(Self { count: instances.len(), corners: own.flat_map(|sample| sample.corners).collect() })
    }
}

/// Sums over the samples of an instance.
struct InstanceSamples {
    min: Vec3,
    max: Vec3,
    weight: f64,
    /// The part of the weight that lies within the region.
    inside: f64,
}

impl Default for InstanceSamples {
    fn default() -> Self {
        Self { min: Vec3::INFINITY, max: Vec3::NEG_INFINITY, weight: 0.0, inside: 0.0 }
    }
}

impl InstanceSamples {
    fn add(&mut self, sample: &Sample, weight: f64, is_inside: bool) {
        let (min, max) = bounding_box(&sample.corners);
        (self.min, self.max) = (self.min.min(min), self.max.max(max));
        self.weight += weight;
        self.inside += if is_inside { weight } else { 0.0 };
    }
}
