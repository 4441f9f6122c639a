//! Triangles out of lists, strips and fans (glTF 2.0 specification, section 3.7.2.1).

use crate::json::Mode;

/// The triangles that a primitive draws, with the winding that the specification gives them; `None`
/// for points and lines. Vertices that are too few for one more triangle draw nothing.
pub(crate) fn triangles(mode: Mode, indices: &[u32]) -> Option<Vec<[u32; 3]>> {
    let of = |i: usize, j: usize, k: usize| [indices[i], indices[j], indices[k]];
    let steps = indices.len().saturating_sub(2);
    match mode {
        Mode::Points | Mode::Lines | Mode::LineLoop | Mode::LineStrip => None,
        Mode::Triangles => Some(indices.as_chunks().0.to_vec()),
        Mode::TriangleStrip => Some((0..steps).map(|i| of(i, i + 1 + i % 2, i + 2 - i % 2)).collect()),
        Mode::TriangleFan => Some((0..steps).map(|i| of(i + 1, i + 2, 0)).collect()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn strips_and_fans_keep_one_winding() {
        // Four corners of a square, in the order of each mode, counter-clockwise seen from above.
        let area = |corners: &[[f32; 2]], [a, b, c]: [u32; 3]| {
            let [a, b, c] = [a, b, c].map(|i| corners[i as usize]);
            (b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1])
        };
        let strip = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0]];
        let fan = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
        for (mode, corners) in [(Mode::TriangleStrip, strip), (Mode::TriangleFan, fan)] {
            let found = triangles(mode, &[0, 1, 2, 3]).expect("triangles");
            assert_eq!(found.len(), 2, "{mode:?}");
            assert!(found.iter().all(|&triangle| area(&corners, triangle) == 1.0), "{mode:?}: {found:?}");
        }
    }

    #[test]
    fn too_few_indices_draw_nothing() {
        for count in 0..3 {
            for mode in [Mode::Triangles, Mode::TriangleStrip, Mode::TriangleFan] {
                assert_eq!(triangles(mode, &[0, 1, 2][..count]), Some(Vec::new()), "{mode:?} of {count}");
            }
        }
        assert_eq!(triangles(Mode::Triangles, &[0, 1, 2, 3, 4]), Some(vec![[0, 1, 2]]));
        assert_eq!(triangles(Mode::LineLoop, &[0, 1, 2]), None);
    }
}
