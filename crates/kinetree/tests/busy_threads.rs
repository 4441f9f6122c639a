//! A commit does not wait for threads that are busy with something else.
//!
//! No clock: busy threads are let go only when the commit has returned. If it waited for one of
//! them, this would never end.

#![cfg(feature = "parallel")]

mod common;

use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Arc, Barrier, Mutex, Once};

use common::{Random, grid};
use kinetree::{Coherence, Executor, Motion, Ray, Scene, Snapshot, Threads};

/// Of the global pool.
const WORKERS: usize = 3;

fn global_pool() {
    static BUILT: Once = Once::new();
    BUILT.call_once(|| rayon::ThreadPoolBuilder::new().num_threads(WORKERS).build_global().unwrap());
}

/// Enough of everything to share: large meshes of every motion, many small ones, many instances.
fn scene(threads: Threads) -> Scene {
    let mut random = Random::new(7);
    let mut scene = Scene::with_threads(threads);
    let root = scene.root();
    for motion in [Motion::Static, Motion::Rigid, Motion::Deforming, Motion::Dynamic] {
        let mesh = scene.add_mesh(random.soup(20_000, 9.0, 0.3), motion).unwrap();
        for _ in 0..200 {
            scene.add_instance(root, mesh, random.placement(50.0)).unwrap();
        }
    }
    for _ in 0..40 {
        let mesh = scene.add_mesh(grid(3, 1.0), Motion::Deforming).unwrap();
        scene.add_instance(root, mesh, random.placement(50.0)).unwrap();
    }
    scene
}

/// Two commits: everything is built, then everything that bends is moved.
fn commit_twice(scene: &mut Scene) -> [Snapshot; 2] {
    let first = scene.commit();
    let mut random = Random::new(8);
    let moved: Vec<_> = scene.meshes().map(|id| (id, scene.mesh(id).unwrap().positions().to_vec())).collect();
    for (mesh, mut positions) in moved {
        positions.iter_mut().for_each(|position| position[1] += random.within(-0.1, 0.1));
        scene.set_positions(mesh, &positions).unwrap();
    }
    [first, scene.commit()]
}

fn check(views: &[Snapshot; 2]) {
    let alone = commit_twice(&mut scene(Threads::one()));
    for (view, alone) in views.iter().zip(&alone) {
        assert_eq!(view.top_level().tree().nodes(), alone.top_level().tree().nodes());
        for (instance, other) in view.instances().zip(alone.instances()) {
            assert_eq!(instance.bvh().tree().nodes(), other.bvh().tree().nodes());
        }
    }
}

/// Threads that wait until the gate is dropped.
fn gate() -> (Sender<()>, Arc<Mutex<Receiver<()>>>) {
    let (gate, closed) = channel();
    (gate, Arc::new(Mutex::new(closed)))
}

fn wait_at(closed: &Mutex<Receiver<()>>) {
    let _ = closed.lock().unwrap().recv();
}

/// One at a time: each test needs the whole pool.
static ALONE: Mutex<()> = Mutex::new(());

#[test]
fn a_commit_from_outside_finishes_while_the_global_pool_is_busy() {
    let _alone = ALONE.lock();
    global_pool();
    let (gate, closed) = gate();
    let all_busy = Arc::new(Barrier::new(WORKERS + 1));
    let busy = all_busy.clone();
    rayon::spawn_broadcast(move |_| {
        busy.wait();
        wait_at(&closed);
    });
    all_busy.wait();
    let views = commit_twice(&mut scene(Threads::shared()));
    drop(gate);
    check(&views);
}

#[test]
fn a_commit_from_a_worker_finishes_while_the_others_are_busy() {
    let _alone = ALONE.lock();
    global_pool();
    let (gate, closed) = gate();
    let all_busy = Barrier::new(WORKERS);
    let gate = Mutex::new(Some(gate));
    let views = rayon::broadcast(|worker| {
        all_busy.wait();
        if worker.index() > 0 {
            wait_at(&closed);
            return None;
        }
        let views = commit_twice(&mut scene(Threads::shared()));
        drop(gate.lock().unwrap().take());
        Some(views)
    });
    check(&views.into_iter().flatten().next().unwrap());
}

/// Threads of the scene's own, as a game might have them.
struct OwnThreads(rayon::ThreadPool);

impl Executor for OwnThreads {
    fn join(&self, one: &mut (dyn FnMut() + Send), other: &mut (dyn FnMut() + Send)) {
        if self.0.current_thread_index().is_some() {
            // From a thread of the pool, work that has not begun is taken back.
            rayon::join(one, other);
        } else {
            one();
            other();
        }
    }
}

#[test]
fn a_commit_finishes_during_a_parallel_batch_on_the_scenes_own_threads() {
    let _alone = ALONE.lock();
    global_pool();
    let (gate, closed) = gate();
    let all_busy = Arc::new(Barrier::new(WORKERS + 1));
    let (busy, global_closed) = (all_busy.clone(), closed.clone());
    rayon::spawn_broadcast(move |_| {
        busy.wait();
        wait_at(&global_closed);
    });
    all_busy.wait();

    let pool = || rayon::ThreadPoolBuilder::new().num_threads(3).build().unwrap();
    let traced = commit_twice(&mut scene(Threads::one()))[0].clone();
    let mut random = Random::new(9);
    let rays: Vec<Ray> = (0..300).map(|_| Ray::new(random.point(60.0), random.direction())).collect();
    let own = Arc::new(OwnThreads(pool()));
    for (threads, own) in [(Threads::of(own.clone()), &own.0), (Threads::shared(), &pool())] {
        // The others trace, and have not finished their parts of the batch when the commit returns.
        let (own_gate, own_closed) = self::gate();
        let (begun, own_gate) = (Barrier::new(3), Mutex::new(Some(own_gate)));
        let views = own.broadcast(|worker| {
            begun.wait();
            if worker.index() > 0 {
                let mut hits = vec![None; rays.len()];
                traced.closest_hits(&rays[..100], &mut hits[..100], Coherence::Unknown);
                wait_at(&own_closed);
                traced.closest_hits(&rays[100..], &mut hits[100..], Coherence::Unknown);
                return None;
            }
            let mut scene = scene(Threads::one());
            scene.set_threads(threads.clone());
            let views = commit_twice(&mut scene);
            drop(own_gate.lock().unwrap().take());
            Some(views)
        });
        check(&views.into_iter().flatten().next().unwrap());
    }
    drop(gate);
}
