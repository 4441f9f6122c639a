//! Embree 4, Intel's ray tracer, through its C interface.
//!
//! As its manual asks, denormal numbers count as zero in the threads that call it: around its calls only, so that no other engine is helped
//! or hurt by it.

mod api;
mod denormals;
mod device;
mod packets;
mod said;
mod scene;
mod sorted;

use std::sync::Arc;

use self::api::{Api, BuildQuality, SceneFlags};
use self::device::Device;
use self::scene::{Following, Ready};
use super::{Class, Crew, Engine, Prepared, Refit};
use crate::Failure;
use crate::soup::Soup;

/// Every setting that is compared, and the version of the library.
///
/// # Errors
/// The library is not there, or not the one that is needed.
pub(crate) fn variants() -> Result<(Vec<Box<dyn Engine>>, String), Failure> {
    let api = Arc::new(Api::open()?);
    // Asks for its version, and finds a processor that it cannot run on before anything is measured.
    let version = Device::new(&api, 1)?.version();
    let (fast, robust) = (SceneFlags::NONE, SceneFlags::ROBUST);
    let variant = |name, class, quality, flags| -> Box<dyn Engine> {
        Box::new(Embree { api: Arc::clone(&api), name, class, quality, flags })
    };
    let variants = vec![
        variant("embree low", Class::Fastest, BuildQuality::LOW, fast),
        variant("embree medium", Class::Fast, BuildQuality::MEDIUM, fast),
        variant("embree high", Class::Best, BuildQuality::HIGH, fast),
        variant("embree medium robust", Class::Fast, BuildQuality::MEDIUM, robust),
        variant("embree high robust", Class::Best, BuildQuality::HIGH, robust),
    ];
    Ok((variants, version))
}

struct Embree {
    api: Arc<Api>,
    name: &'static str,
    class: Class,
    quality: BuildQuality,
    flags: SceneFlags,
}

impl Engine for Embree {
    fn name(&self) -> &str {
        self.name
    }

    fn class(&self) -> Class {
        self.class
    }

    fn is_robust(&self) -> bool {
        self.flags == SceneFlags::ROBUST
    }

    fn shares_builds(&self) -> bool {
        self.is_robust()
    }

    fn prepare(&self, soup: &Soup) -> Result<Box<dyn Prepared>, Failure> {
        Ok(Box::new(Ready::new(&self.api, soup, self.quality, self.flags)))
    }

    fn refitter(&self, soup: &Soup, crew: &Crew) -> Result<Option<Box<dyn Refit>>, Failure> {
        if self.quality != BuildQuality::MEDIUM || self.is_robust() {
            return Ok(None);
        }
        Ok(Some(Box::new(Following::new(&self.api, soup, crew.threads)?)))
    }
}
