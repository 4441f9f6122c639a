//! Lights that are no surfaces (KHR_lights_punctual).
//!
//! Photometric units are used as if they were radiometric: a candela becomes a watt per steradian, a lux a watt per
//! square metre.

use std::f32::consts::FRAC_PI_2;

use gltf::json::extensions::scene::khr_lights_punctual::{Light as LightJson, Type};
use gltf::json::validation::Checked;
use gltf::json::{Index, Node};
use kinetree_render::Light;

use crate::document::Document;
use crate::error::{Item, Problem};
use crate::notes::Notes;

/// Lights shine along the -z axis of their node.
const FORWARDS: [f32; 3] = [0.0, 0.0, -1.0];

/// The light that hangs on a node, in the space of the node.
pub(crate) fn light_of(
    document: &Document,
    node: &Node,
    node_item: &Item,
    notes: &mut Notes,
) -> Result<Option<Light>, Problem> {
    let extension = node.extensions.as_ref().and_then(|extensions| extensions.khr_lights_punctual.as_ref());
    let Some(extension) = extension else { return Ok(None) };
    let index: Index<LightJson> = extension.light;
    let light = document.get(index, "light", node_item)?;
    let item = Item::named("light", index.value(), light.name.as_ref());
    let Checked::Valid(kind) = light.type_ else {
        notes.add(|| format!("{item} is of an unknown type, and is left out"));
        return Ok(None);
    };
    let intensity = light.color.map(|channel| channel * light.intensity);
    if !intensity.iter().all(|&channel| channel.is_finite() && channel >= 0.0) {
        return Err(item.invalid("has an intensity that is negative or not finite"));
    }
    if intensity == [0.0; 3] {
        return Ok(None);
    }
    // A range of zero or less, or that is none, bounds nothing.
    let range = light.range.filter(|&range| range > 0.0).unwrap_or(f32::INFINITY);
    let position = [0.0; 3];
    Ok(Some(match kind {
        Type::Directional => Light::Sun { direction: FORWARDS, irradiance: intensity, angle: 0.0 },
        Type::Point => Light::Point { position, intensity, range },
        Type::Spot => {
            let Some(spot) = &light.spot else { return Err(item.invalid("is a spot light without a cone")) };
            if !(spot.inner_cone_angle.is_finite() && spot.outer_cone_angle.is_finite()) {
                return Err(item.invalid("has a cone whose angles are not finite"));
            }
            let outer = spot.outer_cone_angle.clamp(0.0, FRAC_PI_2);
            let inner = spot.inner_cone_angle.clamp(0.0, outer);
            Light::Spot {
                position,
                direction: FORWARDS,
                intensity,
                range,
                inner_cos: inner.cos(),
                outer_cos: outer.cos(),
            }
        }
    }))
}
