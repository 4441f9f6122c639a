//! `parry3d`, the collision library of Rapier: a binary tree, traversed nearest box first.

use parry3d::bounding_volume::Aabb;
use parry3d::math::Vector;
use parry3d::partitioning::{Bvh, BvhBuildStrategy};
use parry3d::query::details::local_ray_intersection_with_triangle;

use super::interface::{Class, Engine, Facts, Prepared, Tree};
use super::moller_trumbore;
use super::thread_pool::ThreadPool;
use crate::failure::Failure;
use crate::ray::{Answer, Ray};
use crate::soup::Soup;

/// All settings that are compared.
pub(crate) fn variants() -> Vec<Box<dyn Engine>> {
    vec![
        Box::new(Parry { name: "parry3d", class: Class::Fast, strategy: || BvhBuildStrategy::Binned }),
        Box::new(Parry { name: "parry3d ploc", class: Class::Best, strategy: || BvhBuildStrategy::Ploc }),
    ]
}

struct Parry {
    name: &'static str,
    class: Class,
    strategy: fn() -> BvhBuildStrategy,
}

impl Engine for Parry {
    fn name(&self) -> &str {
        self.name
    }

    fn class(&self) -> Class {
        self.class
    }

    fn prepare(&self, soup: &Soup) -> Result<Box<dyn Prepared>, Failure> {
        let corners = (0..soup.len() as u32).map(|i| soup.corners(i).map(|p| Vector::from(p.to_array())));
        Ok(Box::new(PreparedMesh { corners: corners.collect(), strategy: self.strategy }))
    }
}

struct PreparedMesh {
    corners: Vec<[Vector; 3]>,
    strategy: fn() -> BvhBuildStrategy,
}

impl Prepared for PreparedMesh {
    fn build(&mut self, _: &ThreadPool) -> Result<Box<dyn Tree>, Failure> {
        let boxes: Vec<Aabb> =
            self.corners.iter().map(|[a, b, c]| Aabb::new(a.min(*b).min(*c), a.max(*b).max(*c))).collect();
        let tree = Bvh::from_leaves((self.strategy)(), &boxes);
        Ok(Box::new(BuiltTree { tree, corners: self.corners.clone() }))
    }
}

struct BuiltTree {
    tree: Bvh,
    corners: Vec<[Vector; 3]>,
}

impl BuiltTree {
    /// The crate's own triangle test.
    #[inline]
    fn hit(&self, primitive: u32, ray: &parry3d::query::Ray, t_max: f32) -> Option<f32> {
        let [a, b, c] = self.corners[primitive as usize];
        let hit = local_ray_intersection_with_triangle(a, b, c, ray)?.0;
        (hit.time_of_impact <= t_max).then_some(hit.time_of_impact)
    }
}

#[inline]
fn engine_ray(ray: &Ray) -> parry3d::query::Ray {
    parry3d::query::Ray::new(Vector::from(ray.origin), Vector::from(ray.direction))
}

impl Tree for BuiltTree {
    fn closest(&self, rays: &[Ray], answers: &mut [Answer]) {
        for (ray, slot) in rays.iter().zip(answers) {
            let query = engine_ray(ray);
            let t_max = ray.t_max.min(f32::MAX);
            let found = self.tree.cast_ray(&query, t_max, |primitive, best| self.hit(primitive, &query, best));
            *slot = found.map_or(Answer::MISS, |(primitive, t)| {
                let corners = self.corners[primitive as usize].map(|p| p.to_array().into());
                let (_, u, v) = moller_trumbore::hit(ray, &corners).unwrap_or_default();
                Answer { t, u, v, primitive, mesh: 0 }
            });
        }
    }

    fn occluded(&self, rays: &[Ray], answers: &mut [bool]) {
        for (ray, slot) in rays.iter().zip(answers) {
            let query = engine_ray(ray);
            let t_max = ray.t_max.min(f32::MAX);
            let mut leaves = self.tree.leaves(|node| node.cast_ray(&query, t_max) <= t_max);
            *slot = leaves.any(|primitive| self.hit(primitive, &query, t_max).is_some());
        }
    }

    fn facts(&self) -> Facts {
        let bytes = self.tree.total_memory_size() + self.corners.len() * size_of::<[Vector; 3]>();
        Facts { bytes: Some(bytes), ..Facts::default() }
    }
}
