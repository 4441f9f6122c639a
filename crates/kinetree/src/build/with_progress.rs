//! Building the eight-way tree over triangles, with progress and cancellation.

use super::{BuildOptions, build_triangles};
use crate::build_progress::{BuildProgress, Cancelled};
use crate::geometry::Triangles;
use crate::wide::MeshBvh;

/// Builds the eight-way tree over all triangles: [`build_triangles()`], collapsed. The tree does
/// not depend on `progress`.
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
/// `progress` was cancelled.
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
