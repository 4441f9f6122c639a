//! Worlds and rays that the tests share.

#![allow(dead_code, unreachable_pub, reason = "each test uses its part")]

pub mod exact;

use std::collections::HashMap;

use kinetree::build::Quality;
use kinetree::{Affine, Executor, Mesh, Motion, Ray, Scene, Snapshot};

/// Small, fast, and the same everywhere: Steele, Lea and Flood 2014, "Fast Splittable Pseudorandom
/// Number Generators".
pub struct Random(u64);

impl Random {
    pub fn new(seed: u64) -> Self {
        Self(seed)
    }

    pub fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ z >> 30).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ z >> 27).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ z >> 31
    }

    /// In 0..1.
    pub fn unit(&mut self) -> f32 {
        (self.bits() >> 40) as f32 / (1 << 24) as f32
    }

    /// In low..high.
    pub fn within(&mut self, low: f32, high: f32) -> f32 {
        low + (high - low) * self.unit()
    }

    pub fn below(&mut self, count: usize) -> usize {
        (self.bits() % count as u64) as usize
    }

    pub fn point(&mut self, size: f32) -> [f32; 3] {
        [0; 3].map(|_| self.within(-size, size))
    }

    /// Roughly uniform over directions.
    pub fn direction(&mut self) -> [f32; 3] {
        loop {
            let v = self.point(1.0);
            let length = v.iter().map(|x| x * x).sum::<f32>().sqrt();
            if length > 0.1 && length < 1.0 {
                return v.map(|x| x / length);
            }
        }
    }

    pub fn placement(&mut self, size: f32) -> Affine {
        let mirror = if self.unit() < 0.3 { -1.0 } else { 1.0 };
        let scale = [self.within(0.3, 2.0) * mirror, self.within(0.3, 2.0), self.within(0.3, 2.0)];
        Affine::from_translation(self.point(size))
            * Affine::from_axis_angle(self.direction(), self.within(0.0, 6.0))
            * Affine::from_scale(scale)
    }

    pub fn soup(&mut self, triangles: usize, spread: f32, size: f32) -> Mesh {
        let mut positions = Vec::new();
        for _ in 0..triangles {
            let center = self.point(spread);
            for _ in 0..3 {
                let corner = self.point(size);
                positions.push([0, 1, 2].map(|axis| center[axis] + corner[axis]));
            }
        }
        let indices: Vec<u32> = (0..positions.len() as u32).collect();
        Mesh::new(&positions, &indices).unwrap()
    }
}

/// A closed sphere of `2 * rings * segments` triangles, some of them degenerate at the poles.
pub fn sphere(rings: u32, segments: u32) -> Mesh {
    let mut positions = Vec::new();
    for ring in 0..=rings {
        let polar = std::f32::consts::PI * ring as f32 / rings as f32;
        for segment in 0..segments {
            let around = std::f32::consts::TAU * segment as f32 / segments as f32;
            positions.push([polar.sin() * around.cos(), polar.cos(), polar.sin() * around.sin()]);
        }
    }
    // Closed for certain: all of a pole is the same point.
    positions[..segments as usize].fill([0.0, 1.0, 0.0]);
    positions[(rings * segments) as usize..].fill([0.0, -1.0, 0.0]);
    let mut triangles = Vec::new();
    for ring in 0..rings {
        for segment in 0..segments {
            let next = (segment + 1) % segments;
            let at = |ring: u32, segment: u32| ring * segments + segment;
            triangles.push([at(ring, segment), at(ring, next), at(ring + 1, segment)]);
            triangles.push([at(ring, next), at(ring + 1, next), at(ring + 1, segment)]);
        }
    }
    Mesh::new(&positions, &triangles).unwrap()
}

/// A flat grid of `n * n` quads between the corners (0, 0, 0) and (size, 0, size).
pub fn grid(n: u32, size: f32) -> Mesh {
    let mut positions = Vec::new();
    for z in 0..=n {
        for x in 0..=n {
            positions.push([x as f32 / n as f32 * size, 0.0, z as f32 / n as f32 * size]);
        }
    }
    let mut triangles = Vec::new();
    for z in 0..n {
        for x in 0..n {
            let at = z * (n + 1) + x;
            triangles.push([at, at + n + 1, at + 1]);
            triangles.push([at + 1, at + n + 1, at + n + 2]);
        }
    }
    Mesh::new(&positions, &triangles).unwrap()
}

/// A cube of 12 triangles, from -1 to 1.
pub fn cube() -> Mesh {
    let positions: Vec<[f32; 3]> =
        (0..8).map(|i| [i & 1, i >> 1 & 1, i >> 2].map(|bit| bit as f32 * 2.0 - 1.0)).collect();
    let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let triangles: Vec<[u32; 3]> = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    Mesh::new(&positions, &triangles).unwrap()
}

pub fn alone(mesh: Mesh) -> Snapshot {
    placed(mesh, &[Affine::IDENTITY])
}

pub fn placed(mesh: Mesh, placements: &[Affine]) -> Snapshot {
    let mut scene = Scene::new();
    let mesh = scene.add_mesh(mesh, Motion::Static).unwrap();
    for placement in placements {
        scene.add_instance(scene.root(), mesh, *placement).unwrap();
    }
    scene.commit()
}

fn scaled(mesh: &Mesh, factor: f32) -> Mesh {
    let positions: Vec<_> = mesh.positions().iter().map(|p| p.map(|x| x * factor)).collect();
    Mesh::new(&positions, mesh.triangles()).unwrap()
}

/// A name, a frame, and about how large it is (for aiming rays).
pub struct World {
    pub name: String,
    pub view: Snapshot,
    pub size: f32,
}

/// Awkward ones first.
pub fn worlds(seed: u64) -> Vec<World> {
    let mut random = Random::new(seed);
    let mut worlds = Vec::new();
    let mut add = |name: &str, view: Snapshot, size: f32| worlds.push(World { name: name.into(), view, size });
    add("nothing", Scene::new().commit(), 1.0);
    add("an empty mesh", alone(Mesh::empty()), 1.0);
    add("one triangle", alone(Mesh::new(&[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], &[0_u16, 1, 2]).unwrap()), 1.0);
    let same = [[0.0, 0.0, 0.0], [1.0, 0.2, 0.1], [0.3, 1.0, -0.4]];
    add("all in the same place", alone(Mesh::new(&same, &vec![[0_u32, 1, 2]; 100]).unwrap()), 1.0);
    let coincident: Vec<_> = (0..40_u32).map(|i| [i % 2 * 3, i % 2 * 3 + 1, i % 2 * 3 + 2]).collect();
    let turned = [same, [same[1], same[2], same[0]]].concat();
    add("coincident, turned", alone(Mesh::new(&turned, &coincident).unwrap()), 1.0);
    add("coincident instances", placed(sphere(6, 9), &[Affine::IDENTITY; 5]), 1.0);
    add("points and lines", alone(Mesh::new(&same, &[[0, 0, 0], [0, 1, 1], [1, 2, 1], [0, 1, 2]]).unwrap()), 1.0);
    add("flat", alone(grid(12, 2.0)), 2.0);
    add("tiny", alone(scaled(&sphere(9, 14), 1e-6)), 1e-6);
    add("huge", alone(scaled(&sphere(9, 14), 1e15)), 1e15);
    add("a cube", alone(cube()), 1.0);
    let far = Affine::from_translation([8000.0, -3000.0, 5000.0]);
    add("far away", placed(sphere(9, 14), &[far]), 1.0e4);
    let teapot = [Affine::IDENTITY, Affine::from_scale([3000.0; 3]), Affine::from_scale([1e-3; 3])];
    add("teapot in a stadium", placed(sphere(12, 20), &teapot), 2.0);
    add("soup", alone(random.soup(700, 3.0, 0.6)), 3.0);
    add("thin and long", alone(random.soup(60, 0.5, 8.0)), 5.0);
    for (count, spread) in [(5, 2.0), (60, 6.0), (700, 20.0)] {
        let placements: Vec<_> = (0..count).map(|_| random.placement(spread)).collect();
        let mesh = if count > 100 { cube() } else { random.soup(80, 1.0, 0.4) };
        add(&format!("{count} instances"), placed(mesh, &placements), spread);
    }
    worlds
}

/// Runs the jobs one after the other, the second one first.
pub struct Backwards;

impl Executor for Backwards {
    fn join(&self, one: &mut (dyn FnMut() + Send), other: &mut (dyn FnMut() + Send)) {
        other();
        one();
    }
}

pub const QUALITIES: [Quality; 4] = [Quality::Fastest, Quality::Fast, Quality::Balanced, Quality::Best];

/// The same world, with trees of another quality. Instances have masks with one of the bits 0 to 2,
/// and every other one is opaque.
pub fn rebuilt(world: &World, quality: Quality) -> World {
    let mut scene = Scene::new();
    let mut meshes = HashMap::new();
    for view in world.view.instances() {
        let mesh = *meshes.entry(view.mesh_id()).or_insert_with(|| {
            let mesh = Mesh::new(view.positions(), view.triangles()).unwrap().with_quality(quality);
            scene.add_mesh(mesh, Motion::Static).unwrap()
        });
        let instance = scene.add_instance(scene.root(), mesh, *view.world_from_object()).unwrap();
        scene.set_mask(instance, 1 << (view.index() % 3)).unwrap();
        scene.set_opaque(instance, view.index() % 2 == 1).unwrap();
    }
    World { name: format!("{}, {quality:?}", world.name), view: scene.commit(), size: world.size }
}

/// Rays of many kinds: random, axis-parallel, grazing, at vertices, edges and centres, from
/// vertices, in faces.
pub fn rays(world: &World, count: usize, random: &mut Random) -> Vec<Ray> {
    let corners: Vec<[f32; 3]> = world
        .view
        .instances()
        .flat_map(|view| {
            let place = *view.world_from_object();
            view.triangles().iter().take(200).flat_map(move |triangle| {
                triangle.map(|vertex| place.transform_point(view.positions()[vertex as usize]))
            })
        })
        .collect();
    let size = world.size;
    (0..count)
        .map(|i| {
            let origin = random.point(size * 2.0);
            let target = if corners.is_empty() {
                random.point(size)
            } else {
                let triangle = random.below(corners.len() / 3) * 3;
                let [a, b, c] = [corners[triangle], corners[triangle + 1], corners[triangle + 2]];
                let (u, v) = match i % 5 {
                    0 => (0.0, 0.0),
                    1 => (random.unit(), 0.0),
                    _ => (random.unit() * 0.5, random.unit() * 0.5),
                };
                [0, 1, 2].map(|axis| a[axis] + (b[axis] - a[axis]) * u + (c[axis] - a[axis]) * v)
            };
            let towards = |from: [f32; 3]| [0, 1, 2].map(|axis| target[axis] - from[axis]);
            match i % 11 {
                0..=4 => Ray::new(origin, towards(origin)),
                5 => Ray::new(origin, random.direction()),
                6 => {
                    let mut from = target;
                    from[i % 3] -= size * 3.0;
                    Ray::new(from, towards(from))
                }
                7 => {
                    let mut direction = [0.0; 3];
                    direction[random.below(3)] = if random.unit() < 0.5 { -1.0 } else { 1.0 };
                    Ray::new(target, direction)
                }
                8 => Ray::new(target, random.direction()),
                9 => Ray::new(origin, towards(origin)).with_range(random.unit(), random.within(0.5, 1.5)),
                _ => {
                    // Nearly parallel to an axis.
                    let mut direction = random.direction().map(|x| x * 1e-6);
                    direction[random.below(3)] = 1.0;
                    Ray::new([0, 1, 2].map(|axis| target[axis] - direction[axis] * size), direction)
                }
            }
        })
        .collect()
}

/// Rays through a tile of a picture, some of them with bounds, some through vertices.
pub fn tile(world: &World, random: &mut Random, count: usize) -> Vec<Ray> {
    let size = world.size;
    let eye = random.point(size * 2.5);
    let aims = rays(world, 1, random);
    let target = if random.unit() < 0.5 { [0.0; 3] } else { aims[0].at(1.0) };
    let ahead = [0, 1, 2].map(|axis| target[axis] - eye[axis]);
    let spread = [0.02, 0.3, 3.0][random.below(3)] * size;
    let (right, up) = (random.direction(), random.direction());
    (0..count)
        .map(|at| {
            let (x, y) = ((at % 8) as f32 / 8.0 - 0.4, (at / 8 % 8) as f32 / 8.0 - 0.4);
            let direction = [0, 1, 2].map(|axis| ahead[axis] + (right[axis] * x + up[axis] * y) * spread);
            let ray = Ray::new(eye, direction);
            if random.unit() < 0.2 { ray.with_range(random.unit(), random.within(0.5, 1.5)) } else { ray }
        })
        .collect()
}
