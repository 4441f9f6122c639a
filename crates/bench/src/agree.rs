//! Whether engines give the same answers: looked at before any time is believed.

use glam::Vec3;

use crate::exact::Exact;
use crate::ray::{Answer, Ray};
use crate::soup::Soup;

/// Distances may differ by this part of themselves.
const TOLERANCE: f32 = 1e-4;
/// Weights of corners below this are at an edge, and cosines below it are grazing: there, a test that is not watertight may decide either way.
const EDGE: f64 = 1e-4;

/// Coordinates are rounded by this part of themselves, a few times over.
const ROUNDING: f64 = 4.0 * f32::EPSILON as f64;

/// How two lists of answers differ.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(crate) struct Differences {
    /// How many rays were compared.
    pub(crate) rays: usize,
    /// How many answers differ.
    pub(crate) all: usize,
    /// How many of those are at the edge of a triangle, or grazing it.
    pub(crate) at_edges: usize,
    /// The first ray that differs elsewhere, what was expected, and what was given, if that is known.
    pub(crate) first: Option<(usize, Answer, Option<Answer>)>,
}

impl Differences {
    /// How many have no excuse.
    pub(crate) fn elsewhere(&self) -> usize {
        self.all - self.at_edges
    }

    /// Both together.
    pub(crate) fn and(self, more: Self) -> Self {
        Self {
            rays: self.rays + more.rays,
            all: self.all + more.all,
            at_edges: self.at_edges + more.at_edges,
            first: self.first.or(more.first),
        }
    }

    fn add(&mut self, ray: usize, expected: Answer, given: Option<Answer>, at_edge: bool) {
        self.all += 1;
        self.at_edges += usize::from(at_edge);
        if !at_edge {
            self.first = self.first.or(Some((ray, expected, given)));
        }
    }
}

/// Whether both hit or both miss, at the same distance. Which of several triangles at the same distance is meant, is nobody's business.
fn same(one: &Answer, other: &Answer) -> bool {
    match (one.is_hit(), other.is_hit()) {
        (true, true) => (one.t - other.t).abs() <= TOLERANCE * one.t.abs().max(other.t.abs()),
        (hit, also) => hit == also,
    }
}

/// The same hits with distances computed in double precision: what all engines are held against, so that nobody's rounding is the measure.
pub(crate) fn refined(soup: &Soup, rays: &[Ray], answers: &[Answer]) -> Vec<Answer> {
    let refine = |(ray, answer): (&Ray, &Answer)| {
        let exact = if answer.is_hit() { Exact::of(soup, ray, answer.primitive).t as f32 } else { answer.t };
        Answer { t: if exact.is_finite() { exact } else { answer.t }, ..*answer }
    };
    rays.iter().zip(answers).map(refine).collect()
}

/// Compares nearest hits.
pub(crate) fn compare(soup: &Soup, rays: &[Ray], expected: &[Answer], given: &[Answer]) -> Differences {
    let mut differences = Differences { rays: rays.len(), ..Differences::default() };
    for (at, ray) in rays.iter().enumerate() {
        if !same(&expected[at], &given[at]) {
            // The farther one has passed the nearer one by; the end of the ray is a place of decision, too.
            let nearer = if expected[at].t <= given[at].t { &expected[at] } else { &given[at] };
            let at_edge = on_an_edge(soup, ray, nearer) || at_the_end(ray, nearer);
            differences.add(at, expected[at], Some(given[at]), at_edge);
        }
    }
    differences
}

/// Compares whether anything is in the way. `hits` are the nearest hits of the rays, which tell where differences are.
pub(crate) fn compare_occlusion(soup: &Soup, rays: &[Ray], hits: &[Answer], given: &[bool]) -> Differences {
    let mut differences = Differences { rays: rays.len(), ..Differences::default() };
    for (at, ray) in rays.iter().enumerate() {
        if hits[at].is_hit() != given[at] {
            let at_edge = hits[at].is_hit() && (on_an_edge(soup, ray, &hits[at]) || at_the_end(ray, &hits[at]));
            differences.add(at, hits[at], None, at_edge);
        }
    }
    differences
}

fn at_the_end(ray: &Ray, answer: &Answer) -> bool {
    ray.t_max.is_finite() && (answer.t - ray.t_max).abs() <= TOLERANCE * ray.t_max
}

/// Whether a hit is at an edge or grazing, computed anew in double precision.
fn on_an_edge(soup: &Soup, ray: &Ray, answer: &Answer) -> bool {
    if answer.primitive as usize >= soup.len() {
        return false;
    }
    let exact = Exact::of(soup, ray, answer.primitive);
    let corners = soup.corners(answer.primitive);
    let edges = [0, 1, 2].map(|i| f64::from(corners[(i + 1) % 3].distance(corners[(i + 2) % 3])));
    let reach = corners
        .iter()
        .map(|corner| corner.abs().max_element())
        .fold(Vec3::from(ray.origin).abs().max_element(), f32::max);
    // Slivers are so narrow that the rounding of coordinates is a large part of their width.
    let slack = f64::from(reach) * ROUNDING;
    let weights = [1.0 - exact.u - exact.v, exact.u, exact.v];
    exact.cosine <= EDGE
        || weights.into_iter().zip(edges).any(|(weight, edge)| {
            let height = if edge > 0.0 { exact.double_area / edge } else { 0.0 };
            weight.abs() <= EDGE || weight.abs() * height <= slack
        })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn soup() -> Soup {
        let mut soup = Soup::default();
        soup.add([Vec3::ZERO, Vec3::X, Vec3::Y], &[[0, 1, 2]]);
        soup
    }

    fn hit(t: f32) -> Answer {
        Answer { t, u: 0.2, v: 0.2, primitive: 0, mesh: 0 }
    }

    #[test]
    fn distances_may_differ_by_rounding_only() {
        let rays = [Ray::new(Vec3::new(0.2, 0.2, 1.0), Vec3::NEG_Z)];
        let differ = |t| compare(&soup(), &rays, &[hit(1.0)], &[hit(t)]);
        assert_eq!(differ(1.00005).all, 0);
        let far = differ(1.001);
        assert_eq!((far.all, far.elsewhere(), far.first.map(|first| first.0)), (1, 1, Some(0)));
    }

    #[test]
    fn rounding_of_the_reference_is_nobodys_measure() {
        let rays = [Ray::new(Vec3::new(0.2, 0.2, 1.0), Vec3::NEG_Z), Ray::new(Vec3::splat(5.0), Vec3::X)];
        let refined = refined(&soup(), &rays, &[hit(1.25), Answer::MISS]);
        assert_eq!(refined, [hit(1.0), Answer::MISS]);
    }

    #[test]
    fn an_edge_is_an_excuse_and_the_inside_is_none() {
        for (x, at_edges) in [(0.2, 0), (1e-6, 1)] {
            let rays = [Ray::new(Vec3::new(x, 0.2, 1.0), Vec3::NEG_Z)];
            let differences = compare(&soup(), &rays, &[hit(1.0)], &[Answer::MISS]);
            assert_eq!((differences.all, differences.at_edges), (1, at_edges), "{x}");
            let differences = compare_occlusion(&soup(), &rays, &[hit(1.0)], &[false]);
            assert_eq!((differences.all, differences.at_edges), (1, at_edges), "{x}");
        }
    }
}
