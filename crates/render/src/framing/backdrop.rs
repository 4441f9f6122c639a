//! Sky domes and other backdrops, which surround everything else and are left out of the region of
//! interest.

use std::collections::BTreeMap;

use glam::Vec3;

use super::dense::dense_interval;
use super::samples::{Sample, bounding_box};

/// A backdrop is at least this many times as large, along every axis, as the dense part of the
/// rest. A room is less.
const MUCH_LARGER: f32 = 3.0;

/// A backdrop contains at least this part of the rest.
const HOLDS: f32 = 0.95;

/// The largest instances are tried, at most this many: a sky, its clouds, its stars.
const MAX_CANDIDATES: usize = 4;

/// The samples of a frame without those of its backdrops.
pub(super) fn without_backdrops(mut samples: Vec<Sample>) -> Vec<Sample> {
    let mut boxes: BTreeMap<u32, (Vec3, Vec3)> = BTreeMap::new();
    for sample in &samples {
        let (min, max) = boxes.entry(sample.instance).or_insert((Vec3::INFINITY, Vec3::NEG_INFINITY));
        (*min, *max) = (min.min(sample.center), max.max(sample.center));
    }
    let mut largest: Vec<(u32, Vec3, Vec3)> =
        boxes.into_iter().map(|(instance, (min, max))| (instance, min, max)).collect();
    // The sort is stable: of equal instances the first comes first.
    largest.sort_by(|a, b| b.1.distance(b.2).total_cmp(&a.1.distance(a.2)));
    for (instance, min, max) in largest.into_iter().take(MAX_CANDIDATES) {
        let rest: Vec<Vec3> =
            samples.iter().filter(|sample| sample.instance != instance).map(|sample| sample.center).collect();
        if is_backdrop(min, max, &rest) {
            samples.retain(|sample| sample.instance != instance);
        }
    }
    samples
}

/// Whether a box is much larger than the dense part of the rest, and contains nearly all of it.
fn is_backdrop(min: Vec3, max: Vec3, rest: &[Vec3]) -> bool {
    let held = rest.iter().filter(|point| point.cmpge(min).all() && point.cmple(max).all()).count();
    if rest.is_empty() || (held as f32) < HOLDS * rest.len() as f32 {
        return false;
    }
    let [x, y, z] = [0, 1, 2].map(|axis| dense_interval(rest.iter().map(|point| (point[axis], 1.0))));
    let (low, high) = bounding_box(&[Vec3::new(x.0, y.0, z.0), Vec3::new(x.1, y.1, z.1)]);
    ((max - min).cmpge(MUCH_LARGER * (high - low))).all() && (max - min).min_element() > 0.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_dome_is_a_backdrop_and_neither_a_ground_nor_a_room_is() {
        let things: Vec<Vec3> =
            (0..1000).map(|i| Vec3::new((i % 10) as f32, (i / 10 % 10) as f32, (i / 100) as f32)).collect();
        assert!(is_backdrop(Vec3::splat(-100.0), Vec3::splat(100.0), &things));
        assert!(!is_backdrop(Vec3::new(-100.0, 0.0, -100.0), Vec3::new(100.0, 0.0, 100.0), &things));
        assert!(!is_backdrop(Vec3::splat(-2.0), Vec3::splat(12.0), &things));
        assert!(!is_backdrop(Vec3::splat(-100.0), Vec3::splat(100.0), &[]));
    }
}
