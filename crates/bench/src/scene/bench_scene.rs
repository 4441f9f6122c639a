//! A scene ready to be measured.

use super::camera::PinholeCamera;
use crate::ray::{Answer, Ray};
use crate::soup::Soup;

/// Triangles and a camera.
pub(crate) struct BenchScene {
    /// The triangles, world space.
    pub(crate) soup: Soup,
    /// The camera of the primary rays.
    pub(crate) camera: PinholeCamera,
}

/// Preview rays along a side of the picture, which measure how much of it shows something.
const PREVIEW_SIDE: usize = 24;
/// The part of the picture that should show something.
const LEAST_COVERAGE: f32 = 0.6;
/// How often the view is narrowed at most, and by which factor each time.
const STEPS: usize = 16;
const NARROWING: f32 = 0.8;

impl BenchScene {
    /// A scene with a camera outside that shows all of it.
    pub(super) fn with_default_camera(soup: Soup) -> Self {
        Self { camera: PinholeCamera::frame(&soup), soup }
    }

    /// Narrows the angle of view until most of the picture shows something, or as far as that
    /// helps: rays that leave the scene at once measure nothing.
    pub(crate) fn narrow_view(&mut self, trace: &dyn Fn(&Soup, &[Ray]) -> Vec<Answer>) {
        let seen = |camera: &PinholeCamera| {
            let rays = preview_rays(camera);
            trace(&self.soup, &rays).iter().filter(|answer| answer.is_hit()).count() as f32 / rays.len() as f32
        };
        let mut best = (seen(&self.camera), self.camera);
        let mut camera = self.camera;
        for _ in 0..STEPS {
            if best.0 >= LEAST_COVERAGE {
                break;
            }
            camera = PinholeCamera { right: camera.right * NARROWING, up: camera.up * NARROWING, ..camera };
            let part = seen(&camera);
            if part > best.0 {
                best = (part, camera);
            }
        }
        self.camera = best.1;
    }
}

fn preview_rays(camera: &PinholeCamera) -> Vec<Ray> {
    let coordinate = |i: usize| (2 * i + 1) as f32 / PREVIEW_SIDE as f32 - 1.0;
    let pixels =
        (0..PREVIEW_SIDE * PREVIEW_SIDE).map(|at| (coordinate(at % PREVIEW_SIDE), coordinate(at / PREVIEW_SIDE)));
    pixels
        .map(|(x, y)| Ray::new(camera.position, (camera.forward + camera.right * x - camera.up * y).normalize()))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::super::shapes;
    use super::*;
    use crate::engine::Reference;

    #[test]
    fn a_camera_that_sees_little_is_narrowed() {
        let (ball, faces) = shapes::sphere(8);
        let mut soup = Soup::default();
        soup.add(ball, &faces);
        let mut scene = BenchScene::with_default_camera(soup);
        let reference = Reference::of(&scene.soup).unwrap();
        let far = scene.camera.right.length();
        scene.camera = PinholeCamera { right: scene.camera.right * 4.0, up: scene.camera.up * 4.0, ..scene.camera };
        scene.narrow_view(&|soup, rays| reference.closest(soup, rays));
        assert!(scene.camera.right.length() < 4.0 * far);
        let seen = reference.closest(&scene.soup, &preview_rays(&scene.camera));
        let hits = seen.iter().filter(|answer| answer.is_hit()).count();
        assert!(hits as f32 >= LEAST_COVERAGE * seen.len() as f32, "{hits}");
    }
}
