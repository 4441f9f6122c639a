//! A hit of one frame is never taken for a hit of another: it is refused, whatever found it.

mod common;

use std::panic::{AssertUnwindSafe, catch_unwind};

use common::{cube, sphere};
use kinetree::simd::Level;
use kinetree::{Affine, Coherence, ForeignHit, Hit, InstanceId, Motion, Ray, Scene, Snapshot};

const CLAIMS: [Coherence; 3] = [Coherence::Coherent, Coherence::Incoherent, Coherence::Unknown];

/// A crate in front of a ball.
fn scene() -> (Scene, [InstanceId; 2]) {
    let mut scene = Scene::new();
    let root = scene.root();
    let meshes = [cube(), sphere(8, 16)].map(|mesh| scene.add_mesh(mesh, Motion::Static).unwrap());
    let at = |z: f32| Affine::from_translation([0.0, 0.0, z]);
    let front = scene.add_instance(root, meshes[0], at(0.0)).unwrap();
    let back = scene.add_instance(root, meshes[1], at(4.0)).unwrap();
    (scene, [front, back])
}

fn ahead(x: f32) -> Ray {
    Ray::new([x, 0.1, -9.0], [0.0, 0.0, 1.0])
}

/// Hits of every way of asking, all of them of rays that hit the crate first.
fn every_kind_of_hit(view: &Snapshot) -> Vec<(String, Hit)> {
    let rays: Vec<Ray> = (0..70).map(|i| ahead(i as f32 * 0.01)).collect();
    let solid = |_: &kinetree::Candidate<'_>| true;
    let mut found = Vec::new();
    for level in Level::available() {
        let view = view.at_level(level);
        let queries = [("without a filter", view.query()), ("with a filter", view.query().filter(&solid))];
        for (kind, query) in queries {
            let mut add = |what: &str, hit: Hit| found.push((format!("{what}, {kind}, {level:?}"), hit));
            add("closest", query.closest_hit(&rays[0]).unwrap());
            query.all_hits(&rays[0]).into_iter().for_each(|hit| add("all", hit));
            add("closest by brute force", query.brute_force().closest_hit(&rays[0]).unwrap());
            query.brute_force().all_hits(&rays[0]).into_iter().for_each(|hit| add("all by brute force", hit));
            for claim in CLAIMS {
                let mut hits = vec![None; rays.len()];
                query.closest_hits(&rays, &mut hits, claim);
                hits.into_iter().for_each(|hit| add(&format!("{claim:?} batch"), hit.unwrap()));
            }
        }
    }
    found
}

#[test]
fn hits_are_resolved_by_their_frame_and_its_clones_and_refused_by_every_other_frame() {
    let (mut scene, [front, _]) = scene();
    let view = scene.commit();
    let hits = every_kind_of_hit(&view);
    // What has the crate's number in later frames is the ball: without a stamp, the wrong instance
    // is named.
    scene.remove_instance(front).unwrap();
    let later = scene.commit();
    let elsewhere = self::scene().0.commit();
    for (what, hit) in hits {
        let id = view.instance_at(hit.instance_index()).id();
        assert_eq!(view.try_instance(&hit).map(|view| view.id()), Ok(id), "{what}");
        assert_eq!(view.clone().instance_id(&hit), id, "{what}");
        assert_eq!(view.at_level(Level::available()[0]).instance_id(&hit), id, "{what}");
        for foreign in [&later, &elsewhere] {
            assert_eq!(foreign.try_instance(&hit).map(|view| view.id()), Err(ForeignHit), "{what}");
        }
    }
}

#[test]
fn a_frame_in_the_memory_of_an_older_one_is_another_frame() {
    let (mut scene, _) = scene();
    let hits: Vec<Hit> = (0..6).map(|_| scene.commit().closest_hit(&ahead(0.0)).unwrap()).collect();
    let last = scene.commit();
    assert_eq!(last.report().allocated, 0, "buffers take turns");
    for hit in hits {
        assert_eq!(last.try_instance(&hit).err(), Some(ForeignHit));
    }
}

#[test]
fn whatever_resolves_a_hit_panics_on_a_foreign_one() {
    let (mut scene, _) = scene();
    let hit = scene.commit().closest_hit(&ahead(0.0)).unwrap();
    let view = scene.commit();
    type Resolve = fn(&Snapshot, &Hit);
    let all: [(&str, Resolve); 6] = [
        ("view", |view, hit| _ = view.instance(hit)),
        ("instance_id", |view, hit| _ = view.instance_id(hit)),
        ("mesh_id", |view, hit| _ = view.mesh_id(hit)),
        ("user_id", |view, hit| _ = view.user_id(hit)),
        ("position", |view, hit| _ = view.position(hit)),
        ("normal", |view, hit| _ = view.normal(hit)),
    ];
    for (name, resolve) in all {
        let own = view.closest_hit(&ahead(0.0)).unwrap();
        resolve(&view, &own);
        let panic = catch_unwind(AssertUnwindSafe(|| resolve(&view, &hit))).expect_err(name);
        let message = panic.downcast_ref::<String>().unwrap_or_else(|| panic!("{name} says what is wrong"));
        assert_eq!(*message, ForeignHit.to_string(), "{name}");
    }
}

#[test]
fn hits_of_equal_frames_are_equal() {
    let (mut scene, _) = scene();
    let [one, other] = [scene.commit(), scene.commit()].map(|view| view.closest_hit(&ahead(0.3)).unwrap());
    assert_eq!(one, other);
    assert!(one.agrees_with(&other));
    let mut moved = other;
    moved.u += 0.1;
    assert_ne!(one, moved);
}
