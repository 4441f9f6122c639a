//! Trees of meshes that move stay good: rays do little more work than through trees that are built
//! anew for the same pose.

mod common;

use common::{Random, sphere};
use kinetree::{
    Action, Affine, Mesh, MeshId, MeshReport, Motion, Pose, Ray, Reason, Scene, Skin, Snapshot, Threads, Work,
};

/// Rays are aimed at this many points of the box around everything.
const RAYS: usize = 400;

/// How much more work a ray may be than through a tree that is built for the pose.
const MOST: f64 = 1.3;

/// Triangles that share no vertices, in an order that has nothing to do with where they are.
struct Loose {
    /// The corners of each triangle relative to its centre.
    corners: Vec<[[f32; 3]; 3]>,
    centres: Vec<[f32; 3]>,
}

impl Loose {
    /// The triangles of a mesh, shuffled.
    fn of(mesh: &Mesh, random: &mut Random) -> Self {
        let mut triangles = mesh.triangles().to_vec();
        for last in (1..triangles.len()).rev() {
            triangles.swap(last, random.below(last + 1));
        }
        let (mut corners, mut centres) = (Vec::new(), Vec::new());
        for triangle in triangles {
            let at = triangle.map(|vertex| mesh.positions()[vertex as usize]);
            let centre = [0, 1, 2].map(|axis| (at[0][axis] + at[1][axis] + at[2][axis]) / 3.0);
            corners.push(at.map(|corner| [0, 1, 2].map(|axis| corner[axis] - centre[axis])));
            centres.push(centre);
        }
        Self { corners, centres }
    }

    fn soup(triangles: usize, spread: f32, size: f32, random: &mut Random) -> Self {
        Self::of(&random.soup(triangles, spread, size), random)
    }

    /// The vertices when the centres are elsewhere, and the triangles scaled.
    fn positions(&self, scale: f32, centre_of: impl Fn(usize, [f32; 3]) -> [f32; 3]) -> Vec<[f32; 3]> {
        let mut positions = Vec::with_capacity(3 * self.centres.len());
        for (number, (corners, centre)) in self.corners.iter().zip(&self.centres).enumerate() {
            let centre = centre_of(number, *centre);
            positions.extend(corners.map(|corner| [0, 1, 2].map(|axis| centre[axis] + scale * corner[axis])));
        }
        positions
    }

    fn mesh(&self, positions: &[[f32; 3]]) -> Mesh {
        let indices: Vec<u32> = (0..positions.len() as u32).collect();
        Mesh::new(positions, &indices).unwrap()
    }
}

fn scaled(p: [f32; 3], scale: f32) -> [f32; 3] {
    p.map(|x| x * scale)
}

/// A scene of one mesh.
fn alone(mesh: Mesh) -> (Scene, MeshId) {
    let mut scene = Scene::with_threads(Threads::one());
    let id = scene.add_mesh(mesh, Motion::Deforming).unwrap();
    scene.add_instance(scene.root(), id, Affine::IDENTITY).unwrap();
    (scene, id)
}

/// Visits of nodes and tests of blocks per ray, along lines through the box around everything.
fn steps(view: &Snapshot) -> f64 {
    let mut random = Random::new(77);
    let bounds = view.bounds();
    let extent = [0, 1, 2].map(|axis| bounds.max[axis] - bounds.min[axis]);
    let reach = extent.iter().fold(0.0_f32, |most, x| most.max(*x)).max(1e-6);
    let mut work = Work::default();
    for _ in 0..RAYS {
        let target = [0, 1, 2].map(|axis| bounds.min[axis] + extent[axis] * random.unit());
        let direction = random.direction();
        let origin = [0, 1, 2].map(|axis| target[axis] - 2.0 * reach * direction[axis]);
        view.query().closest_hit_counted(&Ray::new(origin, direction), &mut work);
    }
    (work.nodes + work.blocks) as f64 / RAYS as f64
}

/// The work of rays through the only instance of a snapshot, over that through a tree that is built
/// for the same triangles.
fn excess(view: &Snapshot) -> f64 {
    let seen = view.instance_at(0);
    let (mut scene, _) = alone(Mesh::new(seen.positions(), seen.triangles()).unwrap());
    steps(view) / steps(&scene.commit())
}

fn report(view: &Snapshot) -> &MeshReport {
    &view.report().meshes[0]
}

/// What a motion took.
#[derive(Debug, Default)]
struct Kept {
    rebuilds: usize,
    comparisons: usize,
    worst: f64,
    worst_frame: usize,
}

/// Plays a motion whose frame 0 is the build, and looks at every so manieth frame.
fn play(frames: usize, look_every: usize, pose: impl Fn(usize) -> Vec<[f32; 3]>) -> Kept {
    let start = pose(0);
    let indices: Vec<u32> = (0..start.len() as u32).collect();
    let (mut scene, mesh) = alone(Mesh::new(&start, &indices).unwrap());
    scene.commit();
    let mut kept = Kept::default();
    for frame in 1..=frames {
        scene.set_positions(mesh, &pose(frame)).unwrap();
        let view = scene.commit();
        kept.rebuilds += usize::from(report(&view).action == Action::Rebuilt);
        kept.comparisons += usize::from(report(&view).compared);
        if frame % look_every == 0 {
            let excess = excess(&view);
            if excess > kept.worst {
                (kept.worst, kept.worst_frame) = (excess, frame);
            }
        }
    }
    kept
}

#[track_caller]
fn check(name: &str, kept: &Kept, most_rebuilds: usize) {
    println!("{name}: {kept:?}");
    assert!(kept.worst <= MOST, "{name}: {kept:?}");
    assert!(kept.rebuilds <= most_rebuilds, "{name}: {kept:?}");
    assert!(kept.comparisons <= 2 * most_rebuilds, "{name}: {kept:?}");
}

#[test]
fn a_mesh_that_grows_from_a_millimetre_is_traced_as_a_fresh_one() {
    let mut random = Random::new(0x5eed_0301);
    let grown = Loose::soup(3000, 10.0, 0.2, &mut random);
    let seeds: Vec<[f32; 3]> = (0..9000).map(|_| random.point(0.0005)).collect();
    let end = grown.positions(1.0, |_, centre| centre);
    let towards = |share: f32| {
        seeds.iter().zip(&end).map(|(a, b)| [0, 1, 2].map(|axis| a[axis] + (b[axis] - a[axis]) * share)).collect()
    };
    check("steadily", &play(100, 10, |frame| towards(frame as f32 / 100.0)), 10);
    check("by the same ratio", &play(100, 10, |frame| towards(1e-5_f32.powf(1.0 - frame as f32 / 100.0))), 10);
    check("at once", &play(10, 1, |frame| towards(frame.min(1) as f32)), 2);
    let size = |frame: usize| 1e-4_f32.powf(1.0 - frame as f32 / 100.0);
    check("as it is", &play(100, 10, |frame| grown.positions(size(frame), |_, p| scaled(p, size(frame)))), 10);
}

#[test]
fn a_mesh_that_explodes_and_returns_is_traced_as_a_fresh_one() {
    let mut random = Random::new(0x5eed_0302);
    let whole = Loose::of(&sphere(30, 50), &mut random);
    let speed: Vec<f32> = (0..3000).map(|_| random.within(0.2, 1.0)).collect();
    let turn: Vec<[f32; 3]> = (0..3000).map(|_| random.direction()).collect();
    let explode = |far: f32, aside: f32, periods: f32| {
        let (speed, turn, whole) = (&speed, &turn, &whole);
        move |frame: usize| {
            let wave = (std::f32::consts::PI * periods * frame as f32 / 1000.0).sin();
            let out = far * wave * wave;
            whole.positions(1.0, |number, p| {
                [0, 1, 2].map(|axis| p[axis] + out * speed[number] * (p[axis] + aside * turn[number][axis]))
            })
        }
    };
    check("outwards", &play(1000, 50, explode(8.0, 0.0, 1.0)), 10);
    check("a little aside", &play(1000, 50, explode(8.0, 0.3, 1.0)), 10);
    // Neighbours come among others altogether, and back: that takes more trees.
    check("in all directions", &play(1000, 50, explode(8.0, 1.0, 1.0)), 20);
    check("again and again", &play(1000, 50, explode(8.0, 0.0, 5.0)), 25);
}

#[test]
fn a_mesh_that_breathes_is_traced_as_a_fresh_one() {
    let mut random = Random::new(0x5eed_0303);
    let cloud = Loose::soup(3000, 3.0, 0.3, &mut random);
    let breath = |frame: usize| 2.0_f32.powf((frame as f32 * std::f32::consts::TAU / 110.0).sin());
    check("as a whole", &play(1000, 50, |frame| cloud.positions(breath(frame), |_, p| scaled(p, breath(frame)))), 10);
    check("between its triangles", &play(1000, 50, |frame| cloud.positions(1.0, |_, p| scaled(p, breath(frame)))), 10);
    check(
        "along one axis",
        &play(1000, 50, |frame| cloud.positions(1.0, |_, p| [p[0] * breath(frame), p[1], p[2]])),
        10,
    );
    check("its triangles alone", &play(1000, 50, |frame| cloud.positions(breath(frame), |_, p| p)), 10);
}

#[test]
fn a_swirl_is_rebuilt_before_it_costs_much() {
    let mut random = Random::new(0x5eed_0304);
    let cloud = Loose::soup(3000, 3.0, 0.2, &mut random);
    let swirl = |speed: f32| {
        let cloud = &cloud;
        move |frame: usize| {
            cloud.positions(1.0, |_, p| {
                let angle = speed * frame as f32 * (3.0 - (p[0] * p[0] + p[2] * p[2]).sqrt());
                [p[0] * angle.cos() - p[2] * angle.sin(), p[1], p[0] * angle.sin() + p[2] * angle.cos()]
            })
        }
    };
    check("slow", &play(500, 50, swirl(0.002)), 10);
    check("fast", &play(100, 10, swirl(0.02)), 10);
}

#[test]
fn a_mesh_that_was_crumpled_when_it_was_built_is_good_once_it_is_smooth() {
    let mut random = Random::new(0x5eed_0305);
    let sheet = common::grid(40, 4.0);
    let crumpled: Vec<[f32; 3]> = sheet.positions().iter().map(|_| random.point(1.0)).collect();
    let loose = |positions: &[[f32; 3]]| -> Vec<[f32; 3]> {
        sheet.triangles().iter().flatten().map(|&vertex| positions[vertex as usize]).collect()
    };
    let (from, to) = (loose(&crumpled), loose(sheet.positions()));
    for frames in [1, 10, 60] {
        let pose = |frame: usize| {
            let share = (frame as f32 / frames as f32).min(1.0);
            from.iter().zip(&to).map(|(a, b)| [0, 1, 2].map(|axis| a[axis] + (b[axis] - a[axis]) * share)).collect()
        };
        let kept = play(frames + 5, frames + 5, pose);
        check(&format!("in {frames} frames"), &kept, 10);
    }
}

/// One frame of a mesh, as good as fresh.
#[track_caller]
fn assert_good(name: &str, view: &Snapshot) {
    let excess = excess(view);
    println!("{name}: {excess:.2}, {:?}", report(view));
    assert!(excess <= MOST, "{name}: {excess}, {:?}", report(view));
}

#[test]
fn a_mesh_that_was_all_zero_when_it_was_built_is_good_once_it_is_filled() {
    let mut random = Random::new(0x5eed_0306);
    let cloud = Loose::soup(3000, 50.0, 1.0, &mut random);
    let filled = cloud.positions(1.0, |_, p| p);
    for zeros in 0..4 {
        let (mut scene, mesh) = alone(cloud.mesh(&vec![[0.0; 3]; filled.len()]));
        scene.commit();
        for _ in 0..zeros {
            scene.set_positions(mesh, &vec![[0.0; 3]; filled.len()]).unwrap();
            let view = scene.commit();
            assert_eq!((report(&view).action, report(&view).compared), (Action::Refitted, false));
        }
        scene.set_positions(mesh, &filled).unwrap();
        assert_good(&format!("after {zeros} more of nothing"), &scene.commit());
    }
}

#[test]
fn a_frame_without_area_neither_measures_nor_rebuilds() {
    let mut random = Random::new(0x5eed_0307);
    let cloud = Loose::soup(20_000, 50.0, 1.0, &mut random);
    let whole = cloud.positions(1.0, |_, p| p);
    let (mut scene, mesh) = alone(cloud.mesh(&whole));
    let built = steps(&scene.commit());
    type Place = fn([f32; 3]) -> [f32; 3];
    let all: [(&str, Place); 4] = [
        ("a point", |_| [0.0; 3]),
        ("another point", |_| [3.0, -7.0, 1e4]),
        ("a line", |p| [p[0], 2.0, 2.0]),
        ("beyond all areas", |p| p.map(|x| 3e38 * x.signum())),
    ];
    for (name, place) in all {
        for _ in 0..3 {
            let spoilt: Vec<[f32; 3]> = whole.iter().map(|p| place(*p)).collect();
            scene.set_positions(mesh, &spoilt).unwrap();
            let view = scene.commit();
            let MeshReport { action, compared, drift, .. } = report(&view);
            assert_eq!((*action, *compared, *drift), (Action::Refitted, false, 1.0), "{name}");
        }
        scene.set_positions(mesh, &whole).unwrap();
        let view = scene.commit();
        assert_eq!((report(&view).action, report(&view).drift), (Action::Refitted, 1.0), "after {name}");
        assert_eq!(steps(&view), built, "after {name}");
    }
}

#[test]
fn a_skinned_mesh_that_was_scaled_to_nothing_is_good_once_it_is_back() {
    let mut random = Random::new(0x5eed_0308);
    let ball = Loose::of(&sphere(60, 80), &mut random);
    let rest = ball.positions(1.0, |_, p| p);
    let skin = Skin { joints: vec![[0; 4]; rest.len()], weights: vec![[1.0, 0.0, 0.0, 0.0]; rest.len()] };
    let place = Affine::from_translation([2.0, 1.0, 0.0]);
    let sized = |size: f32| place * Affine::from_scale([size; 3]);
    // Hidden from the start, for a while in the middle, and while it is shown small by small.
    for sizes in [&[0.0, 1.0][..], &[0.0, 0.0, 0.0, 1.0], &[1.0, 0.0, 0.0, 1.0], &[0.0, 1e-3, 0.1, 0.5, 1.0]] {
        let (mut scene, mesh) = alone(ball.mesh(&rest).with_skin(skin.clone()).unwrap());
        for &size in sizes {
            scene.pose(mesh, &Pose { weights: &[], joints: &[sized(size)] }).unwrap();
            let view = scene.commit();
            if size > 0.0 {
                assert_good(&format!("{sizes:?} at {size}"), &view);
            }
        }
    }
    // The same of clones, which share the tree of the rest pose.
    let shown = ball.mesh(&rest).with_skin(skin).unwrap();
    let mut scene = Scene::new();
    let clones = [(); 3].map(|()| {
        let id = scene.add_mesh(shown.clone(), Motion::Deforming).unwrap();
        scene.add_instance(scene.root(), id, Affine::IDENTITY).unwrap();
        id
    });
    for size in [0.0, 0.0, 1.0] {
        for &clone in &clones {
            scene.pose(clone, &Pose { weights: &[], joints: &[sized(size)] }).unwrap();
        }
        scene.commit();
    }
    let view = scene.commit();
    assert_eq!(view.report().count(Action::Kept), 3);
    let fresh = {
        let (mut scene, mesh) = alone(shown);
        scene.commit();
        scene.pose(mesh, &Pose { weights: &[], joints: &[sized(1.0)] }).unwrap();
        scene.commit()
    };
    let cost = |view: &Snapshot, at: u32| view.instance_at(at).bvh().cost(1.0, 1.0);
    (0..3).for_each(|at| assert!(cost(&view, at) < 1.1 * cost(&fresh, 0), "clone {at}"));
}

#[test]
fn a_rebuild_is_made_when_it_is_asked_for() {
    for motion in [Motion::Static, Motion::Rigid, Motion::Deforming, Motion::Dynamic] {
        let mut scene = Scene::new();
        let mesh = scene.add_mesh(sphere(10, 12), motion).unwrap();
        scene.rebuild(mesh).unwrap();
        let did = |view: &Snapshot| (report(view).action, report(view).reason);
        assert_eq!(did(&scene.commit()), (Action::Built, Reason::New));
        assert_eq!(did(&scene.commit()), (Action::Kept, Reason::NothingChanged));
        scene.rebuild(mesh).unwrap();
        assert_eq!(did(&scene.commit()), (Action::Rebuilt, Reason::Requested));
        assert_eq!(did(&scene.commit()), (Action::Kept, Reason::NothingChanged));
        let moved: Vec<_> = sphere(10, 12).positions().iter().map(|p| scaled(*p, 1.5)).collect();
        scene.set_positions(mesh, &moved).unwrap();
        scene.rebuild(mesh).unwrap();
        let instance = scene.add_instance(scene.root(), mesh, Affine::IDENTITY).unwrap();
        let view = scene.commit();
        assert_eq!(did(&view), (Action::Rebuilt, Reason::Requested));
        assert_eq!(view.instance_at(0).positions(), moved);
        assert_eq!(view.instance_at(0).bvh().validate(), Ok(()));
        scene.remove_instance(instance).unwrap();
        scene.remove_mesh(mesh).unwrap();
        assert!(scene.rebuild(mesh).is_err());
    }
}

#[test]
fn a_report_says_which_drift_caused_a_rebuild() {
    let mut random = Random::new(0x5eed_0309);
    let cloud = Loose::soup(2000, 5.0, 0.2, &mut random);
    let (mut scene, mesh) = alone(cloud.mesh(&cloud.positions(1.0, |_, p| p)));
    assert_eq!(report(&scene.commit()).drift, 1.0);
    let elsewhere: Vec<[f32; 3]> = (0..2000).map(|_| random.point(5.0)).collect();
    scene.set_positions(mesh, &cloud.positions(1.0, |number, _| elsewhere[number])).unwrap();
    let view = scene.commit();
    assert_eq!((report(&view).action, report(&view).reason), (Action::Rebuilt, Reason::Drifted));
    assert!(report(&view).compared && report(&view).drift > 2.0, "{:?}", report(&view));
    assert_eq!(report(&scene.commit()).drift, 1.0);
}
