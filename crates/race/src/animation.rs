//! The animation of the race: everything that moves.

use kinetree::{EditError, Scene};
use kinetree_world::Animation;

use crate::cameras::Panning;
use crate::cars::Car;
use crate::crowd::{Jumper, cheer};
use crate::driving::{Driving, LAP};
use crate::flag::Flag;
use crate::forest::Swaying;
use crate::smoke::Smoke;

/// Everything that moves.
pub(crate) struct Race {
    pub(crate) driving: Driving,
    pub(crate) cars: [Car; 2],
    pub(crate) trees: Vec<Swaying>,
    pub(crate) flags: Vec<Flag>,
    pub(crate) smoke: Smoke,
    pub(crate) jumpers: Vec<Jumper>,
    pub(crate) panning: Panning,
}

impl Animation for Race {
    fn go_to(&mut self, scene: &mut Scene, seconds: f64) -> Result<(), EditError> {
        let seconds = if seconds.is_finite() { seconds.rem_euclid(LAP) } else { 0.0 };
        for (index, car) in self.cars.iter().enumerate() {
            car.go_to(scene, &self.driving, index, seconds)?;
        }
        self.trees.iter().try_for_each(|tree| tree.go_to(scene, seconds))?;
        self.flags.iter().try_for_each(|flag| flag.go_to(scene, seconds))?;
        self.smoke.go_to(scene, &self.driving, seconds)?;
        self.panning.go_to(scene, &self.driving, seconds)?;
        cheer(scene, &self.jumpers, seconds)
    }

    fn duration(&self) -> f64 {
        LAP
    }
}
