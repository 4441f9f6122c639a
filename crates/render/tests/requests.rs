//! Requests to `render`: sizes, samples, threads, progress.

mod common;

use std::ops::ControlFlow;
use std::sync::Mutex;

use common::{Model, Shape, settings};
use kinetree::Affine;
use kinetree_render::{
    IntegratorKind, Progress, RenderError, Settings, automatic_exposure, encode_srgb, render, tone_map,
};
use kinetree_world::{Camera, Frame, Material};

fn frame() -> Frame {
    Model::under(1.0).with(&Shape::cube(), Material::diffuse([0.5; 3]), Affine::IDENTITY).frame()
}

fn camera() -> Camera {
    Camera::look_at([3.0, 2.0, 4.0], [0.0; 3], 0.8)
}

#[test]
fn absurd_pictures_are_errors() {
    let ask = |settings: Settings| render(&frame(), &camera(), &settings, &|_| ControlFlow::Continue(())).map(|_| ());
    let base = settings(IntegratorKind::Normals, 8, 1);
    for (width, height) in [(0, 8), (8, 0), (65_537, 1), (1, u32::MAX), (65_536, 65_536)] {
        assert_eq!(ask(Settings { width, height, ..base.clone() }), Err(RenderError::Size { width, height }));
    }
    assert_eq!(ask(Settings { spp: 0, ..base.clone() }), Err(RenderError::Samples { spp: 0, first: 0 }));
    let first = u32::MAX;
    assert_eq!(ask(Settings { first_sample: first, ..base.clone() }), Err(RenderError::Samples { spp: 1, first }));
    for count in [0, usize::MAX] {
        let answer = ask(Settings { threads: Some(count), ..base.clone() });
        assert!(matches!(answer, Err(RenderError::Threads { .. })), "{answer:?}");
    }
    assert_eq!(ask(base), Ok(()));
}

#[test]
fn progress_counts_every_tile_and_may_stop() {
    let settings = Settings { width: 70, height: 33, ..settings(IntegratorKind::Normals, 0, 1) };
    let seen = Mutex::new(Vec::new());
    let note = |progress: Progress| {
        seen.lock().expect("no thread panicked").push(progress);
        ControlFlow::Continue(())
    };
    render(&frame(), &camera(), &settings, &note).expect("a picture");
    let mut seen = seen.into_inner().expect("no thread panicked");
    seen.sort_unstable_by_key(|progress| progress.done);
    let expected: Vec<_> = (1..=15).map(|done| Progress { done, total: 15 }).collect();
    assert_eq!(seen, expected);

    let stop = |_| ControlFlow::Break(());
    assert_eq!(render(&frame(), &camera(), &settings, &stop).map(|_| ()), Err(RenderError::Stopped));
}

#[test]
fn a_world_without_anything_is_its_sky() {
    let empty = Model::under(0.25).frame();
    for kind in IntegratorKind::ALL {
        let picture = common::picture(&empty, &camera(), &settings(kind, 8, 2));
        if !picture.is_display_ready {
            assert!(picture.film.pixels().iter().all(|pixel| (pixel[0] - 0.25).abs() < 1e-6), "{kind}");
        }
    }
}

#[test]
fn film_becomes_srgb_bytes() {
    let picture = common::picture(&frame(), &camera(), &settings(IntegratorKind::Path, 8, 2));
    assert!(!picture.is_display_ready);
    assert_eq!(tone_map(&picture.film, automatic_exposure(&picture.film)).len(), 8 * 8 * 3);
    let picture = common::picture(&frame(), &camera(), &settings(IntegratorKind::Ids, 8, 2));
    assert!(picture.is_display_ready);
    assert_eq!(encode_srgb(&picture.film).len(), 8 * 8 * 3);
}

#[test]
fn only_clamping_loses_light() {
    // A closed bright room: contributions from beyond the first bounce are clamped if asked for,
    // and only then.
    let material = Material { emission: [1.0; 3], ..Material::diffuse([0.5; 3]) };
    let room = Model::default().with(&Shape::cube().inverted(), material, Affine::IDENTITY).frame();
    let inside = Camera::look_at([0.0; 3], [1.0, 0.2, 0.1], 1.0);
    let mean = |clamp| {
        let settings = Settings { clamp, ..settings(IntegratorKind::Path, 8, 64) };
        common::picture(&room, &inside, &settings).film.mean()[0]
    };
    assert!(mean(Some(0.01)) < 1.8 && (mean(None) - 2.0).abs() < 0.05);
}
