//! tinybvh, by Jacco Bikker, through the crate `tinybvh-rs`: its eight-wide tree for processors
//! with AVX2, from both of its builders.
//!
//! The crate builds the trees. The two calls that trace them are declared here: the crate offers
//! one only to programs compiled for AVX2 as a whole, and the other not at all, and its ray is
//! shorter than the one that the C++ side writes to (so its constructor must not be called).

use std::ffi::c_void;

use tinybvh_rs::{bvh, bvh8_cpu, mbvh};

use super::interface::{Class, Engine, Facts, Prepared, Refit, Tree};
use super::thread_pool::ThreadPool;
use crate::failure::Failure;
use crate::measure::memory;
use crate::ray::{Answer, Ray};
use crate::soup::Soup;

/// All settings that are compared.
///
/// # Errors
/// The processor has no AVX2.
pub(crate) fn variants() -> Result<Vec<Box<dyn Engine>>, Failure> {
    if !(std::is_x86_feature_detected!("avx2") && std::is_x86_feature_detected!("fma")) {
        return Err("its kernel needs AVX2 and FMA".into());
    }
    Ok(vec![
        Box::new(TinyBvh { name: "tinybvh", class: Class::Fast, best: false }),
        Box::new(TinyBvh { name: "tinybvh hq", class: Class::Best, best: true }),
    ])
}

/// The processor that the C++ code is compiled for: that of this machine, unless a compiler flag
/// says otherwise, as `.cargo/config.toml` does.
pub(crate) fn compiled_for() -> &'static str {
    let flags = option_env!("CXXFLAGS_x86_64_unknown_linux_gnu").unwrap_or_default();
    flags.split_whitespace().rev().find_map(|flag| flag.strip_prefix("-march=")).unwrap_or("this processor")
}

struct TinyBvh {
    name: &'static str,
    class: Class,
    /// With spatial splits.
    best: bool,
}

impl Engine for TinyBvh {
    fn name(&self) -> &str {
        self.name
    }

    fn class(&self) -> Class {
        self.class
    }

    fn prepare(&self, soup: &Soup) -> Result<Box<dyn Prepared>, Failure> {
        Ok(Box::new(PreparedMesh { corners: corners(soup.triangles.as_slice(), &soup.positions), best: self.best }))
    }

    fn refitter(&self, soup: &Soup, _: &ThreadPool) -> Result<Option<Box<dyn Refit>>, Failure> {
        if self.best {
            // Trees with spatial splits cannot be refitted.
            return Ok(None);
        }
        let corners = corners(soup.triangles.as_slice(), &soup.positions);
        let tree = bvh::BVH::new(corners.as_slice().into()).map_err(failure)?.data();
        Ok(Some(Box::new(Refitter { triangles: soup.triangles.clone(), corners, tree: Some(tree) })))
    }
}

/// Three vertices of four floats for each triangle, the input format of tinybvh.
fn corners(triangles: &[[u32; 3]], positions: &[[f32; 3]]) -> Vec<[f32; 4]> {
    let vertices = triangles.iter().flatten().map(|&vertex| positions[vertex as usize]);
    vertices.map(|[x, y, z]| [x, y, z, 0.0]).collect()
}

fn failure(error: tinybvh_rs::Error) -> Failure {
    error.to_string().into()
}

struct PreparedMesh {
    corners: Vec<[f32; 4]>,
    best: bool,
}

impl Prepared for PreparedMesh {
    fn build(&mut self, _: &ThreadPool) -> Result<Box<dyn Tree>, Failure> {
        let before = memory::c_heap_bytes();
        let corners = self.corners.as_slice().into();
        let mut binary = if self.best { bvh::BVH::new_hq(corners) } else { bvh::BVH::new(corners) }.map_err(failure)?;
        binary.split_leaves(4);
        let (cost, overlap) = cost_and_overlap(binary.nodes());
        let tree = {
            let wide = mbvh::BVH::new(&binary);
            bvh8_cpu::BVH::new(&wide).map_err(failure)?
        };
        drop(binary);
        let bytes = memory::c_heap_bytes().zip(before).map(|(now, before)| now.saturating_sub(before));
        Ok(Box::new(BuiltTree { tree, bytes, cost, overlap }))
    }
}

/// Cost and overlap of the binary tree, by kinetree's formulas.
fn cost_and_overlap(nodes: &[bvh::Node]) -> (f32, f32) {
    let area = |min: [f32; 3], max: [f32; 3]| {
        let [x, y, z] = [0, 1, 2].map(|axis| f64::from(max[axis] - min[axis]));
        if x < 0.0 || y < 0.0 || z < 0.0 { 0.0 } else { x * y + y * z + z * x }
    };
    let Some(root) = nodes.first().map(|root| area(root.min, root.max)).filter(|area| *area > 0.0) else {
        return (0.0, 0.0);
    };
    let (mut cost, mut overlap, mut open) = (0.0, 0.0, vec![0_usize]);
    while let Some(at) = open.pop() {
        let node = &nodes[at];
        cost += area(node.min, node.max) * if node.is_leaf() { f64::from(node.tri_count) } else { 1.0 };
        if !node.is_leaf() {
            let first = node.left_first as usize;
            let (left, right) = (&nodes[first], &nodes[first + 1]);
            let low = [0, 1, 2].map(|axis| left.min[axis].max(right.min[axis]));
            let high = [0, 1, 2].map(|axis| left.max[axis].min(right.max[axis]));
            overlap += area(low, high);
            open.extend([first, first + 1]);
        }
    }
    ((cost / root) as f32, (overlap / root) as f32)
}

struct BuiltTree {
    tree: bvh8_cpu::BVH,
    bytes: Option<usize>,
    cost: f32,
    overlap: f32,
}

// SAFETY: a finished tree is only read: the calls below take a pointer to const, and it caches
// nothing.
unsafe impl Send for BuiltTree {}
// SAFETY: as above.
unsafe impl Sync for BuiltTree {}

/// The ray of the C++ side: 64 bytes that it uses, and 64 for the caller's data.
#[repr(C, align(64))]
struct CppRay {
    origin: [f32; 3],
    mask: u32,
    direction: [f32; 3],
    instance: u32,
    reciprocal: [f32; 3],
    hit_instance: u32,
    t: f32,
    u: f32,
    v: f32,
    primitive: u32,
    auxiliary: [u64; 8],
}

const _: () = assert!(size_of::<CppRay>() == 128);
const _: () = assert!(size_of::<bvh8_cpu::BVH>() == size_of::<*const c_void>());

/// tinybvh's value for infinity.
const FAR: f32 = tinybvh_rs::INFINITE;

unsafe extern "C" {
    /// `int32_t tinybvh::BVH8_CPU::Intersect(Ray&) const`
    #[link_name = "_ZNK7tinybvh8BVH8_CPU9IntersectERNS_3RayE"]
    fn intersect(tree: *const c_void, ray: *mut CppRay) -> i32;
    /// `bool tinybvh::BVH8_CPU::IsOccluded(const Ray&) const`
    #[link_name = "_ZNK7tinybvh8BVH8_CPU10IsOccludedERKNS_3RayE"]
    fn is_occluded(tree: *const c_void, ray: *const CppRay) -> bool;
}

#[inline]
fn engine_ray(ray: &Ray) -> CppRay {
    let reciprocal = ray.direction.map(|d| if d.abs() > 1e-12 { 1.0 / d } else { FAR.copysign(d) });
    CppRay {
        origin: ray.origin,
        mask: 0xffff,
        direction: ray.direction,
        instance: 0,
        reciprocal,
        hit_instance: 0,
        t: ray.t_max.min(FAR),
        u: 0.0,
        v: 0.0,
        primitive: Answer::NOTHING,
        auxiliary: [0; 8],
    }
}

impl BuiltTree {
    fn pointer(&self) -> *const c_void {
        // SAFETY: the crate's type holds nothing but a unique pointer, which holds nothing but a
        // pointer; the size is asserted above. The pointer is copied, and the tree keeps its
        // ownership.
        unsafe { *std::ptr::from_ref(&self.tree).cast::<*const c_void>() }
    }
}

impl Tree for BuiltTree {
    fn closest(&self, rays: &[Ray], answers: &mut [Answer]) {
        let tree = self.pointer();
        for (ray, slot) in rays.iter().zip(answers) {
            let mut query = engine_ray(ray);
            // SAFETY: the tree is alive and finished, the ray has the layout of the C++ side, and
            // `variants` has checked for AVX2.
            unsafe { intersect(tree, &mut query) };
            let CppRay { t, u, v, primitive, hit_instance: mesh, .. } = query;
            *slot = if primitive == Answer::NOTHING { Answer::MISS } else { Answer { t, u, v, primitive, mesh } };
        }
    }

    fn occluded(&self, rays: &[Ray], answers: &mut [bool]) {
        let tree = self.pointer();
        for (ray, slot) in rays.iter().zip(answers) {
            // SAFETY: as in `closest`; the ray is only read.
            *slot = unsafe { is_occluded(tree, &engine_ray(ray)) };
        }
    }

    fn facts(&self) -> Facts {
        Facts { bytes: self.bytes, peak: None, cost: Some(self.cost), overlap: Some(self.overlap) }
    }
}

/// The binary tree: the wide one cannot be refitted.
struct Refitter {
    triangles: Vec<[u32; 3]>,
    corners: Vec<[f32; 4]>,
    tree: Option<bvh::BVHData>,
}

impl Refit for Refitter {
    fn refit(&mut self, positions: &[[f32; 3]]) -> Result<(), Failure> {
        let vertices = self.triangles.iter().flatten().map(|&vertex| positions[vertex as usize]);
        self.corners.iter_mut().zip(vertices).for_each(|(corner, [x, y, z])| *corner = [x, y, z, 0.0]);
        let tree = self.tree.take().ok_or("an earlier refit failed")?;
        let mut tree = tree.bvh(self.corners.as_slice().into()).map_err(failure)?;
        tree.refit();
        self.tree = Some(tree.data());
        Ok(())
    }
}
