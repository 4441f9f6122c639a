//! Reading the primitives of meshes.

use std::collections::BTreeMap;

use crate::accessor::Accessors;
use crate::budget::Budget;
use crate::document::Document;
use crate::error::{Item, Problem};
use crate::geometry::Geometry;
use crate::json::{ElementType, Mode, Primitive, Semantic};
use crate::material::Materials;
use crate::merge::{IndexedPrimitive, merged};
use crate::notes::Notes;
use crate::triangles::triangles;
use crate::vertices::{Sources, Vertices};

/// Reads meshes.
pub(crate) struct Meshes<'a> {
    pub(crate) document: &'a Document,
    pub(crate) accessors: &'a Accessors<'a>,
    pub(crate) budget: &'a Budget,
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
