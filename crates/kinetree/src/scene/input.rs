//! Positions and indices as callers have them.

use super::MeshError;

/// Positions, as a slice or spread over a vertex buffer.
#[derive(Debug, Clone, Copy)]
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
        let positions = match self {
            Self::Slice(positions) => positions.to_vec(),
            Self::Strided { bytes, offset, stride, count } => {
                let out_of_range = MeshError::StrideOutOfRange { stride, offset, count, bytes: bytes.len() };
                let end = count
                    .checked_sub(1)
                    .map_or(Some(0), |last| last.checked_mul(stride)?.checked_add(offset)?.checked_add(12));
                if end.is_none_or(|end| end > bytes.len()) {
                    return Err(out_of_range);
                }
                (0..count).map(|i| read_position(&bytes[offset + i * stride..])).collect()
            }
        };
        check_finite(&positions)?;
        match u32::try_from(positions.len()) {
            Ok(_) => Ok(positions),
            Err(_) => Err(MeshError::TooMany { what: "vertices", count: positions.len() }),
        }
    }
}

fn read_position(bytes: &[u8]) -> [f32; 3] {
    [0, 4, 8].map(|at| f32::from_le_bytes([bytes[at], bytes[at + 1], bytes[at + 2], bytes[at + 3]]))
}

/// # Errors
/// The first vertex that is not finite.
pub(crate) fn check_finite(positions: &[[f32; 3]]) -> Result<(), MeshError> {
    let bad = positions.iter().position(|position| !crate::geometry::is_finite(*position));
    bad.map_or(Ok(()), |at| Err(MeshError::NonFinite { at }))
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
