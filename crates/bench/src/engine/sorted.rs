//! Single calls of another engine on rays sorted as kinetree sorts them, which shows what sorting
//! alone gains. The time includes the sort and both copies.

use kinetree::Aabb;
use kinetree::query::sort::{BLOCK, FETCHED, Sorter};

use crate::ray::{Answer, Ray};

/// Sorts rays of a scene with these bounds block by block, and traces them in groups as large as
/// those of kinetree's batches.
pub(crate) fn trace_sorted<A: Copy>(
    bounds: Aabb,
    rays: &[Ray],
    answers: &mut [A],
    nothing: A,
    trace: impl Fn(&[Ray], &mut [A]),
) {
    let mut sorter = Sorter::new(bounds);
    let library_ray = |ray: &Ray| kinetree::Ray::new(ray.origin, ray.direction).with_range(0.0, ray.t_max);
    let (mut block, mut sorted, mut answered) = (Vec::new(), Vec::new(), Vec::new());
    for (rays, answers) in rays.chunks(BLOCK).zip(answers.chunks_mut(BLOCK)) {
        block.clear();
        block.extend(rays.iter().map(library_ray));
        for keys in sorter.order(&block).chunks(FETCHED) {
            sorted.clear();
            sorted.extend(keys.iter().map(|key| rays[key.ray()]));
            answered.clear();
            answered.resize(keys.len(), nothing);
            trace(&sorted, &mut answered);
            for (key, answer) in keys.iter().zip(&answered) {
                answers[key.ray()] = *answer;
            }
        }
    }
}

/// The nearest hit of each ray.
pub(crate) fn closest(bounds: Aabb, rays: &[Ray], answers: &mut [Answer], trace: impl Fn(&[Ray], &mut [Answer])) {
    trace_sorted(bounds, rays, answers, Answer::MISS, trace);
}

/// Whether each ray hits anything.
pub(crate) fn occluded(bounds: Aabb, rays: &[Ray], answers: &mut [bool], trace: impl Fn(&[Ray], &mut [bool])) {
    trace_sorted(bounds, rays, answers, false, trace);
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    #[test]
    fn every_ray_gets_its_own_answer() {
        let rays: Vec<Ray> = (0..1000).map(|i| Ray::new(Vec3::splat((i * 37 % 1000) as f32), Vec3::X)).collect();
        let mut answers = vec![Answer::MISS; rays.len()];
        closest(Aabb::new([0.0; 3], [1000.0; 3]), &rays, &mut answers, |rays, answers| {
            assert!(rays.len() <= FETCHED);
            rays.iter().zip(answers).for_each(|(ray, answer)| answer.t = ray.origin[0]);
        });
        assert!(rays.iter().zip(&answers).all(|(ray, answer)| answer.t == ray.origin[0]));
    }
}
