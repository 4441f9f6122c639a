//! The tree over all instances of a frame.

use super::report::TopLevelMethod;
use crate::build::{BuildOptions, agglomerate, binned};
use crate::geometry::{Aabb, Affine};
use crate::threads::Threads;
use crate::wide::{WideMesh, WideTop};

/// Up to this many instances are clustered exactly, which takes well below a millisecond; beyond, its time grows faster than that of binning.
const CLUSTERED_UP_TO: usize = 512;

/// A tree over the boxes that are not empty; its primitives are places in `boxes`.
pub(crate) fn build(boxes: &[Aabb], threads: &Threads) -> (WideTop, TopLevelMethod) {
    let (numbers, solid): (Vec<u32>, Vec<Aabb>) =
        (0..).zip(boxes.iter().copied()).filter(|(_, bounds)| !bounds.is_empty()).unzip();
    if solid.len() <= CLUSTERED_UP_TO {
        return (WideTop::new(&agglomerate(&solid).bvh.renumbered(&numbers)), TopLevelMethod::Clustered);
    }
    let options = BuildOptions { threads: threads.clone(), ..BuildOptions::single() };
    let tree = binned(solid.len(), |i| solid[i as usize], &options);
    (WideTop::new(&tree.renumbered(&numbers)), TopLevelMethod::Binned)
}

/// A world box around a mesh where an instance stands: around the images of the boxes in its root node, which is tighter than the image of its root.
///
/// Rays enter the mesh through the rounded inverse; the box leaves room for that.
pub(crate) fn world_box(mesh: &WideMesh, world_from_object: &Affine, object_from_world: &Affine) -> Aabb {
    let Some(root) = mesh.tree().nodes().first() else { return Aabb::EMPTY };
    let tight = root
        .lanes()
        .fold(Aabb::EMPTY, |all, (lane, _)| all.union(&world_from_object.transform_box(&root.bounds(lane))));
    let bounds = tight.intersection(&world_from_object.transform_box(&mesh.bounds()));
    if bounds.is_empty() {
        return Aabb::EMPTY;
    }
    let farthest = bounds.min.iter().chain(&bounds.max).fold(0.0_f32, |most, x| most.max(x.abs()));
    let condition = reach(world_from_object) * reach(object_from_world);
    let slack = 16.0 * crate::geometry::UNIT_ROUNDOFF * farthest * condition;
    Aabb::new(bounds.min.map(|x| x - slack), bounds.max.map(|x| x + slack))
}

/// The most that a map stretches a coordinate.
fn reach(map: &Affine) -> f32 {
    (0..3).fold(0.0, |most: f32, row| most.max(map.x_axis[row].abs() + map.y_axis[row].abs() + map.z_axis[row].abs()))
}
