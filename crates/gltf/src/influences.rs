//! Which joints move a vertex, and how much: at most four, with weights that sum to one.

use kinetree::Skin;

use crate::accessor::Accessors;
use crate::error::{Item, Problem};
use crate::json::{Accessor, ElementType, Index};
use crate::notes::Notes;

/// A set of joints and a set of weights, as accessors.
pub(crate) type Set = (Index<Accessor>, Index<Accessor>);

/// The influences of a vertex that follows the first joint.
pub(crate) const FIRST_JOINT: ([u16; 4], [f32; 4]) = ([0; 4], [1.0, 0.0, 0.0, 0.0]);

/// Reads the influences on `count` vertices from all sets. Of more than four, the largest are kept.
/// A vertex without any weight follows the first joint, so that it stays with its character.
pub(crate) fn read(
    sets: &[Set],
    count: usize,
    accessors: &Accessors<'_>,
    item: &Item,
    notes: &mut Notes,
) -> Result<Skin, Problem> {
    let mut loaded = Vec::with_capacity(sets.len());
    for &(joints, weights) in sets {
        let joints = accessors.integers::<4>(joints, ElementType::Vec4, item)?;
        let weights = accessors.floats::<4>(weights, ElementType::Vec4, item)?;
        if joints.len() != count || weights.len() != count {
            return Err(item.invalid("has joints or weights for another number of vertices than it has"));
        }
        loaded.push((joints, weights));
    }
    let mut skin = Skin { joints: Vec::with_capacity(count), weights: Vec::with_capacity(count) };
    let mut pairs: Vec<(u32, f32)> = Vec::with_capacity(4 * sets.len());
    let (mut dropped, mut unbound, mut negative, mut unbounded) = (0usize, 0usize, 0usize, 0usize);
    for vertex in 0..count {
        pairs.clear();
        for (joints, weights) in &loaded {
            let both = joints[vertex].into_iter().zip(weights[vertex]);
            negative += weights[vertex].iter().filter(|&&weight| weight < 0.0).count();
            unbounded += weights[vertex].iter().filter(|weight| weight.is_nan() || **weight == f32::INFINITY).count();
            pairs.extend(both.filter(|&(_, weight)| weight.is_finite() && weight > 0.0));
        }
        if pairs.len() > 4 {
            // Stable, so that of equal weights the first are kept.
            pairs.sort_by(|a, b| b.1.total_cmp(&a.1));
            pairs.truncate(4);
            dropped += 1;
        }
        unbound += usize::from(pairs.is_empty());
        let (joints, weights) = normalized(&pairs).map_err(|joint| item.invalid(format!("names joint {joint}")))?;
        skin.joints.push(joints);
        skin.weights.push(weights);
    }
    for (count, kind) in [(negative, "negative"), (unbounded, "not finite")] {
        if count > 0 {
            notes.add(|| format!("{item}: {count} joint weights that are {kind} count as zero"));
        }
    }
    if dropped > 0 {
        notes.add(|| {
            format!("{item}: of more than 4 joints at {dropped} vertices, the 4 with the largest weights count")
        });
    }
    if unbound > 0 {
        notes.add(|| format!("{item}: {unbound} vertices without any weight follow the first joint"));
    }
    Ok(skin)
}

/// The error is a joint with a number that no skin can have.
fn normalized(pairs: &[(u32, f32)]) -> Result<([u16; 4], [f32; 4]), u32> {
    // In double precision, the sum of finite weights is finite.
    let sum: f64 = pairs.iter().map(|&(_, weight)| f64::from(weight)).sum();
    if pairs.is_empty() {
        return Ok(FIRST_JOINT);
    }
    let (mut joints, mut weights) = ([0; 4], [0.0; 4]);
    for (slot, &(joint, weight)) in pairs.iter().enumerate() {
        joints[slot] = u16::try_from(joint).map_err(|_| joint)?;
        weights[slot] = (f64::from(weight) / sum) as f32;
    }
    Ok((joints, weights))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_sum_to_one() {
        let (joints, weights) = normalized(&[(7, 1.0), (2, 3.0)]).expect("small joints");
        assert_eq!(joints, [7, 2, 0, 0]);
        assert_eq!(weights, [0.25, 0.75, 0.0, 0.0]);
        let (_, weights) = normalized(&[(0, f32::MAX), (1, f32::MAX)]).expect("small joints");
        assert_eq!(weights, [0.5, 0.5, 0.0, 0.0]);
        assert_eq!(normalized(&[]), Ok(FIRST_JOINT));
        assert_eq!(normalized(&[(70_000, 1.0)]), Err(70_000));
    }
}
