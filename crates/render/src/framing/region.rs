//! The region of interest: along each axis, where a frame's surface is dense.
//!
//! The shortest interval that holds most of the weight finds the dense part however much lies
//! around it (Rousseeuw and Leroy 1987, "Robust Regression and Outlier Detection", the shortest
//! half); it then grows for as long as what it grows into is of comparable density. Hills and
//! strays stay outside, and so do sky domes, however finely they are divided.
//!
//! Where most of that belongs to objects that are not much larger, the region is these objects as a
//! whole: a head or a tail is part of the picture though little of the surface is there.

use std::collections::BTreeMap;

use glam::Vec3;
use kinetree_world::Frame;

use super::backdrop;

/// A box with some extent, and places in it that stand for what it holds.
#[derive(Debug, Clone)]
pub(super) struct Region {
    min: Vec3,
    max: Vec3,
    places: Vec<Vec3>,
    objects: Option<Objects>,
}

/// Objects to be shown as a whole.
#[derive(Debug, Clone)]
pub(super) struct Objects {
    /// How many instances.
    pub(super) count: usize,
    /// Corners of their triangles.
    pub(super) corners: Vec<Vec3>,
}

/// About how many places stand for the region.
const PLACES: usize = 256;

/// About how many triangles are looked at.
const SAMPLES: usize = 20_000;
/// The part of the weight that the dense part holds at least.
const CORE: f64 = 0.6;
/// By how much of its length the dense part grows at a time, to either side.
const STEP: f64 = 0.25;
/// Density of what is grown into, over that of the core, from which growing goes on.
const COMPARABLE: f64 = 0.25;
/// How many times the median area counts: a ground of two triangles must not outweigh what stands
/// on it.
const LARGEST_WEIGHT: f64 = 8.0;

/// An instance is an object of the region when this part of it is there ...
const MOSTLY_THERE: f64 = 0.5;
/// ... and it is no more than so many times as large.
const NOT_MUCH_LARGER: f32 = 2.5;
/// The region is its objects when they make up this part of it.
const NEARLY_ALL: f64 = 0.8;

/// A triangle that stands for its neighbours.
pub(super) struct Sample {
    pub(super) instance: u32,
    corners: [Vec3; 3],
    pub(super) center: Vec3,
    area: f64,
    stands_for: f64,
}

impl Region {
    /// `None` for a frame without triangles.
    pub(super) fn of(frame: &Frame) -> Option<Self> {
        let mut samples = backdrop::without_backdrops(samples(frame));
        samples.sort_unstable_by(|a, b| a.area.total_cmp(&b.area));
        let median = samples.get(samples.len() / 2)?.area;
        let weights: Vec<f64> =
            samples.iter().map(|sample| sample.stands_for * sample.area.min(LARGEST_WEIGHT * median)).collect();
        let range = |axis: usize| dense(samples.iter().map(|sample| sample.center[axis]).zip(weights.iter().copied()));
        let [x, y, z] = [range(0), range(1), range(2)];
        let (min, max) = (Vec3::new(x.0, y.0, z.0), Vec3::new(x.1, y.1, z.1));
        let objects = Objects::of(&samples, &weights, min, max);
        // What lies at the ends is to be seen whole, and a flat region still has a size.
        let (min, max) = objects.as_ref().map_or((min, max), |objects| around(&objects.corners));
        let margin = 0.1 * (max - min) + Vec3::splat(0.02 * (max - min).max_element());
        let margin = margin.max((min.abs().max(max.abs()) * 1e-5).max(Vec3::splat(1e-6)));
        let mut region = Self { min: min - margin, max: max + margin, places: Vec::new(), objects };
        let within: Vec<Vec3> =
            samples.iter().map(|sample| sample.center).filter(|&center| region.contains(center)).collect();
        region.places = within.iter().copied().step_by(within.len().div_ceil(PLACES).max(1)).collect();
        Some(region)
    }

    /// The objects that the region is about, if it is.
    pub(super) fn objects(&self) -> Option<&Objects> {
        self.objects.as_ref()
    }

    pub(super) fn center(&self) -> Vec3 {
        self.min * 0.5 + self.max * 0.5
    }

    /// From the middle to a face, per axis.
    pub(super) fn half(&self) -> Vec3 {
        self.max * 0.5 - self.min * 0.5
    }

    /// From the middle to a corner.
    pub(super) fn radius(&self) -> f32 {
        self.half().length()
    }

    /// Places in the region, more of them where there is more.
    pub(super) fn places(&self) -> &[Vec3] {
        &self.places
    }

    pub(super) fn contains(&self, point: Vec3) -> bool {
        point.cmpge(self.min).all() && point.cmple(self.max).all()
    }
}

impl Objects {
    /// Those of a box, or none if much in it belongs to larger things. There are as many weights as
    /// samples.
    fn of(samples: &[Sample], weights: &[f64], min: Vec3, max: Vec3) -> Option<Self> {
        let reach = Vec3::splat(1e-3 * (max - min).max_element());
        let is_there =
            |sample: &Sample| sample.center.cmpge(min - reach).all() && sample.center.cmple(max + reach).all();
        let mut instances: BTreeMap<u32, Extent> = BTreeMap::new();
        for (sample, &weight) in samples.iter().zip(weights) {
            instances.entry(sample.instance).or_default().add(sample, weight, is_there(sample));
        }
        let there: f64 = instances.values().map(|extent| extent.there).sum();
        let largest = NOT_MUCH_LARGER * min.distance(max);
        instances.retain(|_, extent| {
            extent.there >= MOSTLY_THERE * extent.weight && extent.min.distance(extent.max) <= largest
        });
        let covered: f64 = instances.values().map(|extent| extent.there).sum();
        if covered < NEARLY_ALL * there || instances.is_empty() {
            return None;
        }
        let own = samples.iter().filter(|sample| instances.contains_key(&sample.instance));
        Some(Self { count: instances.len(), corners: own.flat_map(|sample| sample.corners).collect() })
    }
}

/// The samples of an instance.
struct Extent {
    min: Vec3,
    max: Vec3,
    weight: f64,
    /// The part of the weight that lies within the region.
    there: f64,
}

impl Default for Extent {
    fn default() -> Self {
        Self { min: Vec3::INFINITY, max: Vec3::NEG_INFINITY, weight: 0.0, there: 0.0 }
    }
}

impl Extent {
    fn add(&mut self, sample: &Sample, weight: f64, is_there: bool) {
        let (min, max) = around(&sample.corners);
        (self.min, self.max) = (self.min.min(min), self.max.max(max));
        self.weight += weight;
        self.there += if is_there { weight } else { 0.0 };
    }
}

/// The box around points.
pub(super) fn around(points: &[Vec3]) -> (Vec3, Vec3) {
    points.iter().fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(min, max), &point| (min.min(point), max.max(point)))
}

/// Triangles at even strides through all instances, in order. Those without area are nothing to
/// look at.
fn samples(frame: &Frame) -> Vec<Sample> {
    let total: usize = frame.snapshot.instances().map(|instance| instance.triangles().len()).sum();
    let stride = total.div_ceil(SAMPLES).max(1);
    let mut samples = Vec::new();
    // Where the next sample lies, counted from the first triangle of the instance.
    let mut next = 0;
    for instance in frame.snapshot.instances() {
        let (triangles, placement) = (instance.triangles(), instance.world_from_object());
        while next < triangles.len() {
            let corners = triangles[next]
                .map(|vertex| Vec3::from(placement.transform_point(instance.positions()[vertex as usize])));
            let [a, b, c] = corners.map(Vec3::as_dvec3);
            let (center, area) = ((a + b + c) / 3.0, 0.5 * (b - a).cross(c - a).length());
            if center.is_finite() && area.is_finite() && area > 0.0 {
                let (instance, center) = (instance.index(), center.as_vec3());
                samples.push(Sample { instance, corners, center, area, stands_for: stride as f64 });
            }
            next += stride;
        }
        next -= triangles.len();
    }
    samples
}

/// Values in ascending order, and the sum of weights before each.
struct Axis {
    values: Vec<f32>,
    before: Vec<f64>,
}

/// The dense interval of weighted values; there is at least one.
pub(super) fn dense(values: impl Iterator<Item = (f32, f64)>) -> (f32, f32) {
    let mut values: Vec<(f32, f64)> = values.collect();
    values.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
    let mut before = vec![0.0];
    let mut total = 0.0;
    for value in &values {
        total += value.1;
        before.push(total);
    }
    let axis = Axis { values: values.into_iter().map(|value| value.0).collect(), before };
    let (mut low, mut high) = axis.shortest(CORE * total);
    let gain = COMPARABLE * CORE * STEP * total;
    // Every round takes in at least `gain`, so there are few.
    loop {
        let step = ((f64::from(high) - f64::from(low)) * STEP) as f32;
        let (lower, higher) = (low - step, high + step);
        let (grows_down, grows_up) = (axis.weight(lower, low) >= gain, axis.weight(high, higher) >= gain);
        if gain <= 0.0 || step <= 0.0 || !(grows_down || grows_up) {
            return axis.trimmed(low, high);
        }
        low = if grows_down { lower } else { low };
        high = if grows_up { higher } else { high };
    }
}

impl Axis {
    /// The shortest interval with at least so much weight.
    fn shortest(&self, weight: f64) -> (f32, f32) {
        let mut best = (self.values[0], self.values[self.values.len() - 1]);
        let mut end = 0;
        for start in 0..self.values.len() {
            end = end.max(start);
            while end < self.values.len() && self.before[end + 1] - self.before[start] < weight {
                end += 1;
            }
            if end == self.values.len() {
                break;
            }
            if self.values[end] - self.values[start] < best.1 - best.0 {
                best = (self.values[start], self.values[end]);
            }
        }
        best
    }

    /// Weight within an open interval.
    fn weight(&self, low: f32, high: f32) -> f64 {
        let start = self.values.partition_point(|&value| value <= low);
        let end = self.values.partition_point(|&value| value < high);
        if end > start { self.before[end] - self.before[start] } else { 0.0 }
    }

    /// An interval without the empty space at its ends.
    fn trimmed(&self, low: f32, high: f32) -> (f32, f32) {
        let start = self.values.partition_point(|&value| value < low);
        let end = self.values.partition_point(|&value| value <= high);
        if end > start { (self.values[start], self.values[end - 1]) } else { (low, high) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_dense_part_ignores_what_is_far_and_keeps_what_is_near() {
        let near = (0..1000).map(|i| (i as f32 * 0.01, 1.0));
        let (low, high) = dense(near.clone());
        assert!((0.0..0.5).contains(&low) && (9.5..10.0).contains(&high), "{low} {high}");
        // A third of all weight, a thousand times as wide.
        let dome = (0..500).map(|i| (i as f32 * 40.0 - 10_000.0, 1.0));
        let (low, high) = dense(near.chain(dome));
        assert!((-3.0..1.0).contains(&low) && (9.0..13.0).contains(&high), "{low} {high}");
        assert_eq!(dense([(3.0, 1.0)].into_iter()), (3.0, 3.0));
        let (low, high) = dense([(3.0, 0.0), (f32::MAX, 0.0), (-f32::MAX, 0.0)].into_iter());
        assert!(low <= high);
    }
}
