//! The settings of kinetree that are measured.

use kinetree::build::Quality;
use kinetree::simd::Level;
use kinetree::{Mesh, Motion, Precision, Scene};

use super::built_tree::BuiltTree;
use super::refitter::Refitter;
use super::scene::scene_of;
use crate::engine::interface::{Class, Engine, Prepared, Refit, Tree};
use crate::engine::thread_pool::ThreadPool;
use crate::failure::Failure;
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
