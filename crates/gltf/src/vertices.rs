//! The vertices of a primitive, as its attributes give them.

use kinetree::Skin;

use crate::accessor::Accessors;
use crate::error::{Item, Problem};
use crate::influences;
use crate::json::{Accessor, ElementType, Index, Primitive, Semantic};
use crate::normals::face_normal;
use crate::notes::Notes;

/// Which accessors the vertices of a primitive come from. Equal sources give equal vertices.
#[derive(PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Sources {
    positions: Option<Index<Accessor>>,
    normals: Option<Index<Accessor>>,
    uvs: Option<Index<Accessor>>,
    colors: Option<Index<Accessor>>,
    influences: Vec<influences::Set>,
    /// Displacements of positions and of normals.
    targets: Vec<[Option<Index<Accessor>>; 2]>,
}

/// Vertices, with those attributes that they have. Always: as many of each attribute as there are
/// positions.
pub(crate) struct Vertices {
    pub(crate) positions: Vec<[f32; 3]>,
    pub(crate) normals: Option<Vec<[f32; 3]>>,
    pub(crate) uvs: Option<Vec<[f32; 2]>>,
    pub(crate) colors: Option<Vec<[f32; 4]>>,
    pub(crate) skin: Option<Skin>,
    pub(crate) targets: Vec<Displacements>,
}

/// What a morph target adds to positions and normals.
pub(crate) struct Displacements {
    pub(crate) positions: Option<Vec<[f32; 3]>>,
    pub(crate) normals: Option<Vec<[f32; 3]>>,
}

impl Sources {
    pub(crate) fn of(primitive: &Primitive, coordinate_set: u32) -> Self {
        let attribute = |semantic| primitive.attributes.get(semantic);
        let influences = |set| attribute(Semantic::Joints(set)).zip(attribute(Semantic::Weights(set)));
        let targets = primitive.targets.iter().flatten();
        Self {
            positions: attribute(Semantic::Positions),
            normals: attribute(Semantic::Normals),
            uvs: attribute(Semantic::TexCoords(coordinate_set)),
            colors: attribute(Semantic::Colors(0)),
            influences: (0..).map_while(influences).collect(),
            targets: targets.map(|target| [target.positions, target.normals]).collect(),
        }
    }

    pub(crate) fn read(&self, accessors: &Accessors<'_>, item: &Item, notes: &mut Notes) -> Result<Vertices, Problem> {
        let vectors = |index| accessors.floats::<3>(index, ElementType::Vec3, item);
        let positions = self.positions.map(vectors).transpose()?.unwrap_or_default();
        if let Some(vertex) = first_non_finite(&positions) {
            return Err(item.invalid(format!("has a vertex, {vertex}, whose position is not finite")));
        }
        let count = positions.len();
        let normals = self.normals.map(vectors).transpose()?;
        let mut uvs = self.uvs.map(|index| accessors.floats::<2>(index, ElementType::Vec2, item)).transpose()?;
        let mut colors = self.colors.map(|index| colors(accessors, index, item)).transpose()?;
        for (what, length) in [
            ("normals", normals.as_ref().map(Vec::len)),
            ("texture coordinates", uvs.as_ref().map(Vec::len)),
            ("colours", colors.as_ref().map(Vec::len)),
        ] {
            if let Some(length) = length.filter(|&length| length != count) {
                return Err(item.invalid(format!("has {count} positions and {length} {what} in one primitive")));
            }
        }
        let repaired = uvs.as_mut().map_or(0, |uvs| replace_non_finite(uvs, 0.0))
            + colors.as_mut().map_or(0, |c| replace_non_finite(c, 1.0));
        if repaired > 0 {
            notes.add(|| format!("{item}: {repaired} colours or texture coordinates that are not finite are replaced"));
        }
        let mut targets = Vec::with_capacity(self.targets.len());
        for target in &self.targets {
            let [positions, normals] = target.map(|index| index.map(vectors).transpose());
            let target = Displacements { positions: positions?, normals: normals? };
            for displacements in [&target.positions, &target.normals].into_iter().flatten() {
                if displacements.len() != count || first_non_finite(displacements).is_some() {
                    return Err(item.invalid("has a morph target of another size or with values that are not finite"));
                }
            }
            targets.push(target);
        }
        let skin = match &self.influences[..] {
            [] => None,
            sets => Some(influences::read(sets, count, accessors, item, notes)?),
        };
        Ok(Vertices { positions, normals, uvs, colors, skin, targets })
    }
}

impl Vertices {
    pub(crate) fn count(&self) -> usize {
        self.positions.len()
    }

    /// The corners of some triangles, each with a vertex of its own, and with the normal of its
    /// triangle.
    pub(crate) fn flat(&self, triangles: &[[u32; 3]]) -> Self {
        let corners = triangles.as_flattened();
        let normals = triangles.iter().flat_map(|&triangle| [face_normal(&self.positions, triangle); 3]).collect();
        let target = |target: &Displacements| Displacements {
            positions: target.positions.as_ref().map(|positions| selected(positions, corners)),
            normals: None,
        };
        Self {
            positions: selected(&self.positions, corners),
            normals: Some(normals),
            uvs: self.uvs.as_ref().map(|uvs| selected(uvs, corners)),
            colors: self.colors.as_ref().map(|colors| selected(colors, corners)),
            skin: self.skin.as_ref().map(|skin| Skin {
                joints: selected(&skin.joints, corners),
                weights: selected(&skin.weights, corners),
            }),
            targets: self.targets.iter().map(target).collect(),
        }
    }
}

/// How many numbers the memory of a vertex with so many morph targets holds.
pub(crate) fn numbers_per_vertex(targets: usize) -> u64 {
    20 + 6 * targets as u64
}

/// RGB or RGBA.
fn colors(accessors: &Accessors<'_>, index: Index<Accessor>, item: &Item) -> Result<Vec<[f32; 4]>, Problem> {
    match accessors.element_type(index, item)? {
        ElementType::Vec3 => {
            let colors = accessors.floats::<3>(index, ElementType::Vec3, item)?;
            Ok(colors.into_iter().map(|[r, g, b]| [r, g, b, 1.0]).collect())
        }
        _ => accessors.floats::<4>(index, ElementType::Vec4, item),
    }
}

fn selected<T: Copy>(values: &[T], indices: &[u32]) -> Vec<T> {
    indices.iter().map(|&index| values[index as usize]).collect()
}

fn first_non_finite<const N: usize>(vectors: &[[f32; N]]) -> Option<usize> {
    vectors.iter().position(|vector| !vector.iter().all(|number| number.is_finite()))
}

/// Replaces the numbers that are not finite, and returns how many there were.
fn replace_non_finite<const N: usize>(vectors: &mut [[f32; N]], replacement: f32) -> usize {
    let non_finite = vectors.as_flattened_mut().iter_mut().filter(|number| !number.is_finite());
    non_finite.map(|number| *number = replacement).count()
}
