//! Divides rays into runs that are coherent, and gain from packet traversal, and runs that are not.
//!
//! Camera rays are coherent, and shadow rays to the sun from neighbouring points, and the mirror
//! reflections of either; diffusely scattered rays are not. The directions decide, not where the
//! rays come from.

use std::ops::Range;

use glam::Vec3;
use kinetree::{Coherence, Ray};

/// Rays in a packet of the library.
const PACKET: usize = 64;

/// Fewer rays than this are not traced as a packet.
const MIN_RAYS: usize = 33;

/// The largest extent of a packet's unit directions along any axis. Measured: packets of wider ones
/// gained nothing, and a smaller bound left coherent rays to single traversal.
const MAX_SPREAD: f32 = 0.3;

/// Index ranges that cover the rays in order, with the coherence of each. The length of every range
/// but the last is a multiple of [`PACKET`].
pub(crate) fn coherent_runs(rays: &[Ray]) -> impl Iterator<Item = (Range<usize>, Coherence)> + '_ {
    let coherence_at = |start: usize| coherence(&rays[start..rays.len().min(start + PACKET)]);
    let mut start = 0;
    std::iter::from_fn(move || {
        let first = start;
        let coherence = (first < rays.len()).then(|| coherence_at(first))?;
        while start < rays.len() && coherence_at(start) == coherence {
            start += PACKET;
        }
        Some((first..start.min(rays.len()), coherence))
    })
}

fn coherence(rays: &[Ray]) -> Coherence {
    let (mut min, mut max) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
    for ray in rays {
        let direction = Vec3::from(ray.direction);
        (min, max) = (min.min(direction), max.max(direction));
    }
    let is_coherent = rays.len() >= MIN_RAYS && (max - min).max_element() <= MAX_SPREAD;
    if is_coherent { Coherence::Coherent } else { Coherence::Unknown }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn runs_cover_all_rays_in_order_and_packets_have_nearly_parallel_rays() {
        let ahead = |i: usize| Ray::new([0.0; 3], [i as f32 * 1e-3, 0.0, 1.0]);
        let around = |i: usize| Ray::new([0.0; 3], [(i as f32).sin(), (i as f32).cos(), 0.0]);
        let rays: Vec<Ray> = (0..128).map(ahead).chain((0..70).map(around)).chain((0..140).map(ahead)).collect();
        for count in [0, 1, 32, 33, 64, 128, 129, 200, rays.len()] {
            let found: Vec<_> = coherent_runs(&rays[..count]).collect();
            assert_eq!(found.iter().map(|(range, _)| range.len()).sum::<usize>(), count);
            assert!(found.windows(2).all(|pair| pair[0].0.end == pair[1].0.start && pair[0].1 != pair[1].1));
            for (range, _) in found.iter().filter(|(_, coherence)| *coherence == Coherence::Coherent) {
                assert!(range.len() >= MIN_RAYS && range.clone().all(|ray| rays[ray].direction[2] > 0.5), "{range:?}");
            }
        }
        let found: Vec<_> = coherent_runs(&rays).map(|(range, _)| range).collect();
        assert_eq!(found, [0..128, 128..256, 256..320, 320..338]);
    }
}
