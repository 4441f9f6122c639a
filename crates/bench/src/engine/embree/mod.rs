//! Embree 4, Intel's ray tracer, through its C interface.
//!
//! As its manual asks, denormal numbers count as zero in the threads that call it: around its calls
//! only, so that no other engine is helped or hurt by it.

mod api;
mod denormals;
mod device;
mod messages;
mod packets;
mod scene;
mod single;
mod sorted;

use std::sync::Arc;

use kinetree::simd::Level;

use self::api::{Api, BuildQuality, SceneFlags};
use self::device::Device;
use self::scene::{PreparedMesh, Refitter};
use crate::engine::interface::{Class, Engine, Prepared, Refit};
use crate::engine::thread_pool::ThreadPool;
use crate::failure::Failure;
use crate::level::OWN_BUILD;
use crate::soup::Soup;

/// What Embree calls a level, and which packets, of eight and of sixteen rays, fill its registers
/// there. It has no plain code: its least is SSE2. On ARM it knows one level, which it takes by
/// itself.
fn isa(level: Level) -> (Option<&'static str>, [bool; 2]) {
    match level.name() {
        "avx512" => (Some("avx512"), [true, true]),
        "avx2" => (Some("avx2"), [true, false]),
        "scalar" if cfg!(target_arch = "x86_64") => (Some("sse2"), [false, false]),
        _ => (None, [false, false]),
    }
}

/// What Embree uses at a level, as results name it.
fn instructions(level: Level) -> &'static str {
    match isa(level).0 {
        Some(isa) => isa,
        None if cfg!(target_arch = "aarch64") => "neon",
        None => OWN_BUILD,
    }
}

/// Every setting that is compared, at one level, and a sentence about version and level.
///
/// # Errors
/// The library is not there, or not the one that is needed, or was compiled without code for the
/// level.
pub(crate) fn variants(level: Level) -> Result<(Vec<Box<dyn Engine>>, String), Failure> {
    let (isa, packets) = isa(level);
    let api = Arc::new(Api::open(isa)?);
    // Asks for its version, and finds a processor that it cannot run on before anything is
    // measured.
    let device = Device::new(&api, 1)?;
    let instructions = instructions(level);
    if isa.is_some() && device.native_packets() != packets {
        return Err(format!("the library does not keep to isa={instructions}").into());
    }
    let mut note = format!("with Embree {}, at {instructions}", device.version());
    if level.name() != instructions {
        note += &format!(": it has no {} code, this is its least", level.name());
    }
    let (fast, robust) = (SceneFlags::NONE, SceneFlags::ROBUST);
    let variant = |name, class, quality, flags| -> Box<dyn Engine> {
        Box::new(Embree { api: Arc::clone(&api), instructions, name, class, quality, flags })
    };
    let variants = vec![
        variant("embree low", Class::Fastest, BuildQuality::LOW, fast),
        variant("embree medium", Class::Fast, BuildQuality::MEDIUM, fast),
        variant("embree high", Class::Best, BuildQuality::HIGH, fast),
        variant("embree medium robust", Class::Fast, BuildQuality::MEDIUM, robust),
        variant("embree high robust", Class::Best, BuildQuality::HIGH, robust),
    ];
    Ok((variants, note))
}

struct Embree {
    api: Arc<Api>,
    instructions: &'static str,
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

    fn instructions(&self) -> &str {
        self.instructions
    }

    fn is_robust(&self) -> bool {
        self.flags == SceneFlags::ROBUST
    }

    fn shares_builds(&self) -> bool {
        self.is_robust()
    }

    fn prepare(&self, soup: &Soup) -> Result<Box<dyn Prepared>, Failure> {
        Ok(Box::new(PreparedMesh::new(&self.api, soup, self.quality, self.flags)))
    }

    fn refitter(&self, soup: &Soup, pool: &ThreadPool) -> Result<Option<Box<dyn Refit>>, Failure> {
        if self.quality != BuildQuality::MEDIUM || self.is_robust() {
            return Ok(None);
        }
        Ok(Some(Box::new(Refitter::new(&self.api, soup, pool.threads)?)))
    }
}
