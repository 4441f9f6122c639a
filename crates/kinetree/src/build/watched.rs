//! From triangles to the tree that rays walk, in one go, with somebody watching.

use super::{BuildOptions, triangles};
use crate::geometry::Triangles;
use crate::watch::{Cancelled, Watch};
use crate::wide::MeshBvh;

/// The tree over all triangles that rays walk: [`triangles()`], collapsed. The tree is the same whether or not it is watched.
///
/// ```
/// use kinetree::build::{self, BuildOptions, Watch};
/// use kinetree::geometry::Triangles;
///
/// # let triangles = Triangles::default();
/// let watch = Watch::new();
/// let tree = std::thread::scope(|scope| {
///     let build = scope.spawn(|| build::watched(&triangles, &BuildOptions::default(), &watch));
///     while !build.is_finished() {
///         println!("{:.0} %", watch.progress() * 100.0); // or watch.cancel()
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
pub fn watched(of: &Triangles, options: &BuildOptions, watch: &Watch) -> Result<MeshBvh, Cancelled> {
    let options = BuildOptions { threads: options.threads.watched_by(watch), ..options.clone() };
    let binary = triangles(of, &options);
    let tree = MeshBvh::new_watched(&binary, of, &options.threads);
    watch.finish()?;
    Ok(tree)
}
