//! Perspective cameras.

use kinetree::Affine;
use kinetree_world::Camera;

use crate::document::Document;
use crate::error::{Item, Problem};
use crate::json::Node;
use crate::notes::Notes;

/// Vertical field of view that replaces a missing or impossible one, radians.
const DEFAULT_FOV_Y: f32 = 0.8;

/// The camera of a node, in the space of the node, and its name: its own, or that of the node.
pub(crate) fn camera_of(
    document: &Document,
    node: &Node,
    node_item: &Item,
    notes: &mut Notes,
) -> Result<Option<(String, Camera)>, Problem> {
    let Some(index) = node.camera else { return Ok(None) };
    let camera = document.get(index, "camera", node_item)?;
    let item = Item::named("camera", index.value(), camera.name.as_deref());
    let fov_y = match &camera.perspective {
        None => {
            notes.add(|| format!("{item} has no perspective, and is given one"));
            DEFAULT_FOV_Y
        }
        Some(perspective) if perspective.yfov > 0.0 && perspective.yfov < std::f32::consts::PI => perspective.yfov,
        Some(perspective) => {
            notes.add(|| format!("{item}: a field of view of {} is replaced by {DEFAULT_FOV_Y}", perspective.yfov));
            DEFAULT_FOV_Y
        }
    };
    let name = camera.name.as_deref().or(node.name.as_deref()).unwrap_or_default().to_owned();
    Ok(Some((name, Camera { world_from_camera: Affine::IDENTITY, fov_y })))
}
