//! Meshes: the primitives of each, one after the other, as one list of vertices and one of
//! triangles.

use std::collections::BTreeMap;

use kinetree::{Mesh, MeshError, MorphTarget, Skin};
use kinetree_world::{Part, Surface};

use crate::accessor::Accessors;
use crate::budget::Budget;
use crate::document::Document;
use crate::error::{Item, Problem};
use crate::influences::FIRST_JOINT;
use crate::json::{ElementType, Mode, Primitive, Semantic};
use crate::material::Materials;
use crate::notes::Notes;
use crate::triangles::triangles;
use crate::vertices::{Sources, Vertices};

/// A mesh of the file. Always: all arrays that are there have one element per vertex, and indices
/// are in range.
pub(crate) struct Geometry {
    pub(crate) positions: Vec<[f32; 3]>,
    pub(crate) normals: Option<Vec<[f32; 3]>>,
    /// The vertices from here on belong to triangles that have no normals in the file: they are
    /// flat in every pose.
    flat_from: usize,
    pub(crate) triangles: Vec<[u32; 3]>,
    pub(crate) skin: Option<Skin>,
    /// As many as [`Document::target_count`] says.
    pub(crate) targets: Vec<MorphTarget>,
    pub(crate) surface: Surface,
}

impl Geometry {
    /// The mesh in its rest state, or as one that can be posed; then normals of flat triangles are
    /// zero.
    pub(crate) fn mesh(&self, skinned: bool, morphed: bool) -> Result<Mesh, MeshError> {
        let mut mesh = Mesh::new(&self.positions, &self.triangles)?;
        if let Some(normals) = &self.normals {
            let flat_from = if skinned || morphed { self.flat_from } else { normals.len() };
            let mut normals = normals.clone();
            // A normal of the rest pose is wrong in other poses: zero stands for the normal of the
            // triangle.
            normals[flat_from..].fill([0.0; 3]);
            mesh = mesh.with_normals(&normals)?;
        }
        if let Some(skin) = self.skin.as_ref().filter(|_| skinned) {
            mesh = mesh.with_skin(skin.clone())?;
        }
        if morphed {
            mesh = mesh.with_morph_targets(self.targets.clone())?;
        }
        Ok(mesh)
    }

    /// The highest joint that any vertex follows.
    pub(crate) fn highest_joint(&self) -> Option<u16> {
        self.skin.as_ref()?.joints.iter().flatten().copied().max()
    }

    /// How many numbers a copy of it holds.
    pub(crate) fn numbers(&self) -> u64 {
        let per_vertex = 6 + 8 * u64::from(self.skin.is_some()) + 6 * self.targets.len() as u64;
        self.positions.len() as u64 * per_vertex + 3 * self.triangles.len() as u64
    }
}

/// Reads meshes.
pub(crate) struct Meshes<'a> {
    pub(crate) document: &'a Document,
    pub(crate) accessors: &'a Accessors<'a>,
    pub(crate) budget: &'a Budget,
}

/// A primitive: triangles among the vertices of a set.
struct IndexedPrimitive {
    set: usize,
    triangles: Vec<[u32; 3]>,
    material: u32,
}

impl Meshes<'_> {
    /// Reads a mesh; `None` if it has no triangles.
    pub(crate) fn read(
        &self,
        index: usize,
        materials: &mut Materials<'_>,
        notes: &mut Notes,
    ) -> Result<Option<Geometry>, Problem> {
        let item = self.document.mesh_item(index);
        let mesh = &self.document.root.meshes[index];
        // Primitives with the same attributes share their vertices.
        let mut vertex_sets: Vec<Option<Vertices>> = Vec::new();
        let mut known: BTreeMap<Sources, usize> = BTreeMap::new();
        let mut primitives = Vec::new();
        for (number, primitive) in mesh.primitives.iter().enumerate() {
            let Some(mode) = Mode::of(primitive.mode) else {
                return Err(item.invalid(format!("has an unknown mode in primitive {number}")));
            };
            if matches!(mode, Mode::Points | Mode::Lines | Mode::LineLoop | Mode::LineStrip) {
                notes.ignored(&format!("a primitive of {mode:?}"), "only triangles are shown", Some(&item));
                continue;
            }
            if primitive.attributes.get(Semantic::Positions).is_none() {
                notes.add(|| format!("{item}: primitive {number} has no positions, and is left out"));
                continue;
            }
            let [joints, weights] = [Semantic::Joints(0), Semantic::Weights(0)];
            if primitive.attributes.get(joints).is_some() != primitive.attributes.get(weights).is_some() {
                notes.ignored(
                    "one of joints and weights without the other",
                    "nothing moves these vertices",
                    Some(&item),
                );
            }
            let sources = Sources::of(primitive, self.coordinate_set(primitive));
            let set = match known.get(&sources) {
                Some(&set) => set,
                None => {
                    vertex_sets.push(Some(sources.read(self.accessors, &item, notes)?));
                    known.insert(sources, vertex_sets.len() - 1);
                    vertex_sets.len() - 1
                }
            };
            let count = vertex_sets[set].as_ref().map_or(0, Vertices::count);
            let triangles = self.triangles(primitive, mode, count, &item)?;
            if !triangles.is_empty() {
                let material = materials.index_of(primitive.material, &item, notes)?;
                primitives.push(IndexedPrimitive { set, triangles, material });
            }
        }
        let sets_of_file = vertex_sets.len();
        self.give_all_normals(&mut vertex_sets, &mut primitives, &item)?;
        // Attributes that only some primitives have are filled with zeros for the others.
        let vertices: u64 = vertex_sets.iter().flatten().map(|set| set.count() as u64).sum();
        let targets = self.document.target_count(index);
        self.budget.spend_numbers(vertices.saturating_mul(crate::vertices::numbers_per_vertex(targets)), &item)?;
        Ok((!primitives.is_empty()).then(|| merged(vertex_sets, sets_of_file, &primitives, targets, &item, notes)))
    }

    fn coordinate_set(&self, primitive: &Primitive) -> u32 {
        let material = primitive.material.and_then(|index| self.document.root.materials.get(index.value()));
        material.map_or(0, crate::material::coordinate_set_of)
    }

    fn triangles(
        &self,
        primitive: &Primitive,
        mode: Mode,
        vertices: usize,
        item: &Item,
    ) -> Result<Vec<[u32; 3]>, Problem> {
        let indices: Vec<u32> = match primitive.indices {
            Some(indices) => self.accessors.integers::<1>(indices, ElementType::Scalar, item)?.into_flattened(),
            None => {
                self.budget.spend_numbers(vertices as u64, item)?;
                (0..vertices as u32).collect()
            }
        };
        if let Some(&highest) = indices.iter().max().filter(|&&highest| highest as usize >= vertices) {
            return Err(item.invalid(format!("has a triangle at vertex {highest}, but {vertices} vertices")));
        }
        // Strips have nearly three times as many corners as indices.
        self.budget.spend_numbers(3 * indices.len() as u64, item)?;
        Ok(triangles(mode, &indices).unwrap_or_default())
    }

    /// If some vertex sets have normals, gives the others the normals of their faces; then every
    /// triangle has vertices of its own.
    fn give_all_normals(
        &self,
        vertex_sets: &mut Vec<Option<Vertices>>,
        primitives: &mut [IndexedPrimitive],
        item: &Item,
    ) -> Result<(), Problem> {
        let lacking: Vec<bool> = vertex_sets.iter().flatten().map(|set| set.normals.is_none()).collect();
        if lacking.iter().all(|&lacks| lacks) {
            return Ok(());
        }
        for primitive in primitives.iter_mut().filter(|primitive| lacking[primitive.set]) {
            let Some(set) = &vertex_sets[primitive.set] else { continue };
            let corners = 3 * primitive.triangles.len() as u64;
            self.budget
                .spend_numbers(corners.saturating_mul(crate::vertices::numbers_per_vertex(set.targets.len())), item)?;
            let flat = set.flat(&primitive.triangles);
            primitive.triangles =
                (0..primitive.triangles.len() as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
            primitive.set = vertex_sets.len();
            vertex_sets.push(Some(flat));
        }
        for (set, _) in vertex_sets.iter_mut().zip(lacking).filter(|(_, lacks)| *lacks) {
            *set = None;
        }
        Ok(())
    }
}

/// One mesh of all primitives: the remaining vertex sets, one after the other. Those after the
/// first `sets_of_file` are flat.
fn merged(
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
