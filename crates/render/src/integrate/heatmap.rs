//! The cost of camera rays: nodes visited and triangles tested, as colours from black over blue and
//! red to white.

use glam::Vec3;
use kinetree::{Ray, Work};

use super::Integrator;
use crate::{Sampler, Tracer};

/// The work per camera ray as a colour. The scale is the same for all pictures, so that they can be
/// compared.
#[derive(Debug, Clone, Copy)]
pub struct Heatmap;

/// The work, nodes and triangles together, that gets the last colour. The scale is logarithmic.
const MAX_WORK: f32 = 1024.0;

/// Colours from no work to the most, linear RGB.
const RAMP: [[f32; 3]; 6] =
    [[0.0, 0.0, 0.01], [0.01, 0.02, 0.3], [0.3, 0.0, 0.3], [0.9, 0.05, 0.02], [1.0, 0.6, 0.0], [1.0, 1.0, 0.9]];

impl Integrator for Heatmap {
    fn radiance(&self, tracer: &mut Tracer<'_>, ray: &Ray, _: &mut Sampler) -> [f32; 3] {
        let mut work = Work::default();
        // Only the work is needed, not the hit.
        let _ = tracer.closest_hit_counted(ray, &mut work);
        color(work.nodes + work.triangles)
    }

    fn is_display_ready(&self) -> bool {
        true
    }
}

fn color(work: u64) -> [f32; 3] {
    let heat = ((1.0 + work as f32).ln() / (1.0 + MAX_WORK).ln()).min(1.0) * (RAMP.len() - 1) as f32;
    let step = (heat as usize).min(RAMP.len() - 2);
    Vec3::from(RAMP[step]).lerp(RAMP[step + 1].into(), heat - step as f32).into()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_scale_runs_from_its_first_colour_to_its_last() {
        assert_eq!(color(0), RAMP[0]);
        assert!((Vec3::from(color(1024)) - Vec3::from(RAMP[5])).length() < 1e-5);
        assert_eq!(color(u64::MAX), RAMP[5]);
        assert!(color(100)[0] > color(10)[0]);
    }
}
