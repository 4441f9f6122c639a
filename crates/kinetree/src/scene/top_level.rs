//! The tree over all instances of a frame.

use super::report::TopLevelMethod;
use crate::build::{BuildOptions, agglomerate, build_binned};
use crate::geometry::inverse::{COVERED_SKEW, Inverse};
use crate::geometry::slab::FarRays;
use crate::geometry::{Aabb, Affine, UNIT_ROUNDOFF};
use crate::threads::Threads;
use crate::wide::{MeshBvh, TopLevelBvh};

/// Up to this many instances are clustered exactly, which takes well below a millisecond; beyond,
/// its time grows faster than that of binning.
const CLUSTERED_UP_TO: usize = 512;

/// A tree over the boxes that are not empty; its primitives are indices into `boxes`. `far` is the
/// additional error of rays from far away.
pub(crate) fn build(boxes: &[Aabb], far: FarRays, threads: &Threads) -> (TopLevelBvh, TopLevelMethod) {
    let (numbers, solid): (Vec<u32>, Vec<Aabb>) =
        (0..).zip(boxes.iter().copied()).filter(|(_, bounds)| !bounds.is_empty()).unzip();
    if solid.len() <= CLUSTERED_UP_TO {
        return (TopLevelBvh::new(&agglomerate(&solid).bvh.renumbered(&numbers), far), TopLevelMethod::Clustered);
    }
    let options = BuildOptions { threads: threads.clone(), ..BuildOptions::single() };
    let tree = build_binned(solid.len(), |i| solid[i as usize], &options);
    (TopLevelBvh::new(&tree.renumbered(&numbers), far), TopLevelMethod::Binned)
}

/// The world box of an instance: around the transformed boxes in the root node of its mesh's tree,
/// which is tighter than the transformed box of the root.
///
/// Rays are transformed by the rounded inverse; the box is padded by the part of the error that
/// does not depend on the ray's origin.
pub(crate) fn world_box(mesh: &MeshBvh, world_from_object: &Affine, inverse: &Inverse) -> Aabb {
    let Some(root) = mesh.tree().nodes().first() else { return Aabb::EMPTY };
    let world_from_object = match inverse {
        Inverse::Single { .. } => world_from_object,
        Inverse::Double(double) => &double.world_from_object,
    };
    let tight = root
        .lanes()
        .fold(Aabb::EMPTY, |all, (lane, _)| all.union(&world_from_object.transform_box(&root.bounds(lane))));
    let bounds = tight.intersection(&world_from_object.transform_box(&mesh.bounds()));
    if bounds.is_empty() {
        return Aabb::EMPTY;
    }
    padded(&bounds, inverse.error(world_from_object, &mesh.bounds()))
}

fn padded(bounds: &Aabb, pad: [f32; 3]) -> Aabb {
    let axes = [0, 1, 2];
    Aabb::new(axes.map(|axis| bounds.min[axis] - pad[axis]), axes.map(|axis| bounds.max[axis] + pad[axis]))
}

/// Roundings by which a ray may err at a skewed instance, per unit of a row sum of `|M||N|`,
/// relative to the coordinates of its origin and of the point it has reached: five of the origin,
/// and twelve of the difference of both. So boxes are padded by 29 of the farther one, and by 17 of
/// what the origin is farther away; a few more for the effect of the error itself on the
/// difference.
const SKEWED_BOX: f32 = 32.0 * UNIT_ROUNDOFF;
const SKEWED_RAY: f32 = 18.0 * UNIT_ROUNDOFF;

/// Pads the boxes of skewed instances, given by their index and the row sums of `|M||N|`, for rays
/// whose origin is not farther out than the farthest instance; returns what is to be added for
/// other rays. So one skewed instance costs the others nothing, unless a ray comes from far away.
pub(crate) fn pad_skewed(boxes: &mut [Aabb], skewed: &[(usize, [f32; 3])]) -> FarRays {
    if skewed.is_empty() {
        return FarRays::NONE;
    }
    let corners = boxes.iter().filter(|bounds| !bounds.is_empty()).flat_map(|bounds| [bounds.min, bounds.max]);
    let farthest = corners.flatten().fold(0.0_f32, |most, x| most.max(x.abs()));
    let mut most = 0.0_f32;
    for &(at, skew) in skewed {
        let excess = skew.map(|sum| (sum - COVERED_SKEW).max(0.0));
        most = excess.into_iter().fold(most, f32::max);
        let Aabb { min, max } = padded(&boxes[at], excess.map(|excess| excess * SKEWED_BOX * farthest));
        boxes[at] = Aabb::new(min.map(|x| x.max(f32::MIN)), max.map(|x| x.min(f32::MAX)));
    }
    FarRays { padded_for: farthest, origin_error: most * SKEWED_RAY }
}

/// Whether the errors of rays at an instance exceed the error bound of box tests.
pub(crate) fn is_skewed(skew: [f32; 3]) -> bool {
    skew.iter().any(|&sum| sum > COVERED_SKEW)
}
