//! Sets of rays: generated once per scene, the same for every engine.

mod bounce;
mod first;

use glam::Vec3;
use serde::{Deserialize, Serialize};

use crate::ray::{Answer, Ray};
use crate::scene::BenchScene;
use kinetree::Coherence;

/// The kind of a set of rays.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum RayKind {
    /// From a pinhole camera, in tiles of 8x8 pixels.
    Primary,
    /// From the hits of primary rays, with cosine-weighted directions, in the order of the pixels.
    Diffuse,
    /// As `Diffuse`, in random order.
    DiffuseShuffled,
    /// The fourth bounce, in the order of the pixels.
    Bounce4,
    /// From the hits of primary rays, with cosine-weighted directions, at most a fiftieth of the
    /// scene long.
    ShadowShort,
    /// From the hits of primary rays to one light near the camera.
    Shadow,
    /// From outside the scene, along the axes.
    Axis,
}

/// What a set is traced for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum QueryKind {
    /// The nearest hit.
    Closest,
    /// Whether there is any hit.
    Occluded,
}

impl RayKind {
    /// All kinds, in the order of the tables.
    pub(crate) const ALL: [Self; 7] = [
        Self::Primary,
        Self::Diffuse,
        Self::DiffuseShuffled,
        Self::Bounce4,
        Self::Shadow,
        Self::ShadowShort,
        Self::Axis,
    ];

    /// The name in case files and results.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Primary => "primary",
            Self::Diffuse => "diffuse",
            Self::DiffuseShuffled => "diffuse_shuffled",
            Self::Bounce4 => "bounce4",
            Self::Shadow => "shadow",
            Self::ShadowShort => "shadow_short",
            Self::Axis => "axis",
        }
    }

    /// What such a set is traced for.
    pub(crate) fn query_kind(self) -> QueryKind {
        match self {
            Self::Shadow | Self::ShadowShort => QueryKind::Occluded,
            _ => QueryKind::Closest,
        }
    }

    /// The coherence that a batch call is told; `None` where batches are not measured.
    pub(crate) fn batch(self) -> Option<Coherence> {
        match self {
            Self::Primary | Self::Shadow => Some(Coherence::Coherent),
            Self::DiffuseShuffled => Some(Coherence::Incoherent),
            _ => None,
        }
    }
}

/// A set of rays.
pub(crate) struct RaySet {
    /// What the rays are like.
    pub(crate) kind: RayKind,
    /// The rays, in the order in which they are traced.
    pub(crate) rays: Vec<Ray>,
}

/// Generates the sets of these kinds, each of about `count` rays. `trace` finds the hits from which
/// rays start; a set without rays, because nothing was hit, is left out.
pub(crate) fn sets(
    scene: &BenchScene,
    kinds: &[RayKind],
    count: &dyn Fn(RayKind) -> usize,
    seed: u64,
    trace: &dyn Fn(&[Ray]) -> Vec<Answer>,
) -> Vec<RaySet> {
    let primary = first::primary(&scene.camera, count(RayKind::Primary));
    let hit_points = bounce::HitPoints::of(&scene.soup, &primary, &trace(&primary));
    let diffuse = |kind: RayKind| hit_points.diffuse(count(kind), seed, 0);
    let make = |kind: RayKind| match kind {
        RayKind::Primary => primary.clone(),
        RayKind::Diffuse => diffuse(kind),
        RayKind::DiffuseShuffled => {
            let mut rays = diffuse(kind);
            crate::rng::Rng::new(seed, 0x5aff).shuffle(&mut rays);
            rays
        }
        RayKind::Bounce4 => (1..4).fold(diffuse(kind), |rays, bounce| {
            bounce::HitPoints::of(&scene.soup, &rays, &trace(&rays)).diffuse(count(kind), seed, bounce)
        }),
        RayKind::Shadow => hit_points.to_light(bounce::light(&scene.camera, &hit_points), count(kind)),
        RayKind::ShadowShort => {
            hit_points.short(Vec3::from(scene.soup.bounds().extent()).length() * 0.02, count(kind), seed)
        }
        RayKind::Axis => first::axis_parallel(&scene.soup, count(kind), seed),
    };
    kinds.iter().map(|&kind| RaySet { kind, rays: make(kind) }).filter(|set| !set.rays.is_empty()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::Reference;
    use crate::scene::SceneChoice;

    fn all() -> Vec<RaySet> {
        let scene = SceneChoice::Terrain { seed: 1, triangles: 4000 }.open().unwrap();
        let reference = Reference::of(&scene.soup).unwrap();
        sets(&scene, &RayKind::ALL, &|_| 1000, 7, &|rays| reference.closest(&scene.soup, rays))
    }

    #[test]
    fn ray_sets_are_the_same_every_time() {
        let (one, other) = (all(), all());
        assert_eq!(one.len(), RayKind::ALL.len());
        for (a, b) in one.iter().zip(&other) {
            assert_eq!(a.kind, b.kind);
            assert_eq!(a.rays, b.rays, "{}", a.kind.name());
        }
    }

    #[test]
    fn every_ray_can_be_traced_and_every_set_is_full() {
        for set in all() {
            assert!((900..=1100).contains(&set.rays.len()), "{}: {}", set.kind.name(), set.rays.len());
            for ray in &set.rays {
                let direction = Vec3::from(ray.direction);
                assert!(direction.is_normalized() && Vec3::from(ray.origin).is_finite() && ray.t_max > 0.0);
                let axes = ray.direction.iter().filter(|d| **d != 0.0).count();
                assert!(set.kind != RayKind::Axis || axes == 1);
            }
        }
    }

    #[test]
    fn shuffling_keeps_the_rays() {
        let sets = all();
        let sorted = |kind: RayKind| {
            let set = sets.iter().find(|set| set.kind == kind).unwrap();
            let mut keys: Vec<[u32; 6]> = set
                .rays
                .iter()
                .map(|ray| [ray.origin, ray.direction].concat().iter().map(|x| x.to_bits()).collect::<Vec<_>>())
                .map(|key| key.try_into().unwrap())
                .collect();
            keys.sort_unstable();
            keys
        };
        assert_eq!(sorted(RayKind::Diffuse), sorted(RayKind::DiffuseShuffled));
    }
}
