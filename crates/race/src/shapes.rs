//! Shapes that several things are made of: sheets, boxes, tubes, lathes, balls.

use std::f32::consts::TAU;

use glam::{Affine3A, Vec2, Vec3};

use crate::meshing::Sketch;

impl Sketch {
    /// A sheet of `rows` times `columns` quads with smooth normals. `point` gives place and texture
    /// coordinates for row and column in 0..=1; the sheet is seen from outside when columns run
    /// to the right and rows upwards.
    pub(crate) fn sheet(&mut self, rows: u32, columns: u32, point: impl Fn(f32, f32) -> (Vec3, Vec2)) {
        let first = self.vertex_count();
        for row in 0..=rows {
            for column in 0..=columns {
                let (position, uv) = point(row as f32 / rows as f32, column as f32 / columns as f32);
                self.vertex(position, Vec3::Y, uv);
            }
        }
        let at = |row: u32, column: u32| first + row * (columns + 1) + column;
        for row in 0..rows {
            for column in 0..columns {
                self.quad(at(row, column), at(row, column + 1), at(row + 1, column + 1), at(row + 1, column));
            }
        }
        let closes = |a: u32, b: u32, pad: &Self| {
            pad.positions()[a as usize].distance_squared(pad.positions()[b as usize]) < 1e-10
        };
        let mut same = Vec::new();
        for row in 0..=rows {
            let [a, b] = [at(row, 0), at(row, columns)];
            if closes(a, b, self) {
                same.push([a, b]);
            }
        }
        for column in 0..=columns {
            let [a, b] = [at(0, column), at(rows, column)];
            if closes(a, b, self) {
                same.push([a, b]);
            }
        }
        self.smooth(first, &same);
    }

    /// A box from corner to corner, moved by a placement.
    pub(crate) fn cuboid(&mut self, low: Vec3, high: Vec3, placement: &Affine3A) {
        let corner = |x: bool, y: bool, z: bool| {
            let pick = |upper: bool, axis: usize| if upper { high[axis] } else { low[axis] };
            placement.transform_point3(Vec3::new(pick(x, 0), pick(y, 1), pick(z, 2)))
        };
        let (o, i) = (false, true);
        self.panel([corner(o, o, i), corner(i, o, i), corner(i, i, i), corner(o, i, i)]);
        self.panel([corner(i, o, o), corner(o, o, o), corner(o, i, o), corner(i, i, o)]);
        self.panel([corner(i, o, i), corner(i, o, o), corner(i, i, o), corner(i, i, i)]);
        self.panel([corner(o, o, o), corner(o, o, i), corner(o, i, i), corner(o, i, o)]);
        self.panel([corner(o, i, i), corner(i, i, i), corner(i, i, o), corner(o, i, o)]);
        self.panel([corner(o, o, o), corner(i, o, o), corner(i, o, i), corner(o, o, i)]);
    }

    /// A box between two points, `width` and `height` thick, its height as upright as can be.
    pub(crate) fn beam(&mut self, from: Vec3, to: Vec3, width: f32, height: f32) {
        let along = (to - from).normalize_or(Vec3::Z);
        let side = if along.y.abs() > 0.99 { Vec3::X } else { Vec3::Y.cross(along).normalize() };
        let up = along.cross(side);
        let placement = Affine3A::from_mat3_translation(glam::Mat3::from_cols(side, up, along), from);
        let half = Vec3::new(0.5 * width, 0.5 * height, 0.0);
        self.cuboid(-half, half + Vec3::Z * from.distance(to), &placement);
    }

    /// A pipe through points, with a radius at each; open at both ends.
    pub(crate) fn tube(&mut self, path: &[Vec3], radii: &[f32], sides: u32) {
        let last = path.len().saturating_sub(1);
        if last == 0 {
            return;
        }
        let frames: Vec<(Vec3, Vec3)> = (0..=last)
            .map(|i| {
                let along = (path[(i + 1).min(last)] - path[i.saturating_sub(1)]).normalize_or(Vec3::Y);
                let side = along.cross(if along.x.abs() < 0.9 { Vec3::X } else { Vec3::Z }).normalize();
                (side, along.cross(side))
            })
            .collect();
        self.sheet(last as u32, sides, |row, column| {
            let i = (row * last as f32).round() as usize;
            let (sine, cosine) = (column * TAU).sin_cos();
            let (side, front) = frames[i];
            (path[i] + (side * cosine + front * sine) * radii[i], Vec2::new(column, row))
        });
    }

    /// A profile of (radius, height) turned around the y axis, upwards on the outside. A point that
    /// stands in it twice makes a sharp edge.
    pub(crate) fn lathe(&mut self, profile: &[(f32, f32)], segments: u32, placement: &Affine3A) {
        let mut start = 0;
        while start + 1 < profile.len() {
            let mut end = start + 1;
            while end + 1 < profile.len() && profile[end] != profile[end + 1] {
                end += 1;
            }
            let piece = &profile[start..=end];
            let rows = piece.len() - 1;
            self.sheet(rows as u32, segments, |row, column| {
                let (radius, height) = piece[(row * rows as f32).round() as usize];
                let (sine, cosine) = (column * TAU).sin_cos();
                let position = Vec3::new(cosine * radius, height, -sine * radius);
                (placement.transform_point3(position), Vec2::new(column, 1.0 - row))
            });
            start = if end + 1 < profile.len() { end + 1 } else { end };
        }
    }

    /// An ellipsoid.
    pub(crate) fn ball(&mut self, center: Vec3, radii: Vec3, rows: u32, segments: u32) {
        self.sheet(rows, segments, |row, column| {
            let (height, ring) = (-(row * TAU * 0.5).cos(), (row * TAU * 0.5).sin());
            let (sine, cosine) = (column * TAU).sin_cos();
            (center + radii * Vec3::new(cosine * ring, height, -sine * ring), Vec2::new(column, 1.0 - row))
        });
    }
}
