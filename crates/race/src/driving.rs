//! The state of the two cars at any time: a pure function of the time.
//!
//! Both follow one speed profile, slow in corners and fast on straights, on lines of their own and
//! slightly apart in time, so that they never touch.

use std::f32::consts::TAU;

use glam::{Affine3A, Mat3, Vec3};

use crate::car::{HALF_TRACK, HUB, WHEELBASE};
use crate::track::{Station, Track, smoothed};

/// Duration of a lap, seconds, after which everything repeats.
pub(crate) const LAP: f64 = 20.0;
/// Entries of the tables.
const STEPS: usize = 4096;
/// Position of the first car at time 0, x and z: in the banked corner.
const START: [f32; 2] = [165.6, -4.2];

/// The curvature, 1/m, from which on the tyres of each car slide.
const SLIDES_FROM: [f32; 2] = [0.024, 0.0145];

/// The motion of the two cars around the circuit.
pub(crate) struct Driving {
    track: Track,
    /// Seconds at which the speed profile passes each of `STEPS` stations, evenly spaced from the
    /// first one.
    passes: Vec<f64>,
    /// Distance at time zero.
    start: f32,
    /// Offset to the left of the centre line at each station, for each car.
    lines: [Vec<f32>; 2],
    /// Metres that each car has driven since time zero at each of `STEPS` times, and after the lap.
    driven: [Vec<f64>; 2],
}

/// The state of a car at one time. World space, metres, radians.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Moment {
    /// From car space: on the road, upright on its banking.
    pub(crate) world_from_car: Affine3A,
    /// Metres per second.
    pub(crate) velocity: Vec3,
    /// Steering angle, positive to the left.
    pub(crate) steer: f32,
    /// Angle by which the wheels have turned.
    pub(crate) roll: f32,
    /// Roll of the body to the right, and pitch of its nose downwards.
    pub(crate) lean: f32,
    pub(crate) dive: f32,
    /// Slip of the tyres: 0 when they grip, about 1 at most.
    pub(crate) slide: f32,
}

impl Driving {
    /// Computes the lap.
    pub(crate) fn new() -> Self {
        let track = Track::new();
        let stations: Vec<Station> = track.places(STEPS).map(|(_, station)| station).collect();
        let spacing = track.length() / STEPS as f32;
        let reach = |metres: f32| (metres / spacing) as usize;
        let grip: Vec<f32> = stations
            .iter()
            .map(|station| (15.0 / (station.curvature.abs() + 0.002)).sqrt().clamp(17.0, 64.0))
            .collect();
        let speeds = smoothed(&grip, reach(20.0));
        let mut passes = vec![0.0];
        for i in 0..STEPS {
            passes.push(passes[i] + f64::from(spacing / speeds[i]));
        }
        let total = passes[STEPS];
        passes.iter_mut().for_each(|pass| *pass *= LAP / total);
        let line = |gain: f32, shift: f32, limit: f32| -> Vec<f32> {
            let raw: Vec<f32> =
                stations.iter().map(|station| (station.curvature * gain).clamp(-limit, limit) + shift).collect();
            smoothed(&raw, reach(9.0))
        };
        let lines = [line(150.0, 0.4, 2.8), line(90.0, -0.9, 1.9)];
        let start = track.nearest(START[0], START[1]).0;
        let mut driving = Self { track, passes, start, lines, driven: [Vec::new(), Vec::new()] };
        for car in 0..2 {
            let at = |step: usize| driving.position(car, LAP * step as f64 / STEPS as f64);
            let mut driven = vec![0.0];
            for step in 0..STEPS {
                driven.push(driven[step] + f64::from(at(step).distance(at(step + 1))));
            }
            driving.driven[car] = driven;
        }
        driving
    }

    /// The circuit.
    pub(crate) fn track(&self) -> &Track {
        &self.track
    }

    /// Distance along the road, and offset to the left of the centre line.
    pub(crate) fn place(&self, car: usize, seconds: f64) -> (f32, f32) {
        // The gap of the second car grows and shrinks once a lap; it is small at time 0.
        let behind = [0.0, 0.42 - 0.08 * (seconds / LAP * f64::from(TAU)).cos()][car];
        let spacing = f64::from(self.track.length()) / STEPS as f64;
        let first = f64::from(self.start) / spacing;
        let index = first as usize % STEPS;
        let offset = self.passes[index] + (self.passes[index + 1] - self.passes[index]) * first.fract();
        let time = (seconds - behind + offset).rem_euclid(LAP);
        let after = self.passes.partition_point(|&pass| pass <= time).clamp(1, STEPS);
        let part = (time - self.passes[after - 1]) / (self.passes[after] - self.passes[after - 1]);
        let (a, b) = (self.lines[car][after - 1], self.lines[car][after % STEPS]);
        (((after - 1) as f64 + part) as f32 * spacing as f32, a + (b - a) * part as f32)
    }

    fn position(&self, car: usize, seconds: f64) -> Vec3 {
        let (distance, offset) = self.place(car, seconds);
        self.track.at(distance).at(offset)
    }

    fn forward(&self, car: usize, seconds: f64) -> Vec3 {
        (self.position(car, seconds + 0.03) - self.position(car, seconds - 0.03)).normalize()
    }

    fn speed(&self, car: usize, seconds: f64) -> f32 {
        self.position(car, seconds + 0.05).distance(self.position(car, seconds - 0.05)) / 0.1
    }

    /// Metres driven since time zero; within one lap.
    pub(crate) fn driven(&self, car: usize, seconds: f64) -> f64 {
        let place = (seconds / LAP).rem_euclid(1.0) * STEPS as f64;
        let index = (place as usize).min(STEPS - 1);
        let table = &self.driven[car];
        table[index] + (table[index + 1] - table[index]) * (place - index as f64)
    }

    /// Radius at which the wheels roll: within a thousandth of their own, so that a lap is a whole
    /// number of turns and the loop has no seam.
    pub(crate) fn rolling_radius(&self, car: usize) -> f64 {
        let turn = std::f64::consts::TAU;
        let turns = (self.driven[car][STEPS] / (turn * f64::from(HUB))).round();
        self.driven[car][STEPS] / (turn * turns)
    }

    /// The point of the road above or below a point.
    fn on_road(&self, point: Vec3) -> Vec3 {
        let (distance, offset) = self.track.nearest(point.x, point.z);
        Vec3::new(point.x, self.track.at(distance).at(offset).y, point.z)
    }

    /// The car at a time.
    pub(crate) fn moment(&self, car: usize, seconds: f64) -> Moment {
        let (distance, offset) = self.place(car, seconds);
        let station = self.track.at(distance);
        let heading = self.forward(car, seconds);
        let level = frame(heading, station.across(), station.at(offset));
        // The road is twisted where its banking changes, so the car is placed by the road below its
        // four wheels.
        let ground =
            |x: f32, z: f32| self.on_road(level.transform_point3(Vec3::new(x * HALF_TRACK, 0.0, z * 0.5 * WHEELBASE)));
        let [fl, fr, rl, rr] = [ground(1.0, 1.0), ground(-1.0, 1.0), ground(1.0, -1.0), ground(-1.0, -1.0)];
        let world_from_car = frame(fl + fr - rl - rr, fl + rl - fr - rr, (fl + fr + rl + rr) / 4.0);
        let speed = self.speed(car, seconds);
        let (before, after) = (self.forward(car, seconds - 0.06), self.forward(car, seconds + 0.06));
        // Positive to the left, as seen from above.
        let turn = (before.z * after.x - before.x * after.z).atan2(before.x * after.x + before.z * after.z);
        let curvature = turn / (0.12 * speed);
        let gain = (self.speed(car, seconds + 0.2) - self.speed(car, seconds - 0.2)) / 0.4;
        Moment {
            world_from_car,
            velocity: heading * speed,
            steer: (WHEELBASE * curvature).atan(),
            roll: (self.driven(car, seconds) / self.rolling_radius(car)) as f32,
            lean: (speed * speed * curvature * 0.0013).clamp(-0.03, 0.03),
            dive: (-gain * 0.0016).clamp(-0.02, 0.02),
            slide: ((station.curvature.abs() - SLIDES_FROM[car]) / 0.012).clamp(0.0, 1.0),
        }
    }
}

/// The placement of a car from its forward and left directions, which are about perpendicular.
fn frame(forward: Vec3, left: Vec3, origin: Vec3) -> Affine3A {
    let up = forward.cross(left).normalize();
    let forward = forward.normalize();
    Affine3A::from_mat3_translation(Mat3::from_cols(up.cross(forward), up, forward), origin)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::track::HALF_WIDTH;

    fn times() -> impl Iterator<Item = f64> {
        (0..400).map(|i| LAP * f64::from(i) / 400.0)
    }

    #[test]
    fn all_wheels_stay_on_the_asphalt() {
        let driving = Driving::new();
        for car in 0..2 {
            for time in times() {
                let moment = driving.moment(car, time);
                for (x, z) in [(0.95, 2.2), (-0.95, 2.2), (0.95, -2.2), (-0.95, -2.2)] {
                    let corner = moment.world_from_car.transform_point3(Vec3::new(x, 0.0, z));
                    let (_, offset) = driving.track().nearest(corner.x, corner.z);
                    assert!(offset.abs() < HALF_WIDTH, "car {car} at {time}: {offset}");
                }
            }
        }
    }

    #[test]
    fn wheels_touch_the_road() {
        let driving = Driving::new();
        for car in 0..2 {
            for time in times() {
                let moment = driving.moment(car, time);
                for (x, z) in [(0.8, 1.35), (-0.8, 1.35), (0.8, -1.35), (-0.8, -1.35)] {
                    let contact = moment.world_from_car.transform_point3(Vec3::new(x, 0.0, z));
                    let (distance, offset) = driving.track().nearest(contact.x, contact.z);
                    let gap = contact.y - driving.track().at(distance).at(offset).y;
                    assert!(gap.abs() < 0.04, "car {car} at {time}: {gap}");
                }
            }
        }
    }

    #[test]
    fn the_cars_never_touch() {
        let driving = Driving::new();
        for time in times() {
            let [a, b] = [0, 1].map(|car| driving.moment(car, time).world_from_car);
            let local = a.inverse().transform_point3(b.translation.into());
            assert!(local.z.abs() > 4.9 || local.x.abs() > 2.2, "at {time}: {local}");
        }
    }

    #[test]
    fn wheels_roll_as_far_as_the_car_drives() {
        let driving = Driving::new();
        for car in 0..2 {
            for time in times().take(399) {
                let step = 0.01;
                let [a, b] = [time, time + step].map(|time| driving.moment(car, time));
                let driven = a.world_from_car.translation.distance(b.world_from_car.translation);
                let rolled = (b.roll - a.roll) * HUB;
                assert!((rolled - driven).abs() < 0.02 * driven + 0.002, "car {car} at {time}: {rolled} and {driven}");
            }
            assert!((driving.rolling_radius(car) / f64::from(HUB) - 1.0).abs() < 2e-3);
        }
    }

    #[test]
    fn wheels_are_turned_into_the_corner() {
        let driving = Driving::new();
        for time in times() {
            let (distance, _) = driving.place(0, time);
            let curvature = driving.track().at(distance).curvature;
            let steer = driving.moment(0, time).steer;
            if curvature.abs() > 0.02 {
                assert!(steer * curvature > 0.0, "at {time}: {steer}, {curvature}");
            }
            assert!(steer.abs() < 0.5, "at {time}: {steer}");
        }
    }
}
