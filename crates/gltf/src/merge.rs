//! From the primitives of a mesh to one list of vertices and one of triangles.

use kinetree::{MorphTarget, Skin};
use kinetree_world::{Part, Surface};

use crate::error::Item;
use crate::geometry::Geometry;
use crate::influences::FIRST_JOINT;
use crate::notes::Notes;
use crate::vertices::Vertices;

/// A primitive: triangles among the vertices of a set.
pub(crate) struct IndexedPrimitive {
    pub(crate) set: usize,
    pub(crate) triangles: Vec<[u32; 3]>,
    pub(crate) material: u32,
}

/// One mesh of all primitives: the remaining vertex sets, one after the other. Those after the
/// first `sets_of_file` are flat.
pub(crate) fn merged(
    vertex_sets: Vec<Option<Vertices>>,
    sets_of_file: usize,
    primitives: &[IndexedPrimitive],
    target_count: usize,
    item: &Item,
    notes: &mut Notes,
) -> Geometry {
    let mut first_vertex = Vec::with_capacity(vertex_sets.len());
    let mut count = 0;
    for set in &vertex_sets {
        first_vertex.push(count as u32);
        count += set.as_ref().map_or(0, Vertices::count);
    }
    let flat_from = first_vertex.get(sets_of_file).map_or(count, |&first| first as usize);
    let mut vertex_sets: Vec<Vertices> = vertex_sets.into_iter().flatten().collect();
    let mut triangles = Vec::with_capacity(primitives.iter().map(|primitive| primitive.triangles.len()).sum());
    let mut parts: Vec<Part> = Vec::new();
    for primitive in primitives {
        if parts.last().is_none_or(|last| last.material != primitive.material) {
            parts.push(Part { first_triangle: triangles.len() as u32, material: primitive.material });
        }
        let first = first_vertex[primitive.set];
        triangles.extend(primitive.triangles.iter().map(|triangle| triangle.map(|vertex| vertex + first)));
    }
    if vertex_sets.iter().any(|set| set.skin.is_some()) && vertex_sets.iter().any(|set| set.skin.is_none()) {
        notes.add(|| format!("{item}: the primitives without joints follow the first joint"));
    }
    let counts: Vec<usize> = vertex_sets.iter().map(Vertices::count).collect();
    let positions =
        concatenated(vertex_sets.iter_mut().map(|set| Some(std::mem::take(&mut set.positions))), &counts, [0.0; 3]);
    let positions = positions.unwrap_or_default();
    let mut normals = concatenated(vertex_sets.iter_mut().map(|set| set.normals.take()), &counts, [0.0; 3]);
    if let Some(normals) = &mut normals {
        let repaired = crate::normals::repair(normals, &positions, &triangles);
        if repaired > 0 {
            notes.add(|| format!("{item}: {repaired} normals without a direction are replaced"));
        }
    }
    let uvs = concatenated(vertex_sets.iter_mut().map(|set| set.uvs.take()), &counts, [0.0; 2]).unwrap_or_default();
    let colors =
        concatenated(vertex_sets.iter_mut().map(|set| set.colors.take()), &counts, [1.0; 4]).unwrap_or_default();
    let joints = vertex_sets.iter_mut().map(|set| set.skin.as_mut().map(|skin| std::mem::take(&mut skin.joints)));
    let joints = concatenated(joints, &counts, FIRST_JOINT.0);
    let weights = vertex_sets.iter_mut().map(|set| set.skin.as_mut().map(|skin| std::mem::take(&mut skin.weights)));
    let weights = concatenated(weights, &counts, FIRST_JOINT.1);
    let skin = joints.zip(weights).map(|(joints, weights)| Skin { joints, weights });
    let targets = targets(&mut vertex_sets, target_count, &counts, normals.is_some());
    Geometry { positions, normals, flat_from, triangles, skin, targets, surface: Surface { parts, uvs, colors } }
}

/// A primitive that has fewer targets than another is not moved by those that it lacks.
fn targets(
    vertex_sets: &mut [Vertices],
    target_count: usize,
    counts: &[usize],
    with_normals: bool,
) -> Vec<MorphTarget> {
    (0..target_count)
        .map(|i| {
            let positions = vertex_sets.iter_mut().map(|set| set.targets.get_mut(i)?.positions.take());
            let positions = concatenated(positions, counts, [0.0; 3]);
            let normals = vertex_sets.iter_mut().map(|set| set.targets.get_mut(i)?.normals.take());
            let normals = concatenated(normals, counts, [0.0; 3]).filter(|_| with_normals);
            MorphTarget {
                positions: positions.unwrap_or_else(|| vec![[0.0; 3]; counts.iter().sum()]),
                normals: normals.unwrap_or_default(),
            }
        })
        .collect()
}

/// The parts one after the other, with a value in place of what a part lacks; `None` if there is no
/// part at all.
fn concatenated<T: Copy>(parts: impl Iterator<Item = Option<Vec<T>>>, counts: &[usize], fill: T) -> Option<Vec<T>> {
    let mut parts: Vec<_> = parts.collect();
    if parts.iter().all(Option::is_none) {
        return None;
    }
    if let [only] = &mut parts[..] {
        return only.take();
    }
    let mut all = Vec::with_capacity(counts.iter().sum());
    for (part, &count) in parts.into_iter().zip(counts) {
        match part {
            Some(part) => all.extend_from_slice(&part),
            None => all.resize(all.len() + count, fill),
        }
    }
    Some(all)
}
