//! kinetree: a flattened scene is one mesh with one instance.

use std::cell::RefCell;

use kinetree::build::Quality;
use kinetree::query::sort::BLOCK;
use kinetree::simd::Level;
use kinetree::{Action, Affine, Coherence, Hit, Mesh, MeshId, Motion, Precision, Scene, Snapshot, Work};

use super::interface::{Batch, Class, Engine, Facts, Mode, Prepared, Refit, Tree};
use super::thread_pool::ThreadPool;
use crate::agree::refined;
use crate::failure::Failure;
use crate::ray::{Answer, Ray};
use crate::rays::Question;
use crate::soup::Soup;

/// All settings that are compared.
pub(crate) fn variants() -> Vec<Box<dyn Engine>> {
    SETTINGS.iter().map(|setting| -> Box<dyn Engine> { Box::new(*setting) }).collect()
}

/// Ends the names of settings with `Precision::Fast`.
pub(crate) const FAST_PRECISION_SUFFIX: &str = " precision-fast";

/// The settings, in the order of the tables.
const SETTINGS: [Kinetree; 6] = [
    Kinetree { name: "kinetree fastest", class: Class::Fastest, quality: Quality::Fastest, robust: true },
    Kinetree { name: "kinetree fast", class: Class::Fast, quality: Quality::Fast, robust: true },
    Kinetree { name: "kinetree best", class: Class::Best, quality: Quality::Best, robust: true },
    Kinetree {
        name: "kinetree fastest precision-fast",
        class: Class::Fastest,
        quality: Quality::Fastest,
        robust: false,
    },
    Kinetree { name: "kinetree fast precision-fast", class: Class::Fast, quality: Quality::Fast, robust: false },
    Kinetree { name: "kinetree best precision-fast", class: Class::Best, quality: Quality::Best, robust: false },
];

#[derive(Clone, Copy)]
struct Kinetree {
    name: &'static str,
    class: Class,
    quality: Quality,
    /// Whether triangle tests are watertight.
    robust: bool,
}

impl Kinetree {
    fn mesh(&self, soup: &Soup) -> Result<Mesh, Failure> {
        self.mesh_of(&soup.positions, &soup.triangles)
    }

    fn mesh_of(&self, positions: &[[f32; 3]], triangles: &[[u32; 3]]) -> Result<Mesh, Failure> {
        let precision = if self.robust { Precision::Watertight } else { Precision::Fast };
        Ok(Mesh::new(positions, triangles)?.with_quality(self.quality).with_precision(precision))
    }
}

impl Engine for Kinetree {
    fn name(&self) -> &str {
        self.name
    }

    fn class(&self) -> Class {
        self.class
    }

    fn instructions(&self) -> &str {
        Level::current().name()
    }

    fn is_robust(&self) -> bool {
        self.robust
    }

    fn shares_builds(&self) -> bool {
        !self.robust
    }

    fn prepare(&self, soup: &Soup) -> Result<Box<dyn Prepared>, Failure> {
        Ok(Box::new(PreparedMesh { setting: *self, mesh: self.mesh(soup)?, scene: None }))
    }

    fn refitter(&self, soup: &Soup, pool: &ThreadPool) -> Result<Option<Box<dyn Refit>>, Failure> {
        if self.quality != Quality::Fast || !self.robust {
            return Ok(None);
        }
        let mesh = self.mesh(soup)?;
        let mut refitter = pool.run(|| -> Result<_, Failure> {
            let (mut scene, mesh) = scene_of(mesh, Motion::Deforming)?;
            let frame = scene.commit();
            Ok(Refitter { scene, mesh, frame })
        })?;
        // Allocates the second buffer before the clock starts.
        refitter.scene.set_positions(refitter.mesh, &soup.positions)?;
        refitter.frame = refitter.scene.commit();
        Ok(Some(Box::new(refitter)))
    }
}

/// A scene with this mesh and one instance of it.
fn scene_of(mesh: Mesh, motion: Motion) -> Result<(Scene, MeshId), Failure> {
    let mut scene = Scene::new();
    let mesh = scene.add_mesh(mesh, motion)?;
    let root = scene.root();
    scene.add_instance(root, mesh, Affine::IDENTITY)?;
    Ok((scene, mesh))
}

struct PreparedMesh {
    setting: Kinetree,
    mesh: Mesh,
    scene: Option<Scene>,
}

impl Prepared for PreparedMesh {
    fn set_up(&mut self, _: &ThreadPool) -> Result<(), Failure> {
        // A new mesh, since clones share their first tree: a clone would build nothing.
        let mesh = self.setting.mesh_of(self.mesh.positions(), self.mesh.triangles())?;
        self.scene = Some(scene_of(mesh, Motion::Static)?.0);
        Ok(())
    }

    fn build(&mut self, pool: &ThreadPool) -> Result<Box<dyn Tree>, Failure> {
        if self.scene.is_none() {
            self.set_up(pool)?;
        }
        let mut scene = self.scene.take().expect("it has just been set up");
        Ok(Box::new(BuiltTree { view: pool.run(|| scene.commit()) }))
    }
}

struct BuiltTree {
    view: Snapshot,
}

#[inline]
fn engine_ray(ray: &Ray) -> kinetree::Ray {
    kinetree::Ray::new(ray.origin, ray.direction).with_range(0.0, ray.t_max)
}

#[inline]
fn answer(hit: Option<Hit>) -> Answer {
    hit.map_or(Answer::MISS, |hit| Answer {
        t: hit.t,
        u: hit.u,
        v: hit.v,
        primitive: hit.primitive,
        mesh: hit.instance_index(),
    })
}

impl Tree for BuiltTree {
    fn closest(&self, rays: &[Ray], answers: &mut [Answer]) {
        for (ray, slot) in rays.iter().zip(answers) {
            *slot = answer(self.view.closest_hit(&engine_ray(ray)));
        }
    }

    fn occluded(&self, rays: &[Ray], answers: &mut [bool]) {
        for (ray, slot) in rays.iter().zip(answers) {
            *slot = self.view.occluded(&engine_ray(ray));
        }
    }

    fn batches(&self) -> Vec<&dyn Batch> {
        vec![self]
    }

    fn facts(&self) -> Facts {
        let trees = || self.view.instances().map(|instance| instance.bvh());
        Facts {
            bytes: Some(trees().map(|tree| tree.heap_bytes()).sum()),
            peak: None,
            cost: trees().map(|tree| tree.cost(1.0, 1.0)).next(),
            overlap: trees().map(|tree| tree.overlap()).next(),
        }
    }

    fn count(&self, rays: &[Ray], question: Question) -> Option<Work> {
        let mut work = Work::default();
        let query = self.view.query();
        for ray in rays {
            match question {
                Question::Closest => drop(query.closest_hit_counted(&engine_ray(ray), &mut work)),
                Question::Occluded => drop(query.occluded_counted(&engine_ray(ray), &mut work)),
            }
        }
        Some(work)
    }
}

impl Batch for BuiltTree {
    fn suffix(&self) -> &'static str {
        ""
    }

    fn mode(&self) -> Mode {
        Mode::Batch
    }

    fn suits(&self, _: Coherence) -> bool {
        true
    }

    fn closest(&self, rays: &[Ray], answers: &mut [Answer], coherence: Coherence) {
        BUFFERS.with_borrow_mut(|BatchBuffers { block, hits }| {
            for (rays, answers) in rays.chunks(block_length(coherence)).zip(answers.chunks_mut(block_length(coherence)))
            {
                block.clear();
                block.extend(rays.iter().map(engine_ray));
                hits.resize(rays.len(), None);
                self.view.closest_hits(block, hits, coherence);
                answers.iter_mut().zip(hits.iter()).for_each(|(slot, hit)| *slot = answer(*hit));
            }
        });
    }

    fn occluded(&self, rays: &[Ray], answers: &mut [bool], coherence: Coherence) {
        BUFFERS.with_borrow_mut(|BatchBuffers { block, .. }| {
            for (rays, answers) in rays.chunks(block_length(coherence)).zip(answers.chunks_mut(block_length(coherence)))
            {
                block.clear();
                block.extend(rays.iter().map(engine_ray));
                self.view.occluded_each(block, answers, coherence);
            }
        });
    }
}

/// Rays and hits in the library's types. A thread keeps them from batch to batch, as a renderer
/// does.
#[derive(Default)]
struct BatchBuffers {
    block: Vec<kinetree::Ray>,
    hits: Vec<Option<Hit>>,
}

thread_local! {
    static BUFFERS: RefCell<BatchBuffers> = RefCell::default();
}

/// How many rays are converted at a time: as many as caches hold, or, for rays that will be sorted,
/// as many as the library sorts together.
fn block_length(coherence: Coherence) -> usize {
    if coherence == Coherence::Incoherent { BLOCK } else { 1024 }
}

struct Refitter {
    scene: Scene,
    mesh: MeshId,
    /// Held as a renderer would hold it, so that the next frame is written into the other buffer.
    frame: Snapshot,
}

impl Refit for Refitter {
    fn refit(&mut self, positions: &[[f32; 3]]) -> Result<(), Failure> {
        self.scene.set_positions(self.mesh, positions)?;
        self.frame = self.scene.commit();
        match self.frame.report().count(Action::Refitted) {
            1 => Ok(()),
            _ => Err("it was built anew, not refitted".into()),
        }
    }
}

/// A kinetree tree from whose hits rays are made, and with which all engines are compared. Where an
/// engine disagrees, an exact search decides.
pub(crate) struct Reference(BuiltTree);

impl Reference {
    /// Builds the tree.
    ///
    /// # Errors
    /// The triangles are not a valid mesh.
    pub(crate) fn of(soup: &Soup) -> Result<Self, Failure> {
        let mesh = Mesh::new(&soup.positions, &soup.triangles)?.with_quality(Quality::Fast);
        let (mut scene, _) = scene_of(mesh, Motion::Static)?;
        Ok(Self(BuiltTree { view: scene.commit() }))
    }

    /// The nearest hits, with distances in double precision.
    pub(crate) fn closest(&self, soup: &Soup, rays: &[Ray]) -> Vec<Answer> {
        let mut answers = vec![Answer::MISS; rays.len()];
        Tree::closest(&self.0, rays, &mut answers);
        refined(soup, rays, &answers)
    }
}

#[cfg(test)]
mod tests {
    use kinetree::Action;

    use super::*;

    #[test]
    fn every_timed_build_builds() {
        let triangle = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        let setting = SETTINGS[1];
        let mesh = setting.mesh_of(&triangle, &[[0, 1, 2]]).unwrap();
        let mut prepared = PreparedMesh { setting, mesh, scene: None };
        let pool = ThreadPool::new(1).unwrap();
        let mut build = || {
            prepared.set_up(&pool).unwrap();
            prepared.scene.take().expect("it has just been set up").commit()
        };
        let (one, other) = (build(), build());
        assert_eq!([one.report().count(Action::Built), other.report().count(Action::Built)], [1, 1]);
        assert!(!std::ptr::eq(one.instance_at(0).bvh(), other.instance_at(0).bvh()));
    }
}
