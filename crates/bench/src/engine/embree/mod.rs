//! Embree 4, Intel's ray tracer, through its C interface.
//!
//! As its manual recommends, denormal numbers count as zero in the threads that call it; only
//! during the calls, so that other engines are not affected.

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

/// Embree's name for a level, and which packets, of eight and of sixteen rays, fill its registers
/// there. Embree has no scalar code: its lowest level is SSE2. On ARM it has one level, which it
/// uses by itself.
fn isa(level: Level) -> (Option<&'static str>, [bool; 2]) {
    match level.name() {
        "avx512" => (Some("avx512"), [true, true]),
        "avx2" => (Some("avx2"), [true, false]),
        "scalar" if cfg!(target_arch = "x86_64") => (Some("sse2"), [false, false]),
        _ => (None, [false, false]),
    }
}

/// The instructions that Embree uses at a level, as named in results.
fn instructions(level: Level) -> &'static str {
    match isa(level).0 {
        Some(isa) => isa,
        None if cfg!(target_arch = "aarch64") => "neon",
        None => OWN_BUILD,
    }
}

/// All settings that are compared, at one level, and a sentence about version and level.
///
/// # Errors
/// The library is missing, is of another version, or has no code for the level.
pub(crate) fn variants(level: Level) -> Result<(Vec<Box<dyn Engine>>, String), Failure> {
    let (isa, packets) = isa(level);
    let api = Arc::new(Api::open(isa)?);
    // Fails before anything is measured if the processor or the version is not supported.
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
