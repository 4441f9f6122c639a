//! Watertight hits are those of exact arithmetic, whatever the tree, the processor and the batch.

mod common;

use common::exact::{Crossing, crossing};
use common::{QUALITIES, Random, placed};
use kinetree::build::Quality;
use kinetree::simd::Level;
use kinetree::{Affine, Coherence, Hit, Mesh, Ray, Snapshot};

/// What [`kinetree::Precision::Watertight`] states.
const DISTANCE_ERROR: f64 = 1.0 / (1 << 14) as f64;

struct Shape {
    positions: Vec<[f32; 3]>,
    triangles: Vec<[u32; 3]>,
    views: Vec<(String, Snapshot)>,
}

impl Shape {
    /// At every level and in a tree of every quality.
    fn new(positions: Vec<[f32; 3]>, triangles: Vec<[u32; 3]>, qualities: &[Quality]) -> Self {
        let mut views = Vec::new();
        for &quality in qualities {
            let mesh = Mesh::new(&positions, &triangles).unwrap().with_quality(quality);
            let view = placed(mesh, &[Affine::IDENTITY]);
            for level in Level::available() {
                views.push((format!("{quality:?}, {level:?}"), view.at_level(level)));
            }
        }
        Self { positions, triangles, views }
    }

    fn triangle(&self, number: usize) -> [[f32; 3]; 3] {
        self.triangles[number].map(|vertex| self.positions[vertex as usize])
    }

    fn crossings(&self, ray: &Ray) -> Vec<(u32, Crossing)> {
        let crossings = (0..self.triangles.len()).map(|number| (number as u32, crossing(ray, self.triangle(number))));
        crossings.filter_map(|(number, crossing)| Some((number, crossing?))).collect()
    }

    /// Asks in all ways, and compares with exact arithmetic. `case` names what is tested.
    fn judge(&self, case: &str, rays: &[Ray]) {
        let (_, first) = &self.views[0];
        let expected: Vec<Option<Hit>> = rays.iter().map(|ray| first.query().brute_force().closest_hit(ray)).collect();
        for (ray, hit) in rays.iter().zip(&expected) {
            self.judge_hit(case, ray, hit.as_ref());
        }
        for (how, view) in &self.views {
            let found: Vec<_> = rays.iter().map(|ray| view.closest_hit(ray)).collect();
            assert_same(&format!("{case}, {how}, single"), rays, &expected, &found);
            let dark: Vec<_> = rays.iter().map(|ray| view.occluded(ray)).collect();
            assert!(dark.iter().zip(&expected).all(|(dark, hit)| *dark == hit.is_some()), "{case}, {how}, occluded");
            for coherence in [Coherence::Coherent, Coherence::Incoherent] {
                let mut found = vec![None; rays.len()];
                view.closest_hits(rays, &mut found, coherence);
                assert_same(&format!("{case}, {how}, {coherence:?}"), rays, &expected, &found);
            }
        }
    }

    fn judge_hit(&self, case: &str, ray: &Ray, hit: Option<&Hit>) {
        let crossings = self.crossings(ray);
        let nearest = crossings.iter().reduce(|best, other| if other.1.is_nearer(&best.1) { other } else { best });
        let (Some(nearest), Some(hit)) = (nearest, hit) else {
            assert_eq!(nearest.map(|(number, _)| number), hit.map(|hit| &hit.primitive), "{case}: {ray:?}");
            return;
        };
        let own = crossings.iter().find(|(number, _)| *number == hit.primitive);
        let (_, own) = own.unwrap_or_else(|| panic!("{case}: {ray:?} passes the triangle of {hit:?}"));
        let (t, own, nearest) = (f64::from(hit.t), own.t(), nearest.1.t());
        assert!((t - own).abs() <= DISTANCE_ERROR * own, "{case}: {ray:?}, {hit:?}, t is {own}");
        assert!(
            (t - nearest).abs() <= 2.0 * DISTANCE_ERROR * nearest,
            "{case}: {ray:?}, {hit:?}, nearest at {nearest}"
        );
    }
}

fn assert_same(case: &str, rays: &[Ray], expected: &[Option<Hit>], found: &[Option<Hit>]) {
    for (ray, (expected, found)) in rays.iter().zip(expected.iter().zip(found)) {
        let bits = |hit: &Option<Hit>| hit.map(|hit| (hit.t.to_bits(), hit.primitive, hit.is_back_face()));
        assert_eq!(bits(expected), bits(found), "{case}: {ray:?}");
    }
}

/// A closed box of 12 triangles that share corners, from `low` to `high`.
fn closed(low: [f32; 3], high: [f32; 3]) -> (Vec<[f32; 3]>, Vec<[u32; 3]>) {
    let cube = common::cube();
    let pick = |corner: &[f32; 3]| [0, 1, 2].map(|axis| if corner[axis] < 0.0 { low[axis] } else { high[axis] });
    (cube.positions().iter().map(pick).collect(), cube.triangles().to_vec())
}

/// From inside, through walls, edges and corners, and along the walls.
fn rays_inside(shape: &Shape, count: usize, random: &mut Random) -> Vec<Ray> {
    let corners = &shape.positions;
    let (low, high) = (corners[0], corners[7]);
    let between = |random: &mut Random| {
        [0, 1, 2].map(|axis| {
            let share = match random.below(6) {
                0 => random.unit() * 1e-4,
                1 => 1.0 - random.unit() * 1e-4,
                _ => random.unit(),
            };
            low[axis] + (high[axis] - low[axis]) * share
        })
    };
    (0..count)
        .map(|number| {
            let origin = between(random);
            let target = match number % 4 {
                0 => between(random),
                1 => corners[random.below(8)],
                2 => {
                    let [a, b, _] = shape.triangle(random.below(12));
                    let share = random.unit();
                    [0, 1, 2].map(|axis| a[axis] + (b[axis] - a[axis]) * share)
                }
                _ => {
                    let direction = random.direction();
                    [0, 1, 2].map(|axis| origin[axis] + direction[axis] * (high[axis] - low[axis]))
                }
            };
            Ray::new(origin, [0, 1, 2].map(|axis| target[axis] - origin[axis]))
        })
        .collect()
}

/// Tubes and boxes from 1 cm x 1 m to 1 m x 1000 km, in three directions, scales and offsets.
#[test]
fn closed_tubes_and_boxes_are_closed() {
    let per_shape = std::env::var("KINETREE_RAYS").ok().and_then(|rays| rays.parse().ok()).unwrap_or(1800);
    let mut tested = 0;
    for (width, length) in [(0.01_f32, 1.0_f32), (0.01, 1e3), (1.0, 1.0), (1.0, 1e4), (1.0, 1e5), (1.0, 1e6)] {
        for scale in [1e-6_f32, 1.0, 1e6] {
            for offset in [0.0_f32, 1.0, 1e3, 1e6] {
                for along in 0..3 {
                    let seed = tested as u64;
                    let (width, length) = (width * scale, length * scale);
                    let (mut low, mut high) = ([offset - width; 3], [offset + width; 3]);
                    (low[along], high[along]) = (offset, offset + length);
                    let ulps = width / (f32::EPSILON * (offset + length.max(width)));
                    // The tubes of long known trouble are thinner than what is promised.
                    if ulps < 50.0 || offset > 0.0 && ulps < 1000.0 {
                        continue;
                    }
                    let (positions, triangles) = closed(low, high);
                    let shape = Shape::new(positions, triangles, &[Quality::Fast]);
                    let case = format!("{width} x {length} at {offset} along {along}, seed {seed}");
                    let mut random = Random::new(seed);
                    for _ in 0..per_shape / 60 {
                        let rays = rays_inside(&shape, 60, &mut random);
                        shape.judge(&case, &rays);
                        tested += rays.len();
                    }
                }
            }
        }
    }
    assert!(tested >= 100_000 || per_shape < 1800, "{tested}");
    println!("{tested} rays");
}

/// A ray that passes the first triangle by 23 micrometres, across an edge of 10 km, meets the
/// second one behind it. Weights that are cut to zero before the distance is interpolated put the
/// hit at 1.98.
#[test]
fn the_distance_to_a_long_sliver_is_the_one_to_its_plane() {
    let positions = vec![[-1.0, -1.0, 0.0], [-1.0, 1.0, 1e4], [-1.0, 1.0, 0.0], [-1.0, -1.0, 1e4]];
    let shape = Shape::new(positions, vec![[0, 1, 2], [0, 3, 1]], &QUALITIES);
    let ray = Ray::new([-0.73255056, -0.88905156, 6064.6772], [-0.12834036, 0.5289329, 0.67851985]);
    shape.judge("a plane at x = -1", &[ray]);
    let hit = shape.views[0].1.closest_hit(&ray).unwrap();
    assert!(hit.primitive == 1 && (hit.t - 2.0839).abs() < 1e-4, "{hit:?}");
}

#[test]
fn a_sliver_whose_plane_lies_behind_the_ray_is_not_hit() {
    let positions = vec![
        [-1.0, 1.0, 0.0],
        [-1.0, 1.0, 1e5],
        [1.0, 1.0, 1e5],
        [-1.0, -1.0, 0.0],
        [1.0, -1.0, 0.0],
        [1.0, -1.0, 1e5],
    ];
    let shape = Shape::new(positions, vec![[0, 1, 2], [3, 4, 5]], &QUALITIES);
    let ray = Ray::new([-0.71970516, 0.67832696, 10136.273], [0.40267408, -0.46208763, 0.6626947]);
    shape.judge("a plane behind", &[ray]);
    assert!(shape.views.iter().all(|(_, view)| view.query().all_hits(&ray).iter().all(|hit| hit.primitive != 0)));
}

#[test]
fn a_ray_leaves_a_thin_tube_through_its_nearest_wall() {
    let (w, l) = (0.01, 1000.0);
    let positions = vec![[-w, -w, 0.0], [w, -w, 0.0], [w, -w, l], [w, w, l], [w, w, 0.0], [-w, -w, l]];
    let shape = Shape::new(positions, vec![[0, 1, 2], [1, 3, 2], [1, 4, 3], [0, 2, 5]], &QUALITIES);
    let ray = Ray::new([-0.0003084732, 0.005023509, 292.6369], [0.19629204, -0.28617084, -0.5244708]);
    shape.judge("a tube of 2 cm", &[ray]);
    assert!((shape.views[0].1.closest_hit(&ray).unwrap().t - 0.0525).abs() < 1e-4);
}

#[test]
fn the_smallest_slope_counts() {
    // In the plane of the triangle but for a step of 1e-42, and from a point below it.
    let positions = vec![[0.0, -1.0, 0.0], [1e30, 1e30, 0.0], [0.0, 1.0, 0.0], [0.0, 3.0, 0.0], [2.0, 3.0, 1e-42]];
    let shape = Shape::new(positions, vec![[0, 1, 2], [2, 3, 4]], &QUALITIES);
    let mut rays = Vec::new();
    for slope in [0.0, -0.0, 1e-42, -1e-42, 1e-45, 1e-30] {
        for height in [0.0, -1e-42, 1e-42, -1e-45, -1e-30, 1e-38] {
            for y in [0.5, 1.0, 2.0] {
                rays.push(Ray::new([-1.0, y, height], [1.0, -0.0, slope]));
                rays.push(Ray::new([0.5, y, height], [1.0, 1e-40, slope]));
            }
        }
    }
    shape.judge("denormal slopes", &rays);
}

/// Spheres squashed to plates and drawn out to needles, turned and moved before they are rounded:
/// most triangles are slivers, or seen from their edge.
#[test]
fn plates_and_needles_are_hit_where_they_are() {
    for seed in 0..24 {
        let mut random = Random::new(seed);
        let sphere = common::sphere(5, 8);
        let mut scale = [1.0; 3];
        scale[random.below(3)] = [1e-7, 1e-5, 1e-3, 1e3, 1e5][seed as usize % 5];
        let place = Affine::from_translation(random.point([0.0, 1.0, 1e4][seed as usize % 3]))
            * Affine::from_axis_angle(random.direction(), random.within(0.0, 6.0))
            * Affine::from_scale(scale);
        let positions: Vec<_> = sphere.positions().iter().map(|p| place.transform_point(*p)).collect();
        let shape = Shape::new(positions, sphere.triangles().to_vec(), &[Quality::Fastest, Quality::Best]);
        let rays: Vec<_> = (0..128)
            .map(|number| {
                let target = shape.positions[random.below(shape.positions.len())];
                let from = match number % 3 {
                    0 => shape.positions[random.below(shape.positions.len())],
                    1 => place.transform_point(random.point(1.0)),
                    _ => place.transform_point(random.point(50.0)),
                };
                let mut direction = [0, 1, 2].map(|axis| target[axis] - from[axis]);
                if number % 4 == 0 {
                    direction = random.direction();
                }
                Ray::new(from, direction)
            })
            .filter(|ray| ray.direction != [0.0; 3])
            .collect();
        shape.judge(&format!("seed {seed}"), &rays);
    }
}

#[test]
fn a_hit_at_either_end_of_its_range_is_found_again() {
    let mut random = Random::new(77);
    let sphere = common::sphere(12, 20);
    let view = placed(sphere, &[Affine::IDENTITY]);
    for _ in 0..20_000 {
        let (origin, direction) = (random.point(3.0), random.direction());
        let ray = Ray::new(origin, direction);
        for hit in view.query().all_hits(&ray) {
            let only = ray.with_range(hit.t, hit.t);
            let found = view.query().all_hits(&only);
            assert!(found.iter().any(|again| again.primitive == hit.primitive && again.t == hit.t), "{ray:?}: {hit:?}");
        }
    }
}
