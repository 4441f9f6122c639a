//! A packet against its rays, one by one.

use super::*;
use crate::geometry::slab::ErrorBound;
use crate::geometry::{Aabb, Affine, Ray, SafeRay, WatertightRay};
use crate::simd::{Isa, Kernel, Level};
use crate::wide::WideNode;

/// Steele, Lea and Flood 2014, "Fast Splittable Pseudorandom Number Generators".
struct Random(u64);

impl Random {
    /// In -1..1.
    fn unit(&mut self) -> f32 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ z >> 30).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ z >> 27).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((z ^ z >> 31) >> 40) as f32 / (1 << 23) as f32 - 1.0
    }

    fn point(&mut self, size: f32) -> [f32; 3] {
        [0; 3].map(|_| self.unit() * size)
    }
}

/// Tiles of a camera, bundles of parallel rays, and rays that have nothing in common, some along
/// axes, some tiny.
fn rays(seed: u64) -> Vec<Ray> {
    let mut random = Random(seed);
    let (eye, ahead) = (random.point(4.0), random.point(1.0));
    let spread = [0.0, 0.01, 0.3, 3.0][seed as usize % 4];
    (0..PACKET)
        .map(|at| {
            let mut direction = random.point(spread);
            (0..3).for_each(|axis| direction[axis] += ahead[axis]);
            if seed % 5 == 0 {
                direction[at % 3] = if at % 2 == 0 { 0.0 } else { -0.0 };
            }
            if seed % 7 == 0 {
                direction = direction.map(|x| x * 1e-30);
            }
            let origin = if seed % 3 == 0 { random.point(4.0) } else { eye };
            Ray::new(origin, direction).with_range((random.unit() * 0.5).max(0.0), 1.5 + random.unit())
        })
        .collect()
}

struct Compare(u64);

impl Kernel for Compare {
    type Output = usize;

    #[inline(always)]
    fn run<I: Isa>(self, isa: I) -> usize {
        let Self(seed) = self;
        let mut random = Random(!seed);
        let scene = Aabb::new([-5.0, -6.0, -4.0], [5.0, 4.0, 7.0]);
        let rays = rays(seed);
        let (packet, set, t_max) = RayPacket::gather(isa, &rays);
        let valid: Vec<Option<Ray>> = rays.iter().map(|ray| ray.validated()).collect();
        assert!((0..PACKET).all(|at| valid[at].is_some() == (set >> at & 1 == 1)), "seed {seed}");

        let watertight = WatertightPacket::new(isa, &packet);
        for (at, ray) in valid.iter().enumerate().filter_map(|(at, ray)| Some((at, (*ray)?))) {
            let one = WatertightRay::new(&ray);
            assert_eq!(watertight.of(at), (one.shear.map(f32::to_bits), one.t_scale.to_bits()), "seed {seed}, {ray:?}");
            let along = one.axes[2];
            assert_eq!(WatertightPacket::axes(along, packet.negative[along] >> at & 1 == 1), one.axes, "seed {seed}");
            assert!((0..3).all(|axis| watertight.along[axis] >> at & 1 == u64::from(axis == along)), "seed {seed}");
        }

        let map = Affine::from_axis_angle([1.0, 2.0, -1.0], 1.1) * Affine::from_scale([2.0, -0.5, 3.0]);
        let (moved, moved_set) = packet.moved(isa, &map);
        for (at, ray) in valid.iter().enumerate().filter_map(|(at, ray)| Some((at, (*ray)?))) {
            let (origin, direction) = (map.transform_point(ray.origin), map.transform_vector(ray.direction));
            let same = |a: [f32; 3], b: [f32; 3]| a.map(f32::to_bits) == b.map(f32::to_bits);
            let there = moved.ray(at);
            assert!(moved_set >> at & 1 == 1, "seed {seed}");
            assert!(same(there.origin, origin) && same(there.direction, direction), "seed {seed}, {ray:?}");
        }

        // A box that a ray enters by itself is entered in the packet, and the interval does not
        // rule it out.
        let mut entered = 0;
        let planes = PacketPlanes::new(isa, &packet, set, &scene, ErrorBound::TRIANGLES);
        for (at, ray) in valid.iter().enumerate().filter_map(|(at, ray)| Some((at, (*ray)?))) {
            let one = SafeRay::new(&ray, &scene, ErrorBound::TRIANGLES);
            assert_eq!(planes.in_double >> at & 1 == 1, one.needs_double_precision(), "seed {seed}, {ray:?}");
            for axis in (0..3).filter(|_| !one.needs_double_precision()) {
                let found = [&planes.near_scale, &planes.near_offset, &planes.far_scale, &planes.far_offset];
                let expected = [one.slabs.near_scale, one.slabs.near_offset, one.slabs.far_scale, one.slabs.far_offset];
                let (found, expected) = (found.map(|x| x[axis].get(at)), expected.map(|x| x[axis]));
                assert_eq!(found, expected, "seed {seed}, axis {axis}, {ray:?}");
            }
        }
        for _ in 0..40 {
            let mut node = WideNode::new(0);
            for lane in 0..8 {
                // Beside where one of the rays passes.
                let (near, size) = (rays[lane * 8].at(random.unit() + 1.0), random.point(1.0).map(f32::abs));
                let corner = near.map(|x| x - random.unit() * 0.6 - 0.4);
                node.set_box(lane, &Aabb::new(corner, [0, 1, 2].map(|axis| corner[axis] + size[axis])));
            }
            node.in_use = 0xff;
            for alike in octants(set & !planes.in_double, packet.negative) {
                let interval = Interval::new(isa, &packet, &planes, alike);
                let (entries, exits) = interval.enter(isa, &node, f32::INFINITY);
                let (mask, entries) = (isa.lt_bits(entries, exits), isa.store(entries));
                for lane in 0..8 {
                    let row = planes.enter(isa, (&node, lane), interval.sides, alike, &packet.t_min, &t_max);
                    for at in (0..PACKET).filter(|at| alike >> at & 1 == 1) {
                        let Some(ray) = valid[at] else { continue };
                        let one =
                            SafeRay::new(&ray, &scene, ErrorBound::TRIANGLES).enter(&node.bounds(lane), ray.t_max);
                        // Within the error bound, levels may differ.
                        let clear = exactly_enters(&ray, &node.bounds(lane));
                        if clear {
                            assert!(
                                one.is_some() && row >> at & 1 == 1,
                                "seed {seed}, {ray:?}, {:?}",
                                node.bounds(lane)
                            );
                            assert!(mask >> lane & 1 == 1, "seed {seed}, {ray:?}, {:?}", node.bounds(lane));
                            entered += 1;
                        }
                        if let (true, Some(entry)) = (clear, one) {
                            assert!(entries[lane] <= entry * (1.0 + 1e-5), "seed {seed}");
                        }
                    }
                }
            }
        }
        entered
    }
}

/// In double precision, without any error bound.
fn exactly_enters(ray: &Ray, bounds: &Aabb) -> bool {
    let (mut entry, mut exit) = (f64::from(ray.t_min), f64::from(ray.t_max));
    for axis in 0..3 {
        let (origin, step) = (f64::from(ray.origin[axis]), f64::from(ray.direction[axis]));
        let (low, high) = (f64::from(bounds.min[axis]) - origin, f64::from(bounds.max[axis]) - origin);
        if step == 0.0 {
            if low > 0.0 || high < 0.0 {
                return false;
            }
            continue;
        }
        entry = entry.max((low / step).min(high / step));
        exit = exit.min((low / step).max(high / step));
    }
    entry <= exit
}

#[test]
fn a_packet_never_rules_out_what_one_of_its_rays_enters() {
    for level in Level::available() {
        let entered: usize = (0..60).map(|seed| level.run(Compare(seed))).sum();
        assert!(entered > 10_000, "{level:?}: the boxes have to be where the rays go, only {entered} were entered");
    }
}
