//! Lofted skins over cross-sections, one half and its mirror image, for the bodies of cars.

use glam::{Affine3A, Vec2, Vec3};

use crate::meshing::Sketch;

/// The material and vertex colour of a cell of the skin, or `None` for a hole.
pub(crate) type CellMaterial = Option<(u32, [f32; 3])>;

/// Adds both halves of a skin. `stations` are values of z from the tail to the nose, `columns`
/// parameters in 0..=1 from the centre line down the left side; `point` gives a point of the left
/// half (x >= 0), `cell_material` the material of the cell with a centre. `uv` is called with the
/// point, the column, and the side: 1 at the left, -1 at the right.
pub(crate) fn skin(
    pad: &mut Sketch,
    stations: &[f32],
    columns: &[f32],
    point: impl Fn(f32, f32) -> Vec3,
    cell_material: impl Fn(f32, f32) -> CellMaterial,
    uv: impl Fn(Vec3, f32, f32) -> Vec2,
) {
    let width = columns.len() as u32;
    // All cells contribute to the normals, so that windows and holes leave no crease.
    let mut whole = Sketch::new(0);
    for &z in stations {
        for &column in columns {
            whole.vertex(point(z, column), Vec3::Y, Vec2::ZERO);
        }
    }
    for row in 0..stations.len() as u32 - 1 {
        for column in 0..width - 1 {
            let at = row * width + column;
            whole.quad(at + width, at + width + 1, at + 1, at);
        }
    }
    whole.smooth(0, &[]);
    for side in [1.0, -1.0] {
        let mirror = Affine3A::from_scale(Vec3::new(side, 1.0, 1.0));
        for row in 0..stations.len() - 1 {
            for column in 0..columns.len() - 1 {
                let middle =
                    [stations[row] + stations[row + 1], columns[column] + columns[column + 1]].map(|sum| 0.5 * sum);
                let Some((material, color)) = cell_material(middle[0], middle[1]) else { continue };
                pad.set_material(material, color);
                let corners =
                    [(row + 1, column), (row + 1, column + 1), (row, column + 1), (row, column)].map(|(r, c)| {
                        let index = r * columns.len() + c;
                        let (position, mut normal) = (whole.positions()[index], whole.normals()[index]);
                        if columns[c] <= 0.0 {
                            // The halves meet here, and share the normal.
                            normal = Vec3::new(0.0, normal.y, normal.z).normalize_or(normal);
                        }
                        let uv = uv(position, columns[c], side);
                        pad.vertex(mirror.transform_point3(position), mirror.transform_vector3(normal), uv)
                    });
                let [a, b, c, d] = corners;
                if side > 0.0 { pad.quad(a, b, c, d) } else { pad.quad(d, c, b, a) }
            }
        }
    }
}

/// A smooth curve through points, at a parameter in 0..=1 that is divided evenly between them
/// (Catmull and Rom 1974).
pub(crate) fn through(points: &[Vec2], parameter: f32) -> Vec2 {
    let last = points.len() - 1;
    let place = parameter.clamp(0.0, 1.0) * last as f32;
    let index = (place as usize).min(last - 1);
    let t = place - index as f32;
    let [b, c] = [points[index], points[index + 1]];
    let a = if index > 0 { points[index - 1] } else { b - (c - b) };
    let d = if index + 2 <= last { points[index + 2] } else { c + (c - b) };
    let (t2, t3) = (t * t, t * t * t);
    0.5 * (b * 2.0 + (c - a) * t + (a * 2.0 - b * 5.0 + c * 4.0 - d) * t2 + (b * 3.0 - a - c * 3.0 + d) * t3)
}
