//! Key frames, and interpolation between them.
//!
//! glTF 2.0 specification, appendix C: step, linear (rotations along the shorter arc), and Hermite
//! splines.

use std::sync::Arc;

use glam::Quat;

use crate::transform::{IDENTITY_ROTATION, normalized};

/// How values between two keys are computed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Interpolation {
    Step,
    Linear,
    /// Every key has three values: the slope before it, its own, and the slope after it; slopes are
    /// per second.
    CubicSpline,
}

/// Values at times. Always:
/// 1. there is at least one key;
/// 2. times are finite and never decrease;
/// 3. there are `width` numbers per value, and one or three values per key, as the interpolation
///    has it.
#[derive(Debug, Clone)]
pub(crate) struct Keys {
    times: Arc<[f32]>,
    values: Vec<f32>,
    width: usize,
    interpolation: Interpolation,
}

/// Where a time lies among the key frames.
enum TimeSpan {
    At(usize),
    /// After this key, by this fraction of the way to the next, which takes so many seconds.
    Between(usize, f32, f32),
}

impl Keys {
    /// `None` if a promise is broken.
    pub(crate) fn new(times: Arc<[f32]>, values: Vec<f32>, width: usize, interpolation: Interpolation) -> Option<Self> {
        let per_key = if interpolation == Interpolation::CubicSpline { 3 } else { 1 };
        let fits = times.len().checked_mul(per_key)?.checked_mul(width)? == values.len();
        let ordered = times.iter().all(|time| time.is_finite()) && times.is_sorted();
        (fits && ordered && !times.is_empty()).then_some(Self { times, values, width, interpolation })
    }

    /// When the last key is, seconds.
    pub(crate) fn end(&self) -> f64 {
        self.times.last().map_or(0.0, |&time| f64::from(time))
    }

    /// The values at a time; before the first key those of the first, after the last those of the
    /// last.
    pub(crate) fn sample(&self, seconds: f64, out: &mut [f32]) {
        match (self.span_at(seconds), self.interpolation) {
            (TimeSpan::At(key), _) | (TimeSpan::Between(key, ..), Interpolation::Step) => {
                out.copy_from_slice(self.value(key));
            }
            (TimeSpan::Between(key, s, _), Interpolation::Linear) => {
                for ((out, a), b) in out.iter_mut().zip(self.value(key)).zip(self.value(key + 1)) {
                    *out = a * (1.0 - s) + b * s;
                }
            }
            (TimeSpan::Between(key, s, length), Interpolation::CubicSpline) => {
                let (s2, s3) = (s * s, s * s * s);
                let (start, end) = (2.0 * s3 - 3.0 * s2 + 1.0, 3.0 * s2 - 2.0 * s3);
                let (leave, arrive) = (length * (s3 - 2.0 * s2 + s), length * (s3 - s2));
                let (from, to) = (self.value(key), self.value(key + 1));
                let (slope_after, slope_before) = (self.row(3 * key + 2), self.row(3 * key + 3));
                for i in 0..out.len() {
                    out[i] = start * from[i] + leave * slope_after[i] + end * to[i] + arrive * slope_before[i];
                }
            }
        }
    }

    pub(crate) fn vector(&self, seconds: f64) -> [f32; 3] {
        let mut out = [0.0; 3];
        self.sample(seconds, &mut out);
        out
    }

    /// A unit quaternion.
    pub(crate) fn rotation(&self, seconds: f64) -> [f32; 4] {
        if let (TimeSpan::Between(key, s, _), Interpolation::Linear) = (self.span_at(seconds), self.interpolation) {
            let [from, to] = [key, key + 1].map(|key| {
                let value = self.value(key);
                Quat::from_array(normalized([value[0], value[1], value[2], value[3]]).unwrap_or(IDENTITY_ROTATION))
            });
            return normalized(from.slerp(to, s).to_array()).unwrap_or(IDENTITY_ROTATION);
        }
        let mut out = [0.0; 4];
        self.sample(seconds, &mut out);
        normalized(out).unwrap_or(IDENTITY_ROTATION)
    }

    fn span_at(&self, seconds: f64) -> TimeSpan {
        let after = self.times.partition_point(|&time| f64::from(time) <= seconds);
        if after == 0 {
            return TimeSpan::At(0);
        }
        if after == self.times.len() {
            return TimeSpan::At(after - 1);
        }
        let (from, to) = (f64::from(self.times[after - 1]), f64::from(self.times[after]));
        TimeSpan::Between(after - 1, ((seconds - from) / (to - from)) as f32, (to - from) as f32)
    }

    /// The value of a key, without its slopes.
    fn value(&self, key: usize) -> &[f32] {
        self.row(if self.interpolation == Interpolation::CubicSpline { 3 * key + 1 } else { key })
    }

    fn row(&self, row: usize) -> &[f32] {
        &self.values[row * self.width..(row + 1) * self.width]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn keys(times: &[f32], values: &[f32], width: usize, interpolation: Interpolation) -> Keys {
        Keys::new(times.into(), values.to_vec(), width, interpolation).expect("the promises hold")
    }

    fn at(keys: &Keys, seconds: f64) -> f32 {
        let mut out = [0.0];
        keys.sample(seconds, &mut out);
        out[0]
    }

    #[test]
    fn a_step_keeps_its_value_until_the_next_key() {
        let keys = keys(&[1.0, 2.0, 4.0], &[10.0, 20.0, 30.0], 1, Interpolation::Step);
        for (seconds, value) in
            [(0.0, 10.0), (1.0, 10.0), (1.99, 10.0), (2.0, 20.0), (3.9, 20.0), (4.0, 30.0), (9.0, 30.0)]
        {
            assert_eq!(at(&keys, seconds), value, "at {seconds}");
        }
    }

    #[test]
    fn linear_keys_are_joined_by_lines_and_clamped_at_the_ends() {
        let keys = keys(&[1.0, 2.0, 4.0], &[10.0, 20.0, 0.0], 1, Interpolation::Linear);
        for (seconds, value) in [(-1.0, 10.0), (1.5, 15.0), (2.0, 20.0), (3.0, 10.0), (3.5, 5.0), (100.0, 0.0)] {
            assert!((at(&keys, seconds) - value).abs() < 1e-5, "at {seconds}");
        }
    }

    #[test]
    fn a_spline_through_a_cubic_is_that_cubic() {
        // The Hermite spline with the values and slopes of a cubic polynomial reproduces it.
        let cubic = |t: f64| 0.5 * t.powi(3) - 2.0 * t * t + 3.0 * t - 1.0;
        let slope = |t: f64| 1.5 * t * t - 4.0 * t + 3.0;
        let times = [0.0, 0.5, 2.0, 3.5_f32];
        let values: Vec<f32> = times
            .iter()
            .map(|&t| f64::from(t))
            .flat_map(|t| [slope(t), cubic(t), slope(t)])
            .map(|v| v as f32)
            .collect();
        let keys = keys(&times, &values, 1, Interpolation::CubicSpline);
        for i in 0..=350 {
            let t = f64::from(i) / 100.0;
            assert!((f64::from(at(&keys, t)) - cubic(t)).abs() < 2e-5, "at {t}: {} and {}", at(&keys, t), cubic(t));
        }
        assert_eq!(at(&keys, 9.0), values[10]);
    }

    #[test]
    fn rotations_turn_evenly_along_the_shorter_arc() {
        let half = |degrees: f32| (degrees / 2.0).to_radians();
        let turn = |degrees: f32| [0.0, half(degrees).sin(), 0.0, half(degrees).cos()];
        // The same rotation as 90 degrees, by the other quaternion.
        let other = turn(90.0).map(|q| -q);
        let values: Vec<f32> = turn(0.0).into_iter().chain(other).collect();
        let keys = keys(&[0.0, 1.0], &values, 4, Interpolation::Linear);
        for i in 0..=10 {
            let s = i as f32 / 10.0;
            let (found, wanted) = (keys.rotation(f64::from(s)), turn(90.0 * s));
            let dot: f32 = found.iter().zip(wanted).map(|(a, b)| a * b).sum();
            assert!(dot.abs() > 1.0 - 1e-6, "at {s}: {found:?} is not {wanted:?}");
        }
    }

    #[test]
    fn keys_at_the_same_time_jump() {
        let keys = keys(&[0.0, 1.0, 1.0, 2.0], &[0.0, 1.0, 5.0, 6.0], 1, Interpolation::Linear);
        assert!((at(&keys, 0.999) - 0.999).abs() < 1e-5);
        assert_eq!(at(&keys, 1.0), 5.0);
        assert_eq!(at(&keys, 1.5), 5.5);
    }

    #[test]
    fn broken_keys_are_refused() {
        let new = |times: &[f32], values: usize| Keys::new(times.into(), vec![0.0; values], 1, Interpolation::Linear);
        assert!(new(&[], 0).is_none());
        assert!(new(&[0.0, 1.0], 3).is_none());
        assert!(new(&[1.0, 0.0], 2).is_none());
        assert!(new(&[0.0, f32::NAN], 2).is_none());
        assert!(new(&[0.0, f32::INFINITY], 2).is_none());
        assert!(new(&[0.0, 1.0], 2).is_some());
    }
}
