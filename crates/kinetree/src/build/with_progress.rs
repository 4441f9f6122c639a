//! From triangles to the tree that rays walk, in one go, with somebody watching.

use super::{BuildOptions, build_triangles};
use crate::build_progress::{BuildProgress, Cancelled};
use crate::geometry::Triangles;
use crate::wide::MeshBvh;

/// The tree over all triangles that rays walk: [`build_triangles()`], collapsed. The tree is the same whether or not it is watched.
///
/// ```
/// use kinetree::build::{self, BuildOptions, BuildProgress};
/// use kinetree::geometry::Triangles;
///
/// # let triangles = Triangles::default();
/// let progress = BuildProgress::new();
/// let tree = std::thread::scope(|scope| {
///     let build = scope.spawn(|| build::build_with_progress(&triangles, &BuildOptions::default(), &progress));
///     while !build.is_finished() {
///         println!("{:.0} %", progress.progress() * 100.0); // or progress.cancel()
///         std::thread::yield_now();
///     }
///     build.join().unwrap()
/// });
/// assert_eq!(tree?.primitive_count(), triangles.len());
/// # Ok::<(), build::Cancelled>(())
/// ```
///
/// # Errors
/// The watch called it off, before it began or since.
///
/// # Panics
/// When there are more triangles than 2^27.
pub fn build_with_progress(
    of: &Triangles,
    options: &BuildOptions,
    progress: &BuildProgress,
) -> Result<MeshBvh, Cancelled> {
    let options = BuildOptions { threads: options.threads.with_progress(progress), ..options.clone() };
    let binary = build_triangles(of, &options);
    let tree = MeshBvh::new_on(&binary, of, &options.threads);
    progress.finish()?;
    Ok(tree)
}
