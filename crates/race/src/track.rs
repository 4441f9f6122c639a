//! The centre line of the circuit: its course, curvature and banking.
//!
//! A closed uniform cubic B-spline, which has continuous curvature, tabulated by arc length. The
//! circuit runs anticlockwise as seen from above; y is up, all lengths are metres.

use glam::Vec3;

/// Half the width of the asphalt.
pub(crate) const HALF_WIDTH: f32 = 5.6;
/// Entries of the table.
const STATIONS: usize = 4096;
/// The spline's control points: the start straight, the banked corner, the esses, the hairpin, and
/// back to the start.
#[rustfmt::skip]
const CONTROL: [[f32; 3]; 23] = [
    [-90.0, 0.0, 78.0], [-45.0, 0.0, 78.0], [0.0, 0.0, 78.0], [45.0, 0.2, 78.0], [90.0, 0.6, 79.0],
    [133.0, 1.0, 76.0], [166.0, 1.6, 54.0], [178.0, 2.0, 18.0], [164.0, 2.2, -18.0], [130.0, 2.0, -37.0],
    [96.0, 1.8, -30.0], [68.0, 2.6, -12.0], [38.0, 3.4, -18.0], [14.0, 4.0, -46.0], [-18.0, 3.6, -60.0],
    [-62.0, 2.2, -54.0], [-108.0, 1.4, -58.0], [-138.0, 1.2, -42.0], [-136.0, 1.0, -12.0], [-108.0, 0.6, 0.0],
    [-114.0, 0.4, 26.0], [-150.0, 0.0, 44.0], [-138.0, 0.0, 77.0],
];

/// The circuit.
pub(crate) struct Track {
    /// Evenly spread along the lap.
    stations: Vec<Station>,
    length: f32,
}

/// The road at one distance.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Station {
    /// A point of the centre line.
    pub(crate) middle: Vec3,
    /// Unit vector along the road.
    pub(crate) forward: Vec3,
    /// Unit vector to the left of a driver, horizontal.
    pub(crate) left: Vec3,
    /// 1/m, positive where the road turns left, smoothed over some metres.
    pub(crate) curvature: f32,
    /// How much the surface falls per metre to the left: the tangent of the banking.
    pub(crate) fall: f32,
}

impl Station {
    /// The point of the surface at an offset to the left of the centre line.
    pub(crate) fn at(&self, offset: f32) -> Vec3 {
        self.middle + self.left * offset - Vec3::Y * (self.fall * offset)
    }

    /// Unit vector to the left, within the surface.
    pub(crate) fn across(&self) -> Vec3 {
        (self.left - Vec3::Y * self.fall).normalize()
    }
}

impl Track {
    /// Tabulates the spline.
    pub(crate) fn new() -> Self {
        let fine = 256 * CONTROL.len();
        let mut lengths = vec![0.0f64];
        for i in 0..fine {
            let step = spline(i as f32 / fine as f32).distance(spline((i + 1) as f32 / fine as f32));
            lengths.push(lengths[i] + f64::from(step));
        }
        let length = lengths[fine];
        let middle: Vec<Vec3> = (0..STATIONS)
            .map(|i| {
                let wanted = length * i as f64 / STATIONS as f64;
                let after = lengths.partition_point(|&reached| reached <= wanted).min(fine);
                let part = (wanted - lengths[after - 1]) / (lengths[after] - lengths[after - 1]);
                spline(((after - 1) as f64 + part) as f32 / fine as f32)
            })
            .collect();
        let around = |i: usize, by: usize| [middle[(i + STATIONS - by) % STATIONS], middle[(i + by) % STATIONS]];
        let spacing = length as f32 / STATIONS as f32;
        let raw: Vec<f32> = (0..STATIONS)
            .map(|i| {
                let [before, after] = around(i, 8);
                let (a, b) = (middle[i] - before, after - middle[i]);
                // To the left is towards -z when going along +x.
                let turn = (a.z * b.x - a.x * b.z).atan2(a.x * b.x + a.z * b.z);
                turn / (8.0 * spacing)
            })
            .collect();
        let curvature = smoothed(&raw, (5.0 / spacing) as usize);
        let fall: Vec<f32> = curvature.iter().map(|&k| (k * 11.0).clamp(-0.21, 0.21)).collect();
        let fall = smoothed(&fall, (9.0 / spacing) as usize);
        let stations = (0..STATIONS)
            .map(|i| {
                let [before, after] = around(i, 2);
                let forward = (after - before).normalize();
                let left = Vec3::Y.cross(forward).normalize();
                Station { middle: middle[i], forward, left, curvature: curvature[i], fall: fall[i] }
            })
            .collect();
        Self { stations, length: length as f32 }
    }

    /// Length of a lap, metres.
    pub(crate) fn length(&self) -> f32 {
        self.length
    }

    /// The road at a distance from the first station, modulo the lap.
    pub(crate) fn at(&self, distance: f32) -> Station {
        let place = (distance / self.length).rem_euclid(1.0) * STATIONS as f32;
        let index = place as usize % STATIONS;
        let (a, b) = (&self.stations[index], &self.stations[(index + 1) % STATIONS]);
        let part = place.fract();
        Station {
            middle: a.middle.lerp(b.middle, part),
            forward: a.forward.lerp(b.forward, part).normalize(),
            left: a.left.lerp(b.left, part).normalize(),
            curvature: a.curvature + (b.curvature - a.curvature) * part,
            fall: a.fall + (b.fall - a.fall) * part,
        }
    }

    /// Evenly spaced stations with their distances; the last one is a step before the first.
    pub(crate) fn places(&self, count: usize) -> impl Iterator<Item = (f32, Station)> {
        (0..count).map(move |i| {
            let distance = self.length * i as f32 / count as f32;
            (distance, self.at(distance))
        })
    }

    /// The distance of the station nearest to a point, as seen from above, and how far to the left
    /// of it the point is.
    pub(crate) fn nearest(&self, x: f32, z: f32) -> (f32, f32) {
        let squared = |station: &Station| (station.middle.x - x).powi(2) + (station.middle.z - z).powi(2);
        let coarse = (0..STATIONS)
            .step_by(16)
            .min_by(|&a, &b| squared(&self.stations[a]).total_cmp(&squared(&self.stations[b])));
        let coarse = coarse.unwrap_or(0) + STATIONS;
        let best = (coarse - 16..=coarse + 16)
            .map(|i| i % STATIONS)
            .min_by(|&a, &b| squared(&self.stations[a]).total_cmp(&squared(&self.stations[b])));
        let index = best.unwrap_or(0);
        let station = &self.stations[index];
        let away = Vec3::new(x - station.middle.x, 0.0, z - station.middle.z);
        let flat_forward = Vec3::new(station.forward.x, 0.0, station.forward.z).normalize();
        let distance = self.length * index as f32 / STATIONS as f32 + away.dot(flat_forward);
        (distance, away.dot(station.left))
    }
}

/// The spline at a parameter in 0..=1.
fn spline(parameter: f32) -> Vec3 {
    let count = CONTROL.len();
    let place = parameter.rem_euclid(1.0) * count as f32;
    let (index, t) = (place as usize, place.fract());
    let [a, b, c, d] = std::array::from_fn(|i| Vec3::from(CONTROL[(index + i) % count]));
    let weights = [
        (1.0 - t).powi(3),
        3.0 * t.powi(3) - 6.0 * t * t + 4.0,
        -3.0 * t.powi(3) + 3.0 * t * t + 3.0 * t + 1.0,
        t.powi(3),
    ];
    (a * weights[0] + b * weights[1] + c * weights[2] + d * weights[3]) / 6.0
}

/// The mean over `reach` entries to both sides, twice, around a closed table.
pub(crate) fn smoothed(table: &[f32], reach: usize) -> Vec<f32> {
    let once = |table: &[f32]| -> Vec<f32> {
        let count = table.len();
        let at = |i: usize| f64::from(table[i % count]);
        let mut sum: f64 = (0..=2 * reach).map(|i| at(i + count - reach % count)).sum();
        (0..count)
            .map(|i| {
                let mean = sum / (2 * reach + 1) as f64;
                sum += at(i + reach + 1) - at(i + count - reach);
                mean as f32
            })
            .collect()
    };
    once(&once(table))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distances_are_metres_along_the_road() {
        let track = Track::new();
        for i in 0..400 {
            let distance = track.length() * i as f32 / 400.0;
            let step = track.at(distance).middle.distance(track.at(distance + 0.5).middle);
            assert!((step - 0.5).abs() < 0.005, "at {distance}: {step}");
        }
        assert!(track.at(0.0).middle.distance(track.at(track.length()).middle) < 1e-2);
    }

    #[test]
    fn the_nearest_place_is_where_it_was_left() {
        let track = Track::new();
        for (distance, station) in track.places(97) {
            for offset in [-6.0, 0.0, 4.5] {
                let point = station.middle + station.left * offset;
                let (found, side) = track.nearest(point.x, point.z);
                let apart = (found - distance + 0.5 * track.length()).rem_euclid(track.length()) - 0.5 * track.length();
                assert!(apart.abs() < 0.3 && (side - offset).abs() < 0.05, "{distance}, {offset}: {found}, {side}");
            }
        }
    }

    #[test]
    fn one_lap_turns_once_to_the_left() {
        let track = Track::new();
        let turn: f32 = track.places(2000).map(|(_, station)| station.curvature * track.length() / 2000.0).sum();
        assert!((turn - std::f32::consts::TAU).abs() < 0.02, "{turn}");
    }

    #[test]
    fn corners_are_banked_to_their_inside() {
        let track = Track::new();
        let steepest = track.places(500).map(|(_, station)| station.fall.abs()).fold(0.0, f32::max);
        assert!(steepest > 0.15, "{steepest}");
        for (distance, station) in track.places(500) {
            assert!(station.curvature.abs() < 0.01 || station.fall * station.curvature > 0.0, "at {distance}");
        }
    }
}
