//! Many instances of the mesh of one node (EXT_mesh_gpu_instancing).

use kinetree::Affine;

use crate::accessor::Accessors;
use crate::budget::Budget;
use crate::error::{Item, Problem};
use crate::json::{ElementType, Instancing};
use crate::transform::{IDENTITY_ROTATION, Trs, normalized};

/// What an instance takes in a scene, in numbers: far more than its placement takes in a file.
const NUMBERS_PER_INSTANCE: u64 = 128;

/// Where the instances stand, in the space of their node.
///
/// # Errors
/// Attributes of different lengths, and placements that are not finite.
pub(crate) fn placements(
    instancing: &Instancing,
    accessors: &Accessors<'_>,
    budget: &Budget,
    node: &Item,
) -> Result<Vec<Affine>, Problem> {
    let attributes = &instancing.attributes;
    let vectors = |index| accessors.floats::<3>(index, ElementType::Vec3, node);
    let translations = attributes.translation.map(vectors).transpose()?;
    let rotations =
        attributes.rotation.map(|index| accessors.floats::<4>(index, ElementType::Vec4, node)).transpose()?;
    let scales = attributes.scale.map(vectors).transpose()?;
    let counts = [translations.as_ref().map(Vec::len), rotations.as_ref().map(Vec::len), scales.as_ref().map(Vec::len)];
    let count = counts.iter().flatten().copied().max().unwrap_or(0);
    if counts.iter().flatten().any(|&other| other != count) {
        return Err(node.invalid("has instances with more of one attribute than of another"));
    }
    budget.spend_numbers((count as u64).saturating_mul(NUMBERS_PER_INSTANCE), node)?;
    let placement = |instance: usize| {
        let translation = translations.as_ref().map_or([0.0; 3], |translations| translations[instance]);
        let scale = scales.as_ref().map_or([1.0; 3], |scales| scales[instance]);
        let rotation = rotations.as_ref().map_or(IDENTITY_ROTATION, |rotations| rotations[instance]);
        if !translation.iter().chain(&scale).chain(&rotation).all(|number| number.is_finite()) {
            return Err(node.invalid(format!("has an instance, {instance}, whose placement is not finite")));
        }
        Ok(Trs { translation, rotation: normalized(rotation).unwrap_or(IDENTITY_ROTATION), scale }.affine())
    };
    (0..count).map(placement).collect()
}
