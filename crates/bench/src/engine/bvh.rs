//! The crate `bvh`: a binary tree, traversed by its iterator in the order of box entries.

use bvh::aabb::{Aabb, Bounded};
use bvh::bounding_hierarchy::{BHShape, BoundingHierarchy};
use bvh::bvh::Bvh;
use glam::Vec3;
use nalgebra::{Point3, Vector3};

use super::interface::{Class, Engine, Prepared, Tree};
use super::moller_trumbore;
use super::thread_pool::ThreadPool;
use crate::failure::Failure;
use crate::ray::{Answer, Ray};
use crate::soup::Soup;

/// All settings that are compared.
pub(crate) fn variants() -> Vec<Box<dyn Engine>> {
    vec![Box::new(Settings)]
}

struct Settings;

impl Engine for Settings {
    fn name(&self) -> &str {
        "bvh"
    }

    fn class(&self) -> Class {
        Class::Fast
    }

    fn prepare(&self, soup: &Soup) -> Result<Box<dyn Prepared>, Failure> {
        let shapes =
            (0..soup.len() as u32).map(|primitive| Shape { corners: soup.corners(primitive), primitive, node: 0 });
        Ok(Box::new(PreparedMesh { shapes: shapes.collect(), spare: Vec::new() }))
    }
}

/// A triangle that stores the index of its node, as the crate requires.
#[derive(Clone)]
struct Shape {
    corners: [Vec3; 3],
    primitive: u32,
    node: usize,
}

impl Bounded<f32, 3> for Shape {
    fn aabb(&self) -> Aabb<f32, 3> {
        let [a, b, c] = self.corners;
        Aabb::with_bounds(a.min(b).min(c).to_array().into(), a.max(b).max(c).to_array().into())
    }
}

impl BHShape<f32, 3> for Shape {
    fn set_bh_node_index(&mut self, node: usize) {
        self.node = node;
    }

    fn bh_node_index(&self) -> usize {
        self.node
    }
}

struct PreparedMesh {
    shapes: Vec<Shape>,
    spare: Vec<Shape>,
}

impl Prepared for PreparedMesh {
    fn set_up(&mut self, _: &ThreadPool) -> Result<(), Failure> {
        self.spare.clone_from(&self.shapes);
        Ok(())
    }

    fn build(&mut self, pool: &ThreadPool) -> Result<Box<dyn Tree>, Failure> {
        if self.spare.is_empty() {
            self.set_up(pool)?;
        }
        let mut shapes = std::mem::take(&mut self.spare);
        let tree = pool.run(|| Bvh::build_par(&mut shapes));
        Ok(Box::new(BuiltTree { tree, shapes }))
    }
}

struct BuiltTree {
    tree: Bvh<f32, 3>,
    shapes: Vec<Shape>,
}

/// The constructor of the crate would normalise the direction, and so change the meaning of `t`.
#[inline]
fn engine_ray(ray: &Ray) -> bvh::ray::Ray<f32, 3> {
    let direction = Vector3::from(ray.direction);
    bvh::ray::Ray { origin: Point3::from(ray.origin), direction, inv_direction: direction.map(|d| 1.0 / d) }
}

impl Tree for BuiltTree {
    fn closest(&self, rays: &[Ray], answers: &mut [Answer]) {
        for (ray, slot) in rays.iter().zip(answers) {
            let query = engine_ray(ray);
            let mut best = Answer { t: ray.t_max, ..Answer::MISS };
            for shape in self.tree.nearest_traverse_iterator(&query, &self.shapes) {
                // Boxes come in the order of their entries: none that is entered behind the hit
                // holds a nearer one.
                let entry = query.intersection_slice_for_aabb(&shape.aabb());
                if best.is_hit() && entry.is_some_and(|(entry, _)| entry > best.t) {
                    break;
                }
                if let Some((t, u, v)) = moller_trumbore::hit(ray, &shape.corners).filter(|hit| hit.0 <= best.t) {
                    best = Answer { t, u, v, primitive: shape.primitive, mesh: 0 };
                }
            }
            *slot = if best.is_hit() { best } else { Answer::MISS };
        }
    }

    fn occluded(&self, rays: &[Ray], answers: &mut [bool]) {
        for (ray, slot) in rays.iter().zip(answers) {
            let query = engine_ray(ray);
            // The other iterator of the crate has a stack of 32 entries, and panics when a tree is
            // deeper.
            let mut shapes = self.tree.nearest_traverse_iterator(&query, &self.shapes);
            *slot = shapes.any(|shape| moller_trumbore::hit(ray, &shape.corners).is_some_and(|hit| hit.0 <= ray.t_max));
        }
    }
}
