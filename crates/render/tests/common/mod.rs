//! Small scenes for tests, and ways to measure them.
#![allow(dead_code, reason = "every test file uses its own part")]

use std::f32::consts::PI;
use std::ops::ControlFlow;

use kinetree::{Affine, Mesh, Motion, Scene};
use kinetree_render::{IntegratorKind, Rendered, Settings, render};
use kinetree_world::{Camera, Frame, Light, Material, MaterialBindings, MaterialSet, Sky, Surface};

/// Triangles with texture coordinates.
#[derive(Clone, Default)]
pub(crate) struct Shape {
    pub(crate) positions: Vec<[f32; 3]>,
    pub(crate) triangles: Vec<[u32; 3]>,
    pub(crate) normals: Option<Vec<[f32; 3]>>,
    pub(crate) uvs: Vec<[f32; 2]>,
}

impl Shape {
    /// A unit square in y = 0 from -0.5 to 0.5, facing up; (0, 0) of the texture is at -x, -z.
    pub(crate) fn square() -> Self {
        Self {
            positions: vec![[-0.5, 0.0, -0.5], [-0.5, 0.0, 0.5], [0.5, 0.0, 0.5], [0.5, 0.0, -0.5]],
            triangles: vec![[0, 1, 2], [0, 2, 3]],
            normals: None,
            uvs: vec![[0.0, 0.0], [0.0, 1.0], [1.0, 1.0], [1.0, 0.0]],
        }
    }

    /// A cube from -1 to 1 that faces outwards.
    pub(crate) fn cube() -> Self {
        let mut shape = Self::default();
        for axis in 0..3 {
            for side in [-1.0_f32, 1.0] {
                let base = shape.positions.len() as u32;
                for [u, v] in [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]] {
                    let mut corner = [0.0; 3];
                    corner[axis] = side;
                    corner[(axis + 1) % 3] = u * side;
                    corner[(axis + 2) % 3] = v;
                    shape.positions.push(corner);
                    shape.uvs.push([u * 0.5 + 0.5, v * 0.5 + 0.5]);
                }
                shape.triangles.extend([[base, base + 1, base + 2], [base, base + 2, base + 3]]);
            }
        }
        shape
    }

    /// A unit sphere of `2 rows^2` triangles or so, faceted.
    pub(crate) fn sphere(rows: u32) -> Self {
        let columns = 2 * rows;
        let mut shape = Self::default();
        for row in 0..=rows {
            for column in 0..=columns {
                let (theta, phi) = (PI * row as f32 / rows as f32, 2.0 * PI * column as f32 / columns as f32);
                shape.positions.push([theta.sin() * phi.cos(), theta.cos(), -theta.sin() * phi.sin()]);
                shape.uvs.push([column as f32 / columns as f32, row as f32 / rows as f32]);
            }
        }
        for row in 0..rows {
            for column in 0..columns {
                let a = row * (columns + 1) + column;
                let b = a + columns + 1;
                shape.triangles.extend([[a, b, b + 1], [a, b + 1, a + 1]]);
            }
        }
        shape
    }

    /// Normals as those of a sphere around the origin.
    pub(crate) fn smooth(mut self) -> Self {
        self.normals = Some(self.positions.clone());
        self
    }

    /// Turned inside out.
    pub(crate) fn inverted(mut self) -> Self {
        for triangle in &mut self.triangles {
            triangle.swap(1, 2);
        }
        self
    }

    /// With all positions moved, so that the object itself has large coordinates.
    pub(crate) fn moved(mut self, by: [f32; 3], scale: f32) -> Self {
        for position in &mut self.positions {
            *position = std::array::from_fn(|axis| position[axis] * scale + by[axis]);
        }
        self
    }
}

/// A scene under construction.
#[derive(Default)]
pub(crate) struct Model {
    scene: Option<Scene>,
    pub(crate) material_set: MaterialSet,
    pub(crate) material_bindings: MaterialBindings,
    pub(crate) lights: Vec<Light>,
    pub(crate) sky: Sky,
}

impl Model {
    pub(crate) fn under(sky: f32) -> Self {
        Self { sky: Sky::Constant([sky; 3]), ..Self::default() }
    }

    /// Adds a shape of one material.
    pub(crate) fn with(self, shape: &Shape, material: Material, placement: Affine) -> Self {
        self.with_moving(shape, material, placement, Motion::Static)
    }

    pub(crate) fn with_moving(mut self, shape: &Shape, material: Material, placement: Affine, motion: Motion) -> Self {
        let scene = self.scene.get_or_insert_with(Scene::new);
        let mut mesh = Mesh::new(&shape.positions, &shape.triangles).expect("a good mesh");
        if let Some(normals) = &shape.normals {
            mesh = mesh.with_normals(normals).expect("good normals");
        }
        let mesh = scene.add_mesh(mesh, motion).expect("a mesh fits");
        let instance = scene.add_instance(scene.root(), mesh, placement).expect("an instance fits");
        self.material_bindings.bind(instance, self.material_set.surfaces.len() as u32);
        let id = self.material_set.materials.len() as u32;
        self.material_set.materials.push(material);
        self.material_set.surfaces.push(Surface { uvs: shape.uvs.clone(), ..Surface::of(id) });
        self
    }

    pub(crate) fn lit_by(mut self, light: Light) -> Self {
        self.lights.push(light);
        self
    }

    pub(crate) fn frame(mut self) -> Frame {
        let mut scene = self.scene.unwrap_or_default();
        let frame = Frame::new(scene.commit());
        let mut frame = frame.with_materials(self.material_set.into(), &mut self.material_bindings);
        (frame.lights, frame.sky) = (self.lights, self.sky);
        frame
    }
}

/// A picture of so many pixels and samples.
pub(crate) fn settings(kind: IntegratorKind, size: u32, spp: u32) -> Settings {
    Settings { width: size, height: size, spp, integrator: kind, ..Settings::default() }
}

/// Renders a picture, and asserts that no sample was lost.
pub(crate) fn picture(frame: &Frame, camera: &Camera, settings: &Settings) -> Rendered {
    let picture = render(frame, camera, settings, &|_| ControlFlow::Continue(())).expect("good settings");
    assert_eq!(picture.lost_samples, 0);
    assert!(picture.film.pixels().iter().flatten().all(|channel| channel.is_finite() && *channel >= 0.0));
    picture
}

/// A mean with its standard error.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Estimate {
    pub(crate) mean: f64,
    /// Standard error.
    pub(crate) error: f64,
}

impl Estimate {
    /// From independent values.
    pub(crate) fn of(values: &[f64]) -> Self {
        let count = values.len() as f64;
        let mean = values.iter().sum::<f64>() / count;
        let variance = values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / (count - 1.0);
        Self { mean, error: (variance / count).sqrt() }
    }

    /// Asserts that the estimate agrees with a true value to within five standard errors, and that
    /// these are less than a fraction of it. Beside the noise, single precision may round by
    /// [`ROUNDING`].
    #[track_caller]
    pub(crate) fn assert_is(&self, truth: f64, within: f64, what: &str) {
        let leeway = 5.0 * self.error + ROUNDING * truth.abs() + 1e-9;
        assert!(leeway < within * truth.abs() + 2e-9, "{what}: too noisy to tell: {self:?} for {truth}");
        assert!((self.mean - truth).abs() < leeway, "{what}: {self:?} instead of {truth}");
    }
}

/// Relative error by which a picture without noise may be off.
const ROUNDING: f64 = 2e-5;

/// The radiance along one line of sight, in one channel: a picture with a tiny field of view, whose
/// pixels are independent.
pub(crate) fn glimpse(
    frame: &Frame,
    eye: [f32; 3],
    target: [f32; 3],
    kind: IntegratorKind,
    spp: u32,
    channel: usize,
) -> Estimate {
    let film = picture(frame, &Camera::look_at(eye, target, 1.1e-3), &settings(kind, 8, spp)).film;
    Estimate::of(&film.pixels().iter().map(|pixel| f64::from(pixel[channel])).collect::<Vec<_>>())
}

/// The view factor of a parallel rectangle from a point straight below one of its corners, with
/// sides `a` and `b` in units of the height; irradiance over radiance is pi times that.
pub(crate) fn corner_factor(a: f64, b: f64) -> f64 {
    let (x, y) = ((1.0 + a * a).sqrt(), (1.0 + b * b).sqrt());
    (a / x * (b / x).atan() + b / y * (a / y).atan()) / (2.0 * std::f64::consts::PI)
}

/// A placement by scale, then a turn about an axis, then a move.
pub(crate) fn placed(scale: [f32; 3], axis: [f32; 3], angle: f32, position: [f32; 3]) -> Affine {
    Affine::from_translation(position) * Affine::from_axis_angle(axis, angle) * Affine::from_scale(scale)
}
