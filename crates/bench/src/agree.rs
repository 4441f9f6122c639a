//! Compares the answers of engines; nothing is timed before its answers are compared.

use std::collections::BTreeMap;

use glam::Vec3;

use crate::exact::{Rounded, closest_by_brute_force, crossing};
use crate::ray::{Answer, Ray};
use crate::rays::QueryKind;
use crate::soup::Soup;

/// Relative difference up to which two distances count as equal.
const TOLERANCE: f32 = 1e-4;
/// Barycentric weights below this are at an edge, and cosines below it are grazing: there, a test
/// that is not watertight may decide either way.
const EDGE: f64 = 1e-4;

/// Relative rounding error of coordinates, for a few roundings.
const ROUNDING: f64 = 4.0 * f32::EPSILON as f64;

/// Counts of how two lists of answers differ.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct AnswerDifferences {
    /// The number of rays that were compared.
    pub(crate) rays: usize,
    /// The number of answers that differ.
    pub(crate) all: usize,
    /// The number of those at the edge of a triangle, or grazing it.
    pub(crate) at_edges: usize,
    /// The first ray that differs away from edges, the right answer, and the given one.
    pub(crate) first: Option<(usize, Answer, EngineAnswer)>,
}

impl AnswerDifferences {
    /// The number of differences that are neither at an edge nor grazing.
    pub(crate) fn elsewhere(&self) -> usize {
        self.all - self.at_edges
    }

    /// The sums of both.
    pub(crate) fn and(self, more: Self) -> Self {
        Self {
            rays: self.rays + more.rays,
            all: self.all + more.all,
            at_edges: self.at_edges + more.at_edges,
            first: self.first.or(more.first),
        }
    }

    fn add(&mut self, ray: usize, expected: Answer, given: EngineAnswer, at_edge: bool) {
        self.all += 1;
        self.at_edges += usize::from(at_edge);
        if !at_edge {
            self.first = self.first.or(Some((ray, expected, given)));
        }
    }
}

/// Whether both miss, or both hit at the same distance. Several triangles may lie at that distance;
/// which of them is named does not matter.
fn same(one: &Answer, other: &Answer) -> bool {
    match (one.is_hit(), other.is_hit()) {
        (true, true) => (one.t - other.t).abs() <= TOLERANCE * one.t.abs().max(other.t.abs()),
        (hit, also) => hit == also,
    }
}

/// The same hits with distances computed exactly, so that no engine is measured against the
/// rounding of another.
pub(crate) fn refined(soup: &Soup, rays: &[Ray], answers: &[Answer]) -> Vec<Answer> {
    let refine = |(ray, answer): (&Ray, &Answer)| {
        let exact = answer.is_hit().then(|| crossing(ray, &soup.corners(answer.primitive))).flatten();
        Answer { t: exact.map_or(answer.t, |exact| exact.t as f32), ..*answer }
    };
    rays.iter().zip(answers).map(refine).collect()
}

/// What an engine answered for a ray.
#[derive(Debug, Clone, Copy)]
pub(crate) enum EngineAnswer {
    /// The nearest hit, or none.
    Nearest(Answer),
    /// Whether there is any hit.
    Occluded(bool),
}

impl EngineAnswer {
    fn agrees(&self, expected: &Answer) -> bool {
        match self {
            Self::Nearest(given) => same(expected, given),
            Self::Occluded(given) => expected.is_hit() == *given,
        }
    }
}

/// A ray about which an engine and the reference do not agree.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Dispute {
    pub(crate) ray: usize,
    /// The answer of the engine.
    pub(crate) given: EngineAnswer,
}

/// The rays for which an engine's answers differ from the expected ones, in order.
pub(crate) fn disputes(expected: &[Answer], given: impl IntoIterator<Item = EngineAnswer>) -> Vec<Dispute> {
    let all = given.into_iter().enumerate().map(|(ray, given)| Dispute { ray, given });
    all.filter(|dispute| !dispute.given.agrees(&expected[dispute.ray])).collect()
}

/// The right answers of disputed rays.
#[derive(Debug, Default)]
pub(crate) struct ExactAnswers {
    by_ray: BTreeMap<usize, Answer>,
    /// Disputed rays for which the budget of triangle tests did not suffice; for these the
    /// reference counts as right.
    pub(crate) unsettled: usize,
}

impl ExactAnswers {
    /// Searches through all triangles in exact arithmetic. `triangle_tests` is a budget of pairs of
    /// a ray and a triangle, and is reduced by what is used; when it does not suffice for all rays,
    /// the rays that are searched are spread evenly.
    pub(crate) fn of(soup: &Soup, rays: &[Ray], mut disputed: Vec<usize>, triangle_tests: &mut usize) -> Self {
        disputed.sort_unstable();
        disputed.dedup();
        let affordable = *triangle_tests / soup.len().max(1);
        let all = disputed.len();
        let count = all.min(affordable);
        let searched: Vec<usize> = (0..count).map(|at| disputed[at * all / count.max(1)]).collect();
        *triangle_tests -= count * soup.len();
        let searched_rays: Vec<Ray> = searched.iter().map(|ray| rays[*ray]).collect();
        let by_ray = searched.into_iter().zip(closest_by_brute_force(soup, &searched_rays)).collect();
        Self { by_ray, unsettled: all - count }
    }

    /// The number of rays that were searched for.
    pub(crate) fn settled(&self) -> usize {
        self.by_ray.len()
    }

    /// The rays for which the reference was wrong, with its answers.
    fn reference_errors<'a>(&'a self, expected: &'a [Answer]) -> impl Iterator<Item = Dispute> {
        let wrong = self.by_ray.iter().filter(|(ray, truth)| !same(truth, &expected[**ray]));
        wrong.map(|(ray, _)| Dispute { ray: *ray, given: EngineAnswer::Nearest(expected[*ray]) })
    }

    /// What an engine got wrong, given its disputes with the reference. Where the reference was
    /// wrong and the engine agreed with it, both count as wrong.
    pub(crate) fn differences(
        &self,
        soup: &Soup,
        rays: &[Ray],
        expected: &[Answer],
        disputes: &[Dispute],
        query_kind: QueryKind,
    ) -> AnswerDifferences {
        // Disputes are sorted by ray.
        let as_asked = |answer: Answer| match query_kind {
            QueryKind::Closest => EngineAnswer::Nearest(answer),
            QueryKind::Occluded => EngineAnswer::Occluded(answer.is_hit()),
        };
        let agreed = self
            .reference_errors(expected)
            .filter(|wrong| disputes.binary_search_by_key(&wrong.ray, |dispute| dispute.ray).is_err());
        let agreed = agreed.map(|wrong| Dispute { given: as_asked(expected[wrong.ray]), ..wrong });
        let mut differences = AnswerDifferences { rays: rays.len(), ..AnswerDifferences::default() };
        for Dispute { ray, given } in disputes.iter().copied().chain(agreed) {
            let truth = self.by_ray.get(&ray).copied().unwrap_or(expected[ray]);
            if !given.agrees(&truth) {
                differences.add(ray, truth, given, is_at_edge(soup, &rays[ray], &truth, &given));
            }
        }
        differences
    }
}

/// Whether an engine that is not watertight may give this answer.
fn is_at_edge(soup: &Soup, ray: &Ray, truth: &Answer, given: &EngineAnswer) -> bool {
    // The engine with the farther hit rejected the nearer one. A hit at the very end of the ray may
    // be decided either way, too.
    let nearer = match given {
        EngineAnswer::Nearest(given) if given.t < truth.t => given,
        _ => truth,
    };
    nearer.is_hit() && (on_an_edge(soup, ray, nearer) || at_the_end(ray, nearer))
}

fn at_the_end(ray: &Ray, answer: &Answer) -> bool {
    ray.t_max.is_finite() && (answer.t - ray.t_max).abs() <= TOLERANCE * ray.t_max
}

/// Whether a hit is at an edge or grazing, in double precision.
fn on_an_edge(soup: &Soup, ray: &Ray, answer: &Answer) -> bool {
    if answer.primitive as usize >= soup.len() {
        return false;
    }
    let exact = Rounded::of(soup, ray, answer.primitive);
    let corners = soup.corners(answer.primitive);
    let edges = [0, 1, 2].map(|i| f64::from(corners[(i + 1) % 3].distance(corners[(i + 2) % 3])));
    let reach = corners
        .iter()
        .map(|corner| corner.abs().max_element())
        .fold(Vec3::from(ray.origin).abs().max_element(), f32::max);
    // Slivers are so narrow that rounding of the coordinates is a large part of their width.
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

    fn differences_of(
        ray: Ray,
        expected: Answer,
        given: EngineAnswer,
        query_kind: QueryKind,
        triangle_tests: usize,
    ) -> AnswerDifferences {
        let (soup, rays, expected) = (soup(), [ray], [expected]);
        let disputes = disputes(&expected, [given]);
        let disputed = disputes.iter().map(|dispute| dispute.ray).collect();
        ExactAnswers::of(&soup, &rays, disputed, &mut { triangle_tests })
            .differences(&soup, &rays, &expected, &disputes, query_kind)
    }

    fn down(x: f32) -> Ray {
        Ray::new(Vec3::new(x, 0.2, 1.0), Vec3::NEG_Z)
    }

    #[test]
    fn distances_may_differ_by_rounding_only() {
        let differ = |t| differences_of(down(0.2), hit(1.0), EngineAnswer::Nearest(hit(t)), QueryKind::Closest, 10);
        assert_eq!(differ(1.00005).all, 0);
        let far = differ(1.001);
        assert_eq!((far.all, far.elsewhere(), far.first.map(|first| first.0)), (1, 1, Some(0)));
    }

    #[test]
    fn distances_of_the_reference_are_refined_in_exact_arithmetic() {
        let rays = [down(0.2), Ray::new(Vec3::splat(5.0), Vec3::X)];
        let refined = refined(&soup(), &rays, &[hit(1.25), Answer::MISS]);
        assert_eq!(refined, [hit(1.0), Answer::MISS]);
    }

    #[test]
    fn differences_at_edges_are_counted_apart() {
        for (x, at_edges) in [(0.2, 0), (1e-6, 1)] {
            let answers = [
                (EngineAnswer::Nearest(Answer::MISS), QueryKind::Closest),
                (EngineAnswer::Occluded(false), QueryKind::Occluded),
            ];
            for (given, query_kind) in answers {
                let differences = differences_of(down(x), hit(1.0), given, query_kind, 10);
                assert_eq!((differences.all, differences.at_edges), (1, at_edges), "{x} {query_kind:?}");
            }
        }
    }

    #[test]
    fn an_engine_that_contradicts_a_wrong_reference_is_right_and_one_that_agrees_is_wrong() {
        let wrong = [hit(0.5), Answer::MISS];
        for (reference, query_kind) in
            wrong.into_iter().flat_map(|it| [(it, QueryKind::Closest), (it, QueryKind::Occluded)])
        {
            let as_asked = |answer: Answer| match query_kind {
                QueryKind::Closest => EngineAnswer::Nearest(answer),
                QueryKind::Occluded => EngineAnswer::Occluded(answer.is_hit()),
            };
            let blamed = |answer: Answer, triangle_tests| {
                differences_of(down(0.2), reference, as_asked(answer), query_kind, triangle_tests).all
            };
            assert_eq!(blamed(hit(1.0), 10), 0, "{query_kind:?}");
            // Nothing is disputed, so no ray is searched for.
            assert_eq!(blamed(reference, 10), 0, "{query_kind:?}");
        }
        let (soup, rays, expected) = (soup(), [down(0.2)], [hit(0.5)]);
        let exact_answers = ExactAnswers::of(&soup, &rays, vec![0, 0], &mut 10);
        assert_eq!(exact_answers.reference_errors(&expected).count(), 1);
        assert_eq!(exact_answers.differences(&soup, &rays, &expected, &[], QueryKind::Closest).elsewhere(), 1);
        // The reference did report a hit, which is right for an occlusion query.
        assert_eq!(exact_answers.differences(&soup, &rays, &expected, &[], QueryKind::Occluded).all, 0);
    }

    #[test]
    fn without_budget_the_reference_counts_as_right_and_unsettled_rays_are_counted() {
        let differences = differences_of(down(0.2), hit(0.5), EngineAnswer::Nearest(hit(1.0)), QueryKind::Closest, 0);
        assert_eq!(differences.all, 1);
        let (soup, rays) = (soup(), [down(0.2); 4]);
        let exact_answers = ExactAnswers::of(&soup, &rays, vec![3, 1, 2, 0], &mut 2);
        assert_eq!(
            (exact_answers.by_ray.keys().copied().collect::<Vec<_>>(), exact_answers.unsettled),
            (vec![0, 2], 2)
        );
    }
}
