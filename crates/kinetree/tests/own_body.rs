//! Queries leave out one's own body: an instance, or all that is below a node, whatever else they
//! ask for.

mod common;

use std::collections::HashMap;

use common::{Random, cube, grid, sphere};
use kinetree::simd::Level;
use kinetree::{
    Affine, Candidate, Coherence, Cull, Hit, InstanceId, Motion, NodeId, Placed, Query, Ray, Scene, Snapshot, Work,
};

const CLAIMS: [Coherence; 3] = [Coherence::Coherent, Coherence::Incoherent, Coherence::Unknown];

/// A vehicle of nested nodes among crates, on a ground, beside another vehicle of the same meshes.
struct Traffic {
    scene: Scene,
    /// What rays leave out: nodes high and low, instances.
    bodies: Vec<Placed>,
    crates: Vec<InstanceId>,
}

/// Chassis, cabin and wheels; two steps from the vehicle to a wheel. Nodes first, then instances.
fn add_vehicle(scene: &mut Scene, at: Affine) -> Vec<Placed> {
    let [hull, ball] = [cube(), sphere(6, 10)].map(|mesh| scene.add_mesh(mesh, Motion::Rigid).unwrap());
    let vehicle = scene.add_node(scene.root(), at).unwrap();
    let mut bodies: Vec<Placed> = vec![vehicle.into()];
    let mut instances = vec![scene.add_instance(vehicle, hull, Affine::from_scale([2.0, 0.6, 1.2])).unwrap()];
    let cabin = scene.add_node(vehicle, Affine::from_translation([0.0, 0.9, 0.0])).unwrap();
    instances.push(scene.add_instance(cabin, hull, Affine::from_scale([0.9, 0.4, 0.9])).unwrap());
    bodies.push(cabin.into());
    for (x, z) in [(-1.4, -1.3), (-1.4, 1.3), (1.4, -1.3), (1.4, 1.3)] {
        let suspension = scene.add_node(vehicle, Affine::from_translation([x, -0.5, z])).unwrap();
        let wheel = scene.add_node(suspension, Affine::from_axis_angle([0.0, 0.0, 1.0], x)).unwrap();
        instances.push(scene.add_instance(wheel, ball, Affine::from_scale([0.5, 0.5, 0.2])).unwrap());
        instances.push(scene.add_instance(wheel, ball, Affine::from_scale([0.1, 0.1, 0.4])).unwrap());
        bodies.extend([Placed::from(suspension), wheel.into()]);
    }
    // Nothing hangs on this.
    bodies.push(scene.add_node(cabin, Affine::IDENTITY).unwrap().into());
    for (at, instance) in instances.iter().enumerate() {
        scene.set_opaque(*instance, at % 3 != 1).unwrap();
    }
    bodies.extend(instances.into_iter().map(Placed::from));
    bodies
}

fn traffic() -> Traffic {
    let mut scene = Scene::new();
    let root = scene.root();
    let ground = scene.add_mesh(grid(6, 30.0), Motion::Static).unwrap();
    scene.add_instance(root, ground, Affine::from_translation([-15.0, -1.5, -15.0])).unwrap();
    let block = scene.add_mesh(cube(), Motion::Rigid).unwrap();
    let mut random = Random::new(3);
    let crates: Vec<_> = (0..25).map(|_| scene.add_instance(root, block, random.placement(9.0)).unwrap()).collect();
    // One that is not in the frame, so that instances and handles are numbered differently.
    scene.place(crates[4], Affine::from_scale([0.0; 3])).unwrap();
    let mut bodies = add_vehicle(&mut scene, Affine::from_axis_angle([0.0, 1.0, 0.0], 0.4));
    add_vehicle(&mut scene, Affine::from_translation([5.0, 0.2, 1.0]));
    bodies.push(root.into());
    Traffic { scene, bodies, crates }
}

/// Rays from inside the vehicle, in all directions and, in tiles, nearly alike.
fn rays_from_inside(seed: u64) -> Vec<Ray> {
    let mut random = Random::new(seed);
    let mut rays: Vec<Ray> = (0..150)
        .map(|_| Ray::new([0; 3].map(|_| random.within(-0.5, 0.5)), random.direction().map(|x| x * 3.0)))
        .collect();
    for _ in 0..3 {
        let (eye, ahead) = (random.point(0.4), random.direction());
        rays.extend((0..64).map(|_| {
            let aside = random.point(0.15);
            Ray::new(eye, [0, 1, 2].map(|axis| ahead[axis] + aside[axis]))
        }));
    }
    rays
}

fn holes(candidate: &Candidate<'_>) -> bool {
    (candidate.primitive() + candidate.instance_index()) % 3 != 0
}

fn asking(view: &Snapshot, cull: Cull, filtered: bool) -> Query<'_> {
    let query = view.query().cull(cull);
    if filtered { query.filter(&holes) } else { query }
}

/// What rays meet while something is hidden by its mask: the judge, which knows nothing of
/// exclusions. Instances keep their numbers.
struct Hidden {
    view: Snapshot,
    what: Placed,
}

fn hide_each(scene: &mut Scene, bodies: &[Placed]) -> Vec<Hidden> {
    let hide = |&what: &Placed| {
        scene.set_mask(what, 0).unwrap();
        let view = scene.commit();
        scene.set_mask(what, u32::MAX).unwrap();
        Hidden { view, what }
    };
    bodies.iter().map(hide).collect()
}

/// Every way of asking about one ray; tells whether it hits something.
fn compare(what: &str, query: Query<'_>, expected: Query<'_>, ray: &Ray) -> bool {
    let (closest, all) = (expected.closest_hit(ray), expected.all_hits(ray));
    let mut work = Work::default();
    assert_eq!(query.closest_hit(ray), closest, "{what}, {ray:?}");
    assert_eq!(query.closest_hit_counted(ray, &mut work), closest, "{what}, {ray:?}");
    assert_eq!(query.occluded(ray), closest.is_some(), "{what}, {ray:?}");
    assert_eq!(query.occluded_counted(ray, &mut work), closest.is_some(), "{what}, {ray:?}");
    assert_eq!(query.all_hits(ray), all, "{what}, {ray:?}");
    assert_eq!(query.all_hits_counted(ray, &mut work), all, "{what}, {ray:?}");
    closest.is_some()
}

/// The same by testing every triangle, at whatever level.
fn compare_brute_force(what: &str, query: Query<'_>, expected: Query<'_>, ray: &Ray) {
    let (closest, all) = (expected.closest_hit(ray), expected.all_hits(ray));
    let brute_force = query.brute_force();
    assert_eq!(brute_force.closest_hit(ray), closest, "brute force, {what}, {ray:?}");
    assert_eq!(brute_force.occluded(ray), closest.is_some(), "brute force, {what}, {ray:?}");
    assert_eq!(brute_force.all_hits(ray), all, "brute force, {what}, {ray:?}");
}

fn compare_batches(what: &str, query: Query<'_>, expected: &[Option<Hit>], rays: &[Ray]) {
    for claim in CLAIMS {
        // Answers that are wrong until they are written.
        let mut hits: Vec<_> = expected.iter().rev().copied().collect();
        let mut dark: Vec<_> = expected.iter().map(|hit| hit.is_none()).collect();
        query.closest_hits(rays, &mut hits, claim);
        query.occluded_each(rays, &mut dark, claim);
        for (at, ray) in rays.iter().enumerate() {
            assert_eq!(hits[at], expected[at], "{what}, {claim:?}, ray {at}: {ray:?}");
            assert_eq!(dark[at], expected[at].is_some(), "{what}, {claim:?}, ray {at}: {ray:?}");
        }
    }
}

#[test]
fn rays_from_inside_a_vehicle_see_what_is_left_when_it_is_hidden() {
    let seed = 60;
    let Traffic { mut scene, bodies, .. } = traffic();
    let rays = rays_from_inside(seed);
    let view = scene.commit();
    let own = rays.iter().filter(|ray| view.closest_hit(ray).is_some_and(|hit| hit.t < 1.0)).count();
    assert!(own > rays.len() / 2, "most rays meet the vehicle itself: {own}");
    let hidden = hide_each(&mut scene, &bodies);
    let (mut changed, mut seen) = (0, 0);
    for (number, level) in Level::available().into_iter().enumerate() {
        let view = view.at_level(level);
        for Hidden { view: hidden, what } in &hidden {
            let name = format!("without {what:?}, {level:?}, seed {seed}");
            for (cull, filtered) in [(Cull::None, false), (Cull::None, true), (Cull::Back, false), (Cull::Front, true)]
            {
                let name = format!("{name}, {cull:?}, filter: {filtered}");
                let (query, judge) = (asking(&view, cull, filtered), asking(hidden, cull, filtered));
                let expected: Vec<_> = rays.iter().map(|ray| judge.closest_hit(ray)).collect();
                changed += rays.iter().zip(&expected).filter(|(ray, hit)| query.closest_hit(ray) != **hit).count();
                let query = query.without(*what);
                seen += rays.iter().filter(|ray| compare(&name, query, judge, ray)).count();
                compare_batches(&name, query, &expected, &rays);
                // One level and some rays do: it takes long.
                let looked = if number == 0 { rays.len() } else { 0 };
                rays[..looked].iter().step_by(4).for_each(|ray| compare_brute_force(&name, query, judge, ray));
            }
        }
    }
    assert!(changed > 1000 && seen > 1000, "the comparison is about something: {changed} changed, {seen} seen");
}

#[test]
fn every_ray_of_a_batch_leaves_out_its_own() {
    let seed = 61;
    let Traffic { mut scene, bodies, crates } = traffic();
    let mut random = Random::new(seed);
    let rays = rays_from_inside(seed);
    let view = scene.commit();
    let hidden = hide_each(&mut scene, &bodies);
    // One for all rays besides: the crate behind most of them.
    let all = crates[1];
    scene.set_mask(all, 0).unwrap();
    let hidden_too = hide_each(&mut scene, &bodies);
    // Packets whose rays leave out the same, and packets whose rays do not.
    let chosen: Vec<usize> = (0..rays.len()).map(|at| if at < 64 { 0 } else { random.below(bodies.len()) }).collect();
    let each: Vec<Placed> = chosen.iter().map(|&at| bodies[at]).collect();
    for (number, level) in Level::available().into_iter().enumerate() {
        let view = view.at_level(level);
        for (hidden, also) in [(&hidden, None), (&hidden_too, Some(all))] {
            for filtered in [false, true] {
                let name = format!("{level:?}, filter: {filtered}, also {also:?}, seed {seed}");
                let query = asking(&view, Cull::None, filtered).without_each(&each);
                let query = also.map_or(query, |also| query.without(also));
                let judge = |at: usize| asking(&hidden[chosen[at]].view, Cull::None, filtered);
                let expected: Vec<_> = (0..rays.len()).map(|at| judge(at).closest_hit(&rays[at])).collect();
                compare_batches(&name, query, &expected, &rays);
                for (at, ray) in rays.iter().enumerate() {
                    let query = query.without_each(&each[at..at + 1]);
                    compare(&name, query, judge(at), ray);
                    if number == 0 {
                        compare_brute_force(&name, query, judge(at), ray);
                    }
                }
            }
        }
    }
}

#[test]
fn what_is_left_out_is_not_even_entered() {
    let Traffic { mut scene, bodies, .. } = traffic();
    let view = scene.commit();
    let rays = rays_from_inside(62);
    let entered = |query: Query<'_>| {
        let mut work = Work::default();
        rays.iter().for_each(|ray| _ = query.all_hits_counted(ray, &mut work));
        work.instances
    };
    let all = entered(view.query());
    let others = entered(view.query().without(bodies[0]));
    let hidden = entered(hide_each(&mut scene, &bodies)[0].view.query());
    assert!(others < all / 2, "{others} of {all}");
    assert_eq!(others, hidden);
    assert_eq!(entered(view.query().without(scene.root())), 0);
}

/// A large batch of rays that are worth sorting, so that they are answered in another order.
#[test]
fn rays_keep_their_own_exclusions_when_a_batch_is_sorted() {
    let seed = 63;
    let mut random = Random::new(seed);
    let mut scene = Scene::new();
    let mesh = scene.add_mesh(random.soup(100_000, 10.0, 0.2), Motion::Static).unwrap();
    let [one, other] =
        [0.0, 0.5].map(|x| scene.add_instance(scene.root(), mesh, Affine::from_translation([x, 0.0, 0.0])).unwrap());
    let view = scene.commit();
    let rays: Vec<Ray> = (0..5000).map(|_| Ray::new(random.point(12.0), random.direction())).collect();
    let each: Vec<Placed> = (0..rays.len()).map(|at| [one, other][at % 2].into()).collect();
    let hidden = hide_each(&mut scene, &[one.into(), other.into()]);
    let expected: Vec<_> = (0..).zip(&rays).map(|(at, ray)| hidden[at % 2].view.closest_hit(ray)).collect();
    let mut hits = vec![None; rays.len()];
    view.query().without_each(&each).closest_hits(&rays, &mut hits, Coherence::Incoherent);
    assert!(hits == expected, "seed {seed}");
}

#[test]
#[should_panic(expected = "one entry of `without_each` per ray")]
fn a_batch_with_too_few_exclusions_panics() {
    let Traffic { mut scene, bodies, .. } = traffic();
    let rays = rays_from_inside(1);
    let mut hits = vec![None; rays.len()];
    scene.commit().query().without_each(&bodies[..2]).closest_hits(&rays, &mut hits, Coherence::Coherent);
}

#[test]
#[should_panic(expected = "one entry of `without_each` per ray")]
fn a_single_ray_with_the_exclusions_of_a_batch_panics() {
    let Traffic { mut scene, bodies, .. } = traffic();
    let _ = scene.commit().query().without_each(&bodies[..2]).occluded(&rays_from_inside(1)[0]);
}

/// A hierarchy that grows and shrinks, noted beside the scene.
struct Grown {
    scene: Scene,
    parents: HashMap<NodeId, NodeId>,
    hangs_on: HashMap<InstanceId, NodeId>,
    /// Handles of what is gone.
    gone: Vec<Placed>,
}

impl Grown {
    fn is_below(&self, instance: InstanceId, what: Placed) -> bool {
        let node = match what {
            Placed::Instance(other) => return instance == other,
            Placed::Node(node) => node,
            other => panic!("{other:?} is neither a node nor an instance"),
        };
        std::iter::successors(Some(self.hangs_on[&instance]), |at| self.parents.get(at).copied()).any(|at| at == node)
    }

    fn some_node(&self, random: &mut Random) -> NodeId {
        let mut nodes: Vec<_> = self.parents.keys().copied().collect();
        nodes.sort_unstable();
        nodes.push(self.scene.root());
        nodes[random.below(nodes.len())]
    }

    fn remove_node(&mut self, node: NodeId) {
        if self.scene.remove_node(node).is_err() {
            return;
        }
        let lost: Vec<_> =
            self.hangs_on.keys().copied().filter(|&instance| self.is_below(instance, node.into())).collect();
        for instance in lost {
            self.hangs_on.remove(&instance);
            self.gone.push(instance.into());
        }
        while let Some(lost) = self.parents.keys().copied().find(|&at| {
            at == node || self.parents[&at] != self.scene.root() && !self.parents.contains_key(&self.parents[&at])
        }) {
            self.parents.remove(&lost);
            self.gone.push(lost.into());
        }
    }
}

/// Which instances a query sees: each stands alone in a row, by number.
fn seen(view: &Snapshot, query: Query<'_>) -> Vec<InstanceId> {
    let above = |x: f32| Ray::new([x, 5.0, 0.0], [0.0, -1.0, 0.0]);
    let mut ids: Vec<_> = view
        .instances()
        .filter(|instance| query.occluded(&above(instance.world_from_object().translation[0])))
        .map(|instance| instance.id())
        .collect();
    ids.sort_unstable();
    ids
}

#[test]
fn what_is_below_a_node_is_known_in_every_frame_whatever_came_and_went() {
    let seed = 64;
    let mut random = Random::new(seed);
    let mut scene = Scene::new();
    let ball = scene.add_mesh(cube(), Motion::Rigid).unwrap();
    let mut grown = Grown { scene, parents: HashMap::new(), hangs_on: HashMap::new(), gone: Vec::new() };
    let mut row = 0;
    let mut held: Vec<(Snapshot, Placed, Vec<InstanceId>)> = Vec::new();
    let elsewhere = Scene::new().root();
    for frame in 0..60 {
        for _ in 0..random.below(12) {
            match random.below(10) {
                0 => {
                    let node = grown.some_node(&mut random);
                    grown.remove_node(node);
                }
                1 => {
                    let mut all: Vec<_> = grown.hangs_on.keys().copied().collect();
                    all.sort_unstable();
                    if let Some(&instance) = all.get(random.below(all.len().max(1))) {
                        grown.scene.remove_instance(instance).unwrap();
                        grown.hangs_on.remove(&instance);
                        grown.gone.push(instance.into());
                    }
                }
                2..=5 => {
                    let parent = grown.some_node(&mut random);
                    let node = grown.scene.add_node(parent, Affine::IDENTITY).unwrap();
                    grown.parents.insert(node, parent);
                }
                _ => {
                    let node = grown.some_node(&mut random);
                    let scale = if random.unit() < 0.1 { 0.0 } else { 1.0 };
                    let at = Affine::from_translation([row as f32 * 3.0, 0.0, 0.0]) * Affine::from_scale([scale; 3]);
                    row += 1;
                    let instance = grown.scene.add_instance(node, ball, at).unwrap();
                    grown.hangs_on.insert(instance, node);
                }
            }
        }
        let view = grown.scene.commit();
        let everything = seen(&view, view.query());
        let nodes = grown.parents.keys().map(|&node| Placed::from(node));
        let named: Vec<Placed> =
            nodes.chain(everything.iter().map(|&id| id.into())).chain([grown.scene.root().into()]).collect();
        for what in named {
            let expected: Vec<_> = everything.iter().copied().filter(|&id| !grown.is_below(id, what)).collect();
            assert_eq!(seen(&view, view.query().without(what)), expected, "{what:?}, frame {frame}, seed {seed}");
            if random.below(8) == 0 {
                held.push((view.clone(), what, expected));
            }
        }
        for &what in grown.gone.iter().chain([&elsewhere.into()]) {
            assert_eq!(seen(&view, view.query().without(what)), everything, "{what:?}, frame {frame}, seed {seed}");
        }
    }
    assert!(grown.gone.len() > 50 && held.len() > 50, "{} gone, {} held", grown.gone.len(), held.len());
    // A node that no older frame has, in a slot that they may have.
    let late = grown.scene.add_node(grown.scene.root(), Affine::IDENTITY).unwrap();
    for (view, what, expected) in held {
        assert_eq!(seen(&view, view.query().without(what)), expected, "{what:?} in a held snapshot, seed {seed}");
        assert_eq!(seen(&view, view.query().without(late)), seen(&view, view.query()), "seed {seed}");
    }
}

#[test]
fn chains_may_be_long() {
    let mut scene = Scene::new();
    let mesh = scene.add_mesh(cube(), Motion::Rigid).unwrap();
    let mut nodes = vec![scene.root()];
    for _ in 0..100_000 {
        nodes.push(scene.add_node(nodes[nodes.len() - 1], Affine::IDENTITY).unwrap());
    }
    scene.add_instance(nodes[50_000], mesh, Affine::IDENTITY).unwrap();
    let view = scene.commit();
    let ray = Ray::new([0.1, 0.2, -5.0], [0.0, 0.0, 1.0]);
    assert!(!view.query().without(nodes[1]).occluded(&ray) && !view.query().without(nodes[50_000]).occluded(&ray));
    assert!(view.query().without(nodes[50_001]).occluded(&ray));
}
