//! Scenes of one triangle mesh: built, traced, refitted.

use std::sync::Arc;

use kinetree::Aabb;

use super::api::{Api, BufferType, BuildQuality, Format, GeometryType, Handle, SceneFlags};
use super::denormals::NoDenormals;
use super::device::Device;
use super::messages;
use super::packets::Packets;
use super::single;
use super::sorted::Sorted;
use crate::engine::interface::{Batch, Facts, Prepared, Refit, Tree};
use crate::engine::thread_pool::ThreadPool;
use crate::failure::Failure;
use crate::ray::{Answer, Ray};
use crate::soup::Soup;

/// Vertices and triangles that Embree reads in place. It may read sixteen bytes at the last vertex,
/// so there is one more.
struct Buffers {
    positions: Vec<[f32; 3]>,
    triangles: Vec<[u32; 3]>,
    bounds: Aabb,
}

impl Buffers {
    fn of(soup: &Soup) -> Self {
        let mut positions = Vec::with_capacity(soup.positions.len() + 1);
        positions.extend_from_slice(&soup.positions);
        positions.push([0.0; 3]);
        Self { positions, triangles: soup.triangles.clone(), bounds: soup.bounds() }
    }
}

/// A scene with one geometry. Fields are dropped in this order, so that buffers outlive what reads
/// them.
struct MeshScene {
    scene: Handle,
    geometry: Handle,
    device: Device,
    buffers: Arc<Buffers>,
}

// SAFETY: Embree's scenes may be built from any thread and, once committed, traced from all.
unsafe impl Send for MeshScene {}
// SAFETY: as above; changes need a mutable reference.
unsafe impl Sync for MeshScene {}

impl MeshScene {
    /// A scene that is not committed yet.
    fn new(
        device: Device,
        buffers: Arc<Buffers>,
        scene_quality: BuildQuality,
        quality: BuildQuality,
        flags: SceneFlags,
    ) -> Result<Self, Failure> {
        let api = Arc::clone(&device.api);
        let vertices = buffers.positions.len() - 1;
        // SAFETY: the device is alive; the buffers have the stated number of elements of the stated
        // size, and live as long as the geometry, which is released before them. All indices are
        // below the number of vertices, as those of the soup are.
        let (scene, geometry) = unsafe {
            let scene = (api.new_scene)(device.handle);
            (api.set_scene_flags)(scene, flags);
            (api.set_scene_quality)(scene, scene_quality);
            let geometry = (api.new_geometry)(device.handle, GeometryType::TRIANGLE);
            (api.set_geometry_quality)(geometry, quality);
            let positions = buffers.positions.as_ptr().cast();
            (api.set_shared_buffer)(geometry, BufferType::VERTEX, 0, Format::FLOAT3, positions, 0, 12, vertices);
            let triangles = buffers.triangles.as_ptr().cast();
            (api.set_shared_buffer)(
                geometry,
                BufferType::INDEX,
                0,
                Format::UINT3,
                triangles,
                0,
                12,
                buffers.triangles.len(),
            );
            (api.commit_geometry)(geometry);
            (api.attach_geometry)(scene, geometry, 0);
            (scene, geometry)
        };
        let mesh = Self { scene, geometry, device, buffers };
        mesh.device.check()?;
        Ok(mesh)
    }

    fn commit(&self) -> Result<(), Failure> {
        let _no_denormals = NoDenormals::begin();
        // SAFETY: the scene is alive, and not used by others before this returns.
        unsafe { (self.device.api.commit_scene)(self.scene) };
        self.device.check()
    }
}

impl Drop for MeshScene {
    fn drop(&mut self) {
        // SAFETY: both are alive, and not used any more.
        unsafe {
            (self.device.api.release_geometry)(self.geometry);
            (self.device.api.release_scene)(self.scene);
        }
    }
}

/// Triangles that are ready to be built, and, after `set_up`, a scene in which only the tree is
/// missing.
pub(super) struct PreparedMesh {
    api: Arc<Api>,
    buffers: Arc<Buffers>,
    quality: BuildQuality,
    flags: SceneFlags,
    scene: Option<MeshScene>,
}

impl PreparedMesh {
    pub(super) fn new(api: &Arc<Api>, soup: &Soup, quality: BuildQuality, flags: SceneFlags) -> Self {
        Self { api: Arc::clone(api), buffers: Arc::new(Buffers::of(soup)), quality, flags, scene: None }
    }
}

impl Prepared for PreparedMesh {
    fn set_up(&mut self, pool: &ThreadPool) -> Result<(), Failure> {
        let device = Device::new(&self.api, pool.threads)?;
        let buffers = Arc::clone(&self.buffers);
        self.scene = Some(MeshScene::new(device, buffers, self.quality, self.quality, self.flags)?);
        Ok(())
    }

    fn build(&mut self, pool: &ThreadPool) -> Result<Box<dyn Tree>, Failure> {
        if self.scene.is_none() {
            self.set_up(pool)?;
        }
        let mesh = self.scene.take().expect("it has just been set up");
        mesh.commit()?;
        let (bytes, peak) = mesh.device.memory.now_and_most();
        let api = &mesh.device.api;
        let packets = (Packets::x8(api, mesh.scene), Packets::x16(api, mesh.scene));
        let sorted = Sorted { api: Arc::clone(api), scene: mesh.scene, bounds: mesh.buffers.bounds };
        Ok(Box::new(BuiltTree { packets, sorted, mesh, bytes, peak }))
    }

    fn measure_cost(&mut self, pool: &ThreadPool) -> Option<f32> {
        let build = || -> Result<(), Failure> {
            let device = Device::with_messages(&self.api, pool.threads, true)?;
            MeshScene::new(device, Arc::clone(&self.buffers), self.quality, self.quality, self.flags)?.commit()
        };
        let (built, text) = messages::capture_output(build)?;
        built.ok().and_then(|()| messages::cost(&text))
    }
}

struct BuiltTree {
    packets: (Packets<8>, Packets<16>),
    sorted: Sorted,
    mesh: MeshScene,
    bytes: usize,
    peak: usize,
}

impl Tree for BuiltTree {
    fn closest(&self, rays: &[Ray], answers: &mut [Answer]) {
        single::closest(&self.mesh.device.api, self.mesh.scene, rays, answers);
    }

    fn occluded(&self, rays: &[Ray], answers: &mut [bool]) {
        single::occluded(&self.mesh.device.api, self.mesh.scene, rays, answers);
    }

    fn batches(&self) -> Vec<&dyn Batch> {
        vec![&self.packets.0, &self.packets.1, &self.sorted]
    }

    fn facts(&self) -> Facts {
        Facts { bytes: Some(self.bytes), peak: Some(self.peak), ..Facts::default() }
    }
}

/// A scene whose tree is refitted when vertices move.
pub(super) struct Refitter {
    mesh: MeshScene,
}

impl Refitter {
    pub(super) fn new(api: &Arc<Api>, soup: &Soup, threads: usize) -> Result<Self, Failure> {
        let device = Device::new(api, threads)?;
        let buffers = Arc::new(Buffers::of(soup));
        // Only scenes of low quality have a tree per mesh, and only such trees can be refitted.
        let mesh = MeshScene::new(device, buffers, BuildQuality::LOW, BuildQuality::REFIT, SceneFlags::DYNAMIC)?;
        mesh.commit()?;
        Ok(Self { mesh })
    }
}

impl Refit for Refitter {
    fn refit(&mut self, positions: &[[f32; 3]]) -> Result<(), Failure> {
        let buffers = Arc::get_mut(&mut self.mesh.buffers).ok_or("its buffers are shared")?;
        let vertices = buffers.positions.len() - 1;
        if positions.len() != vertices {
            return Err("there must be as many vertices as before".into());
        }
        buffers.positions[..vertices].copy_from_slice(positions);
        let (api, geometry) = (&self.mesh.device.api, self.mesh.geometry);
        // SAFETY: the geometry is alive; its buffer has not moved, since a vector that keeps its
        // length does not reallocate.
        unsafe {
            (api.update_buffer)(geometry, BufferType::VERTEX, 0);
            (api.commit_geometry)(geometry);
        }
        self.mesh.commit()
    }
}
