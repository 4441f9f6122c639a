//! Punctual lights (KHR_lights_punctual).
//!
//! Photometric units are used as if they were radiometric: a candela becomes a watt per steradian,
//! a lux a watt per square metre.

use std::f32::consts::FRAC_PI_2;

use kinetree_world::Light;

use crate::document::Document;
use crate::error::{Item, Problem};
use crate::json::{LightKind, Node};
use crate::notes::Notes;

/// Lights shine along the -z axis of their node.
const FORWARDS: [f32; 3] = [0.0, 0.0, -1.0];

/// The light of a node, in the space of the node.
pub(crate) fn light_of(
    document: &Document,
    node: &Node,
    node_item: &Item,
    notes: &mut Notes,
) -> Result<Option<Light>, Problem> {
    let Some(index) = node.light() else { return Ok(None) };
    let light = document.get(index, "light", node_item)?;
    let item = Item::named("light", index.value(), light.name.as_deref());
    if light.kind == LightKind::Unknown {
        notes.add(|| format!("{item} is of an unknown type, and is left out"));
        return Ok(None);
    }
    let intensity = light.color.map(|channel| channel * light.intensity);
    if !intensity.iter().all(|&channel| channel.is_finite() && channel >= 0.0) {
        return Err(item.invalid("has an intensity that is negative or not finite"));
    }
    if intensity == [0.0; 3] {
        return Ok(None);
    }
    // A range that is not positive means an infinite one.
    let range = light.range.filter(|&range| range > 0.0).unwrap_or(f32::INFINITY);
    let position = [0.0; 3];
    Ok(Some(match light.kind {
        LightKind::Directional => Light::Sun { direction: FORWARDS, irradiance: intensity, angle: 0.0 },
        LightKind::Point | LightKind::Unknown => Light::Point { position, intensity, range },
        LightKind::Spot => {
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
