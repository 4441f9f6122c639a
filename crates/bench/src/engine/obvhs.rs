//! `obvhs`: a compressed eight-wide tree, built by clustering and reinsertion.

use std::time::Duration;

use glam::Vec3A;
use obvhs::BvhBuildParams;
use obvhs::cwbvh::CwBvh;
use obvhs::cwbvh::builder::build_cwbvh_from_tris;
use obvhs::ray::RayHit;
use obvhs::triangle::Triangle;

use super::interface::{Class, Engine, Prepared, Tree};
use super::moller_trumbore;
use super::thread_pool::ThreadPool;
use crate::failure::Failure;
use crate::ray::{Answer, Ray};
use crate::soup::Soup;

/// All settings that are compared.
pub(crate) fn variants() -> Vec<Box<dyn Engine>> {
    vec![
        Box::new(Obvhs { name: "obvhs fastest", class: Class::Fastest, params: BvhBuildParams::fastest_build() }),
        Box::new(Obvhs { name: "obvhs medium", class: Class::Fast, params: BvhBuildParams::medium_build() }),
        Box::new(Obvhs { name: "obvhs very slow", class: Class::Best, params: BvhBuildParams::very_slow_build() }),
    ]
}

struct Obvhs {
    name: &'static str,
    class: Class,
    params: BvhBuildParams,
}

impl Engine for Obvhs {
    fn name(&self) -> &str {
        self.name
    }

    fn class(&self) -> Class {
        self.class
    }

    fn prepare(&self, soup: &Soup) -> Result<Box<dyn Prepared>, Failure> {
        let triangles = (0..soup.len() as u32).map(|i| {
            let [v0, v1, v2] = soup.corners(i).map(Vec3A::from);
            Triangle { v0, v1, v2 }
        });
        Ok(Box::new(PreparedMesh { triangles: triangles.collect(), params: self.params }))
    }
}

struct PreparedMesh {
    triangles: Vec<Triangle>,
    params: BvhBuildParams,
}

impl Prepared for PreparedMesh {
    fn build(&mut self, pool: &ThreadPool) -> Result<Box<dyn Tree>, Failure> {
        let mut its_own_clock = Duration::ZERO;
        let tree = pool.run(|| build_cwbvh_from_tris(&self.triangles, self.params, &mut its_own_clock));
        // In the order of the leaves, as the documentation of the crate advises.
        let triangles = tree.primitive_indices.iter().map(|&i| self.triangles[i as usize]).collect();
        Ok(Box::new(BuiltTree { tree, triangles }))
    }
}

struct BuiltTree {
    tree: CwBvh,
    triangles: Vec<Triangle>,
}

#[inline]
fn engine_ray(ray: &Ray) -> obvhs::ray::Ray {
    obvhs::ray::Ray::new(ray.origin.into(), ray.direction.into(), 0.0, ray.t_max)
}

impl Tree for BuiltTree {
    fn closest(&self, rays: &[Ray], answers: &mut [Answer]) {
        for (ray, slot) in rays.iter().zip(answers) {
            let mut hit = RayHit::none();
            let found = self.tree.ray_traverse(engine_ray(ray), &mut hit, |ray, id| self.triangles[id].intersect(ray));
            *slot = if found {
                let leaf_index = hit.primitive_id as usize;
                let Triangle { v0, v1, v2 } = self.triangles[leaf_index];
                // The crate's own function for the weights divides by the length of the normal once
                // too often.
                let (_, u, v) = moller_trumbore::hit(ray, &[v0, v1, v2].map(Into::into)).unwrap_or_default();
                Answer { t: hit.t, u, v, primitive: self.tree.primitive_indices[leaf_index], mesh: 0 }
            } else {
                Answer::MISS
            };
        }
    }

    fn occluded(&self, rays: &[Ray], answers: &mut [bool]) {
        for (ray, slot) in rays.iter().zip(answers) {
            *slot = !self.tree.ray_traverse_miss(engine_ray(ray), |ray, id| self.triangles[id].intersect(ray));
        }
    }
}
