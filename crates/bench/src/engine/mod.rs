//! The ray tracers that are measured: kinetree, and those that it is compared with.

#[cfg(feature = "bvh")]
mod bvh;
#[cfg(all(feature = "embree", unix))]
mod embree;
mod interface;
mod kinetree;
#[cfg(any(feature = "bvh", feature = "parry3d", feature = "obvhs"))]
mod moller_trumbore;
#[cfg(feature = "obvhs")]
mod obvhs;
#[cfg(feature = "parry3d")]
mod parry;
#[cfg(all(feature = "embree", unix))]
mod sorted;
mod thread_pool;
#[cfg(all(feature = "tinybvh", target_arch = "x86_64"))]
mod tinybvh;

use ::kinetree::simd::Level;

pub(crate) use self::interface::{Batch, Class, Engine, Mode, Prepared, Refit, Tree};
pub(crate) use self::kinetree::{FAST_PRECISION_SUFFIX, Reference};
pub(crate) use self::thread_pool::ThreadPool;
use crate::level::OWN_BUILD;

/// All engines that this program was compiled with and that are available on this machine, forced
/// to the level of the library where possible; and notes with versions, instructions, and why other
/// engines are missing.
pub(crate) fn all() -> (Vec<Box<dyn Engine>>, Vec<String>) {
    #[allow(unused_mut)]
    let (mut engines, mut notes): (Vec<Box<dyn Engine>>, Vec<String>) = (kinetree::variants(), Vec::new());
    #[cfg(all(feature = "embree", unix))]
    match embree::variants(Level::current()) {
        Ok((more, note)) => {
            engines.extend(more);
            notes.push(note);
        }
        Err(failure) => notes.push(format!("without Embree: {failure}; `fetch-peers` brings it")),
    }
    #[cfg(all(feature = "tinybvh", target_arch = "x86_64"))]
    match tinybvh::variants() {
        Ok(more) => {
            engines.extend(more);
            notes.push(format!("with tinybvh, {OWN_BUILD}: compiled for {}", tinybvh::compiled_for()));
        }
        Err(failure) => notes.push(format!("without tinybvh: {failure}")),
    }
    #[cfg(feature = "obvhs")]
    engines.extend(obvhs::variants());
    #[cfg(feature = "parry3d")]
    engines.extend(parry::variants());
    #[cfg(feature = "bvh")]
    engines.extend(bvh::variants());
    #[cfg(any(feature = "obvhs", feature = "parry3d", feature = "bvh"))]
    notes.push(format!("with peers in Rust, {OWN_BUILD}: compiled for {}, as this program is", compiled_for()));
    for (compiled, name) in [
        (cfg!(feature = "embree"), "Embree"),
        (cfg!(feature = "tinybvh"), "tinybvh"),
        (cfg!(feature = "obvhs"), "obvhs"),
        (cfg!(feature = "parry3d"), "parry3d"),
        (cfg!(feature = "bvh"), "bvh"),
    ] {
        if !compiled {
            notes.push(format!("without {name}: not compiled in"));
        }
    }
    (engines, notes)
}

/// The instructions that Rust code without run-time detection uses: the baseline of the target,
/// unless the compiler was told otherwise.
#[cfg(any(feature = "obvhs", feature = "parry3d", feature = "bvh"))]
fn compiled_for() -> String {
    let more: [(bool, &str); 3] = [
        (cfg!(target_feature = "avx512f"), "AVX-512"),
        (cfg!(target_feature = "avx2"), "AVX2"),
        (cfg!(target_feature = "sse4.2"), "SSE4.2"),
    ];
    let most = more.into_iter().find(|(there, _)| *there);
    let architecture = std::env::consts::ARCH.replace('_', "-");
    most.map_or(architecture.clone(), |(_, name)| format!("{architecture} with {name}"))
}
