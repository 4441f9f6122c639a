//! Positions and indices as callers have them.

use super::MeshError;
use crate::memory::vec_in_large_pages;

/// Positions, as a slice or spread over a vertex buffer.
#[derive(Debug, Clone, Copy)]
#[non_exhaustive]
pub enum Positions<'a> {
    /// One after the other.
    Slice(&'a [[f32; 3]]),
    /// Three little-endian floats every `stride` bytes.
    Strided {
        /// The vertex buffer.
        bytes: &'a [u8],
        /// Byte of the first position.
        offset: usize,
        /// Bytes from one position to the next.
        stride: usize,
        /// How many there are.
        count: usize,
    },
}

/// Vertex numbers, three a triangle.
#[derive(Debug, Clone, Copy)]
#[non_exhaustive]
pub enum Indices<'a> {
    /// Triangles as such.
    Triangles(&'a [[u32; 3]]),
    /// A flat list.
    U32(&'a [u32]),
    /// A flat list of short numbers.
    U16(&'a [u16]),
}

macro_rules! slices {
    ($($item:ty => $into:ident :: $variant:ident),*) => {$(
        impl<'a> From<&'a [$item]> for $into<'a> {
            fn from(slice: &'a [$item]) -> Self {
                Self::$variant(slice)
            }
        }

        impl<'a> From<&'a Vec<$item>> for $into<'a> {
            fn from(slice: &'a Vec<$item>) -> Self {
                Self::$variant(slice)
            }
        }

        impl<'a, const N: usize> From<&'a [$item; N]> for $into<'a> {
            fn from(slice: &'a [$item; N]) -> Self {
                Self::$variant(slice)
            }
        }
    )*};
}

slices!([f32; 3] => Positions::Slice, [u32; 3] => Indices::Triangles, u32 => Indices::U32, u16 => Indices::U16);

impl Positions<'_> {
    /// # Errors
    /// A stride that leads out of the buffer; a position that is not finite; too many.
    pub(crate) fn to_vec(self) -> Result<Vec<[f32; 3]>, MeshError> {
        let mut positions = Vec::new();
        self.write_into(&mut positions)?;
        Ok(positions)
    }

    /// Replaces what `room` holds, in its memory if that is enough.
    ///
    /// # Errors
    /// As [`Positions::to_vec`].
    pub(crate) fn write_into(self, room: &mut Vec<[f32; 3]>) -> Result<(), MeshError> {
        room.clear();
        match self {
            Self::Slice(positions) => {
                reserve(room, positions.len());
                for (piece, some) in positions.chunks(PIECE).enumerate() {
                    room.extend_from_slice(some);
                    check_piece(piece, some)?;
                }
            }
            Self::Strided { bytes, offset, stride, count } => {
                let out_of_range = MeshError::StrideOutOfRange { stride, offset, count, bytes: bytes.len() };
                let end = count
                    .checked_sub(1)
                    .map_or(Some(0), |last| last.checked_mul(stride)?.checked_add(offset)?.checked_add(12));
                if end.is_none_or(|end| end > bytes.len()) {
                    return Err(out_of_range);
                }
                reserve(room, count);
                room.extend((0..count).map(|i| read_position(&bytes[offset + i * stride..])));
                check_finite(room)?;
            }
        }
        match u32::try_from(room.len()) {
            Ok(_) => Ok(()),
            Err(_) => Err(MeshError::TooMany { what: "vertices", count: room.len() }),
        }
    }
}

/// Positions that are copied and checked at one go, while the nearest cache holds them.
const PIECE: usize = 1024;

fn reserve(room: &mut Vec<[f32; 3]>, count: usize) {
    if room.capacity() < count {
        *room = vec_in_large_pages(count);
    }
}

fn read_position(bytes: &[u8]) -> [f32; 3] {
    [0, 4, 8].map(|at| f32::from_le_bytes([bytes[at], bytes[at + 1], bytes[at + 2], bytes[at + 3]]))
}

/// # Errors
/// The first vertex that is not finite.
pub(crate) fn check_finite(positions: &[[f32; 3]]) -> Result<(), MeshError> {
    positions.chunks(PIECE).enumerate().try_for_each(|(piece, some)| check_piece(piece, some))
}

fn check_piece(piece: usize, positions: &[[f32; 3]]) -> Result<(), MeshError> {
    if all_finite(positions) {
        return Ok(());
    }
    let bad = positions.iter().position(|position| !crate::geometry::is_finite(*position));
    bad.map_or(Ok(()), |at| Err(MeshError::NonFinite { at: piece * PIECE + at }))
}

/// Whether all are numbers, and finite.
pub(crate) fn all_finite(positions: &[[f32; 3]]) -> bool {
    // Without its sign, what is not finite has all bits of the exponent: one more carries into the sign.
    let carried = |x: f32| (x.to_bits() & 0x7fff_ffff).wrapping_add(0x0080_0000);
    let carries = positions.as_flattened().iter().fold(0, |carries, &x| carries | carried(x));
    carries >> 31 == 0
}

impl Indices<'_> {
    /// # Errors
    /// A part of a triangle; an index out of range; too many.
    pub(crate) fn to_triangles(self, vertices: usize) -> Result<Vec<[u32; 3]>, MeshError> {
        let triangles = match self {
            Self::Triangles(triangles) => triangles.to_vec(),
            Self::U32(indices) => in_threes(indices)?,
            Self::U16(indices) => in_threes(indices)?,
        };
        if triangles.len() > 1 << 27 {
            return Err(MeshError::TooMany { what: "triangles", count: triangles.len() });
        }
        for (triangle, corners) in triangles.iter().enumerate() {
            if let Some(&index) = corners.iter().find(|&&index| index as usize >= vertices) {
                return Err(MeshError::IndexOutOfRange { triangle, index, vertices });
            }
        }
        Ok(triangles)
    }
}

fn in_threes<T: Copy + Into<u32>>(indices: &[T]) -> Result<Vec<[u32; 3]>, MeshError> {
    let (triangles, rest) = indices.as_chunks::<3>();
    if !rest.is_empty() {
        return Err(MeshError::NotWholeTriangles { count: indices.len() });
    }
    Ok(triangles.iter().map(|corners| corners.map(Into::into)).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_position_that_is_not_finite_is_named() {
        let good = [f32::MAX, -f32::MAX, f32::MIN_POSITIVE * 0.5];
        for bad in [f32::NAN, -f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
            for at in [0, 1, PIECE - 1, PIECE, 3 * PIECE + 17] {
                let mut positions = vec![good; 3 * PIECE + 18];
                assert_eq!(check_finite(&positions), Ok(()));
                positions[at][at % 3] = bad;
                let mut room = Vec::new();
                assert_eq!(check_finite(&positions), Err(MeshError::NonFinite { at }));
                assert_eq!(Positions::Slice(&positions).write_into(&mut room), Err(MeshError::NonFinite { at }));
            }
        }
    }

    #[test]
    fn room_is_used_again() {
        let mut room = Vec::new();
        let given = vec![[1.0, 2.0, 3.0]; 5000];
        Positions::Slice(&given).write_into(&mut room).unwrap();
        let place = room.as_ptr();
        Positions::Slice(&given[..4000]).write_into(&mut room).unwrap();
        assert_eq!((room.as_ptr(), &room[..]), (place, &given[..4000]));
    }
}
