//! The progress of a build rises, the tree does not depend on it, and it can be cancelled.

mod common;

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::time::Duration;

use common::{Backwards, Random, grid};
use kinetree::build::{self, BuildOptions, BuildProgress, Cancelled, Quality};
use kinetree::geometry::Triangles;
use kinetree::{Executor, Mesh, MeshBvh, Threads};

const QUALITIES: [Quality; 4] = [Quality::Fastest, Quality::Fast, Quality::Balanced, Quality::Best];

fn triangles_of(mesh: &Mesh) -> Triangles {
    Triangles::new(mesh.positions().to_vec(), mesh.triangles().into()).unwrap()
}

fn options(quality: Quality, threads: Threads) -> BuildOptions {
    let mut options = BuildOptions::default();
    (options.quality, options.threads) = (quality, threads);
    options
}

/// Builds, while another thread looks on and may cancel when so much is done. Gives what was seen.
fn build_and_look(
    triangles: &Triangles,
    options: &BuildOptions,
    cancel_at: f32,
) -> (Result<MeshBvh, Cancelled>, Vec<f32>) {
    let (progress, ended) = (BuildProgress::new(), AtomicBool::new(false));
    std::thread::scope(|scope| {
        let looker = scope.spawn(|| {
            let mut seen = vec![];
            while !ended.load(Ordering::Acquire) {
                seen.push(progress.progress());
                if progress.progress() >= cancel_at {
                    progress.cancel();
                }
                std::thread::sleep(Duration::from_micros(100));
            }
            seen.push(progress.progress());
            seen
        });
        let built = build::build_with_progress(triangles, options, &progress);
        ended.store(true, Ordering::Release);
        (built, looker.join().unwrap())
    })
}

#[test]
fn a_watched_build_gives_the_same_tree_and_only_ever_comes_nearer() {
    let soup = Random::new(1).soup(60_000, 3.0, 0.1);
    for geometry in
        [triangles_of(&soup), triangles_of(&grid(100, 1.0)), triangles_of(&grid(1, 1.0)), Triangles::default()]
    {
        for quality in QUALITIES {
            let alone = options(quality, Threads::one());
            let expected = MeshBvh::new(&build::build_triangles(&geometry, &alone), &geometry);
            for threads in [Threads::one(), Threads::default(), Threads::of(Arc::new(Backwards))] {
                let (built, seen) = build_and_look(&geometry, &options(quality, threads), f32::INFINITY);
                let built = built.unwrap();
                assert_eq!(built.tree().nodes(), expected.tree().nodes(), "{quality:?}");
                assert_eq!(format!("{:?}", built.blocks().first()), format!("{:?}", expected.blocks().first()));
                assert!(seen.is_sorted(), "{quality:?}: {seen:?}");
                assert_eq!(seen.last(), Some(&1.0), "{quality:?}");
            }
        }
    }
}

/// Looks at the watch after every job.
struct Looking {
    progress: BuildProgress,
    seen: Mutex<Vec<f32>>,
}

impl Executor for Looking {
    fn join(&self, one: &mut (dyn FnMut() + Send), other: &mut (dyn FnMut() + Send)) {
        one();
        self.seen.lock().unwrap().push(self.progress.progress());
        other();
        self.seen.lock().unwrap().push(self.progress.progress());
    }
}

#[test]
fn progress_is_seen_on_the_way() {
    let geometry = triangles_of(&grid(300, 1.0));
    for quality in QUALITIES {
        let progress = BuildProgress::new();
        let looking = Arc::new(Looking { progress: progress.clone(), seen: Mutex::default() });
        build::build_with_progress(&geometry, &options(quality, Threads::of(looking.clone())), &progress).unwrap();
        let mut seen = looking.seen.lock().unwrap().clone();
        assert!(seen.is_sorted(), "{quality:?}: {seen:?}");
        seen.dedup();
        assert!(seen.len() >= 10, "{quality:?}: {seen:?}");
        // No step is more than a fifth of the whole.
        let steps = seen.windows(2).map(|pair| pair[1] - pair[0]);
        assert!(steps.fold(0.0, f32::max) < 0.2, "{quality:?}: {seen:?}");
        assert!(seen[0] < 0.2 && seen[seen.len() - 1] > 0.6 && seen[seen.len() - 1] < 1.0, "{quality:?}: {seen:?}");
    }
}

#[test]
fn a_build_that_is_cancelled_on_the_way_gives_no_tree_wherever_it_is() {
    for geometry in [triangles_of(&grid(150, 1.0)), triangles_of(&Random::new(2).soup(30_000, 1.0, 0.4))] {
        let before = geometry.fingerprint();
        for quality in QUALITIES {
            for percent in (0..100).step_by(7) {
                let threads = if percent % 2 == 0 { Threads::one() } else { Threads::default() };
                let (built, seen) = build_and_look(&geometry, &options(quality, threads), percent as f32 / 100.0);
                // Who cancels late may be too late.
                match built {
                    Ok(tree) => assert_eq!(tree.validate(), Ok(()), "{quality:?} at {percent} %"),
                    Err(Cancelled) => assert!(*seen.last().unwrap() < 1.0, "{quality:?} at {percent} %"),
                }
            }
        }
        assert_eq!(geometry.fingerprint(), before);
    }
}

#[test]
fn a_build_that_is_cancelled_beforehand_never_begins() {
    let geometry = triangles_of(&grid(20, 1.0));
    let progress = BuildProgress::new();
    progress.cancel();
    for quality in QUALITIES {
        let built = build::build_with_progress(&geometry, &options(quality, Threads::default()), &progress);
        assert_eq!(built.err(), Some(Cancelled), "{quality:?}");
    }
    assert!(progress.progress() < 1.0);
}

/// Calls a build off when it has come so far, and runs one job after the other.
struct Cancelling {
    progress: BuildProgress,
    at: f32,
    /// How far the build was when it was called off.
    was: Mutex<Option<f32>>,
}

impl Cancelling {
    fn look(&self) {
        let mut was = self.was.lock().unwrap();
        if was.is_none() && self.progress.progress() >= self.at {
            self.progress.cancel();
            *was = Some(self.progress.progress());
        }
    }
}

impl Executor for Cancelling {
    fn join(&self, one: &mut (dyn FnMut() + Send), other: &mut (dyn FnMut() + Send)) {
        one();
        self.look();
        other();
        self.look();
    }
}

#[test]
fn a_build_that_is_cancelled_does_hardly_anything_more() {
    let geometry = triangles_of(&grid(200, 1.0));
    for quality in QUALITIES {
        let mut cancelled = 0;
        for percent in 1..100 {
            let (progress, at) = (BuildProgress::new(), percent as f32 / 100.0);
            let cancelling = Arc::new(Cancelling { progress: progress.clone(), at, was: Mutex::new(None) });
            let built =
                build::build_with_progress(&geometry, &options(quality, Threads::of(cancelling.clone())), &progress);
            let Some(was) = *cancelling.was.lock().unwrap() else { continue };
            assert_eq!(built.err(), Some(Cancelled), "{quality:?} at {percent} %");
            let more = progress.progress() - was;
            assert!(more <= 0.01, "{quality:?}: cancelled at {was}, went on to {}", progress.progress());
            cancelled += 1;
        }
        // Beyond that, nothing is shared between threads any more.
        assert!(cancelled >= 60, "{quality:?}: cancelled only {cancelled} times");
    }
}
