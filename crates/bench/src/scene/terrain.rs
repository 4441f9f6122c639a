//! Hills with scattered spheres: large even triangles beside small ones, and a camera in the
//! middle.

use glam::Vec3;

use super::bench_scene::BenchScene;
use super::camera::PinholeCamera;
use super::shapes::sphere;

use crate::rng::Rng;
use crate::soup::Soup;

/// How often each edge of a sphere's octahedron is divided.
const CUTS: usize = 10;
/// Half the side of the terrain, metres.
const HALF: f32 = 100.0;
/// Octaves of noise.
const OCTAVES: u32 = 6;

/// About this many triangles, two thirds of them ground.
pub(crate) fn terrain(seed: u64, triangles: usize) -> BenchScene {
    let ground = Ground { seed };
    let mut soup = Soup::default();
    let cells = ((triangles as f64 / 3.0).sqrt().round() as usize).max(1);
    let coordinate = |i: usize| HALF * (2.0 * i as f32 / cells as f32 - 1.0);
    let points = (0..=cells).flat_map(|z| (0..=cells).map(move |x| (x, z)));
    let positions: Vec<Vec3> = points.map(|(x, z)| ground.at(coordinate(x), coordinate(z))).collect();
    let corner = |x: usize, z: usize| (z * (cells + 1) + x) as u32;
    let faces: Vec<[u32; 3]> = (0..cells * cells)
        .flat_map(|cell| {
            let (x, z) = (cell % cells, cell / cells);
            let [a, b, c, d] = [corner(x, z), corner(x + 1, z), corner(x, z + 1), corner(x + 1, z + 1)];
            [[a, c, b], [b, c, d]]
        })
        .collect();
    soup.add(positions, &faces);

    let (ball, faces) = sphere(CUTS);
    let mut rng = Rng::new(seed, 3);
    for _ in 0..triangles / 3 / faces.len() {
        let radius = rng.between(0.3, 2.5);
        let middle = ground.at(rng.between(-HALF, HALF), rng.between(-HALF, HALF)) + Vec3::Y * radius * 0.6;
        soup.add(ball.iter().map(|p| middle + *p * radius), &faces);
    }
    let camera = ground.at(-62.0, -55.0) + Vec3::Y * 9.0;
    BenchScene { soup, camera: PinholeCamera::look_at(camera, ground.at(10.0, 15.0), 0.6) }
}

/// Value noise: random heights on a grid, smoothly interpolated, summed over octaves.
struct Ground {
    seed: u64,
}

impl Ground {
    /// The point of the ground at these coordinates.
    fn at(&self, x: f32, z: f32) -> Vec3 {
        let height: f32 = (0..OCTAVES)
            .map(|octave| {
                let cell = 48.0 / (1 << octave) as f32;
                self.noise(octave, x / cell, z / cell) * cell * 0.35
            })
            .sum();
        Vec3::new(x, height, z)
    }

    fn noise(&self, octave: u32, x: f32, z: f32) -> f32 {
        let (column, row) = (x.floor(), z.floor());
        let height = |right: f32, down: f32| {
            let [x, z] = [(column + right) as i64, (row + down) as i64].map(|i| (i + (1 << 20)) as u64);
            Rng::new(self.seed, u64::from(octave) << 48 | x << 24 | z).uniform()
        };
        let smooth = |t: f32| t * t * (3.0 - 2.0 * t);
        let mix = |a: f32, b: f32, t: f32| a + (b - a) * t;
        let (across, along) = (smooth(x - column), smooth(z - row));
        mix(mix(height(0.0, 0.0), height(1.0, 0.0), across), mix(height(0.0, 1.0), height(1.0, 1.0), across), along)
    }
}
