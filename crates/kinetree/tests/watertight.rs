//! Nothing slips between triangles that share an edge or a vertex.

mod common;

use common::{Random, alone, cube, placed, sphere};
use kinetree::{Affine, Mesh, Ray, Snapshot};

/// Rays from inside of a closed mesh, aimed at its edges and vertices, all have to hit something.
fn nothing_leaves(name: &str, view: &Snapshot, origins: &[[f32; 3]], count: usize, seed: u64) {
    let mut random = Random::new(seed);
    let instance = view.instance_at(0);
    let place = instance.world_from_object();
    let corners: Vec<[[f32; 3]; 3]> = instance
        .triangles()
        .iter()
        .map(|triangle| triangle.map(|vertex| place.transform_point(instance.positions()[vertex as usize])))
        .collect();
    for i in 0..count {
        let [a, b, _] = corners[random.below(corners.len())];
        let along = if i % 3 == 0 { 0.0 } else { random.unit() };
        let target = [0, 1, 2].map(|axis| a[axis] + (b[axis] - a[axis]) * along);
        let origin = origins[random.below(origins.len())];
        let ray = Ray::new(origin, [0, 1, 2].map(|axis| target[axis] - origin[axis]));
        if ray.direction == [0.0; 3] {
            continue;
        }
        assert!(view.closest_hit(&ray).is_some(), "{name}, seed {seed}: {ray:?} slipped out");
        assert!(view.occluded(&ray), "{name}, seed {seed}: {ray:?} slipped out");
    }
}

#[test]
fn rays_through_shared_edges_and_vertices_never_slip_between() {
    let mut random = Random::new(1);
    let inside: Vec<_> = (0..50).map(|_| random.point(0.5)).collect();
    nothing_leaves("sphere", &alone(sphere(24, 37)), &inside, 400_000, 2);
    nothing_leaves("coarse sphere", &alone(sphere(4, 5)), &inside, 200_000, 3);
    nothing_leaves("cube", &alone(cube()), &inside, 200_000, 4);
    nothing_leaves("cube, from the middle", &alone(cube()), &[[0.0; 3]], 100_000, 5);
    let room = Affine::from_scale([500.0; 3]);
    let near_walls: Vec<_> = (0..50)
        .map(|i| {
            let mut p = random.point(400.0);
            p[i % 3] = 499.0;
            p
        })
        .collect();
    nothing_leaves("hall", &placed(cube(), &[room]), &near_walls, 100_000, 6);
    let skewed = Affine::from_translation([900.0, -40.0, 3.0])
        * Affine::from_axis_angle([1.0, 2.0, 3.0], 1.0)
        * Affine::from_scale([-2.0, 0.5, 7.0]);
    let moved: Vec<_> = inside.iter().map(|p| skewed.transform_point(*p)).collect();
    nothing_leaves("placed sphere", &placed(sphere(24, 37), &[skewed]), &moved, 200_000, 7);
}

#[test]
fn a_large_floor_has_no_cracks() {
    // A kilometre of ground, seen from eye height, with rays at the seams and along the axes.
    let n = 40;
    let view = alone(common::grid(n, 1000.0));
    let mut random = Random::new(9);
    for i in 0..200_000 {
        let seam = random.below(n as usize - 1) as f32 + 1.0;
        let mut target = [random.within(1.0, 999.0), 0.0, seam * 1000.0 / n as f32];
        if i % 2 == 0 {
            target.swap(0, 2);
        }
        let origin = [random.within(1.0, 999.0), random.within(0.1, 3.0), random.within(1.0, 999.0)];
        let ray = Ray::new(origin, [0, 1, 2].map(|axis| target[axis] - origin[axis]));
        assert!(view.occluded(&ray), "{ray:?}");
        let down = Ray::new([target[0], origin[1], target[2]], [0.0, -1.0, 0.0]);
        assert!(view.closest_hit(&down).is_some(), "{down:?}");
    }
}

#[test]
fn a_slit_between_two_meshes_is_seen_through_and_no_slit_is_not() {
    let left = [[-1.0, -1.0, 0.0], [0.0, -1.0, 0.0], [0.0, 1.0, 0.0]];
    let right = |gap: f32| [[gap, -1.0, 0.0], [1.0, 0.0, 0.0], [gap, 1.0, 0.0]];
    for (gap, closed) in [(0.0, true), (1e-3, false)] {
        let view = alone(Mesh::new(&[left, right(gap)].concat(), &[[0, 1, 2], [3, 4, 5]]).unwrap());
        let ray = Ray::new([gap * 0.5, 0.1, 1.0], [0.0, 0.0, -1.0]);
        assert_eq!(view.occluded(&ray), closed);
    }
}
