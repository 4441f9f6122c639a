//! Positions and indices in the forms in which callers have them.

use bytemuck::NoUninit;

use super::error::MeshError;
use crate::memory::vec_in_large_pages;

/// Positions, as a slice or spread over a vertex buffer.
#[derive(Debug, Clone, Copy)]
#[non_exhaustive]
pub enum Positions<'a> {
    /// One after the other.
    Slice(&'a [[f32; 3]]),
    /// Three floats every `stride` bytes, in the byte order of the processor (little-endian on all
    /// that are supported).
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

/// Vertex numbers, three per triangle.
#[derive(Debug, Clone, Copy)]
#[non_exhaustive]
pub enum Indices<'a> {
    /// Triangles.
    Triangles(&'a [[u32; 3]]),
    /// Triangles with short numbers. An array is handed over as a slice: `&triangles[..]`.
    ShortTriangles(&'a [[u16; 3]]),
    /// A flat list.
    U32(&'a [u32]),
    /// A flat list of short numbers.
    U16(&'a [u16]),
}

macro_rules! slices {
    ($($item:ty => $into:ident :: $variant:ident),* $(,)?) => {$(
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
    )*};
}

macro_rules! arrays {
    ($($item:ty => $into:ident :: $variant:ident),* $(,)?) => {$(
        impl<'a, const N: usize> From<&'a [$item; N]> for $into<'a> {
            fn from(array: &'a [$item; N]) -> Self {
                Self::$variant(array)
            }
        }
    )*};
}

slices!([f32; 3] => Positions::Slice);
slices!(
    [u32; 3] => Indices::Triangles,
    [u16; 3] => Indices::ShortTriangles,
    u32 => Indices::U32,
    u16 => Indices::U16,
);
// Not of `[u16; 3]`: the compiler would not know the type of the numbers in `&[[0, 1, 2]]`.
arrays!(
    [f32; 3] => Positions::Slice,
    [u32; 3] => Indices::Triangles,
    u32 => Indices::U32,
    u16 => Indices::U16,
);

/// The first three of four numbers: positions that are padded for the graphics processor.
impl<'a> From<&'a [[f32; 4]]> for Positions<'a> {
    fn from(padded: &'a [[f32; 4]]) -> Self {
        Self::in_vertices(padded, 0)
    }
}

impl<'a> From<&'a Vec<[f32; 4]>> for Positions<'a> {
    fn from(padded: &'a Vec<[f32; 4]>) -> Self {
        Self::in_vertices(padded, 0)
    }
}

#[cfg(feature = "glam")]
impl<'a> From<&'a [glam::Vec3]> for Positions<'a> {
    fn from(positions: &'a [glam::Vec3]) -> Self {
        Self::Slice(bytemuck::cast_slice(positions))
    }
}

#[cfg(feature = "glam")]
impl<'a> From<&'a Vec<glam::Vec3>> for Positions<'a> {
    fn from(positions: &'a Vec<glam::Vec3>) -> Self {
        Self::from(&positions[..])
    }
}

impl<'a> Positions<'a> {
    /// The positions in a list of vertices: three floats, `offset` bytes from the beginning of
    /// each. A vertex that does not hold them is an error when the positions are used
    /// ([`MeshError::StrideOutOfRange`]).
    ///
    /// ```
    /// use kinetree::{Mesh, Positions};
    ///
    /// #[derive(Clone, Copy, bytemuck::NoUninit)]
    /// #[repr(C)]
    /// struct Vertex {
    ///     color: [u8; 4],
    ///     position: [f32; 3],
    /// }
    ///
    /// let at = |position| Vertex { color: [255; 4], position };
    /// let vertices = [at([0.0; 3]), at([1.0, 0.0, 0.0]), at([0.0, 1.0, 0.0])];
    /// let positions = Positions::in_vertices(&vertices, std::mem::offset_of!(Vertex, position));
    /// let mesh = Mesh::new(positions, &[0_u16, 1, 2])?;
    /// assert_eq!(mesh.positions()[1], [1.0, 0.0, 0.0]);
    /// # Ok::<(), kinetree::MeshError>(())
    /// ```
    pub fn in_vertices<V: NoUninit>(vertices: &'a [V], offset: usize) -> Self {
        let (bytes, count) = (bytemuck::cast_slice(vertices), vertices.len());
        Self::Strided { bytes, offset, stride: size_of::<V>(), count }
    }
}

impl Positions<'_> {
    /// # Errors
    /// A stride that leads out of the buffer; a position that is not finite; too many.
    pub(crate) fn to_vec(self) -> Result<Vec<[f32; 3]>, MeshError> {
        let mut positions = Vec::new();
        self.write_into(&mut positions)?;
        Ok(positions)
    }

    /// Replaces the contents of `buffer`, in its memory if that is enough.
    ///
    /// # Errors
    /// As [`Positions::to_vec`].
    pub(crate) fn write_into(self, buffer: &mut Vec<[f32; 3]>) -> Result<(), MeshError> {
        buffer.clear();
        match self {
            Self::Slice(positions) => {
                reserve(buffer, positions.len());
                for (number, batch) in positions.chunks(BATCH).enumerate() {
                    buffer.extend_from_slice(batch);
                    check_batch(number, batch)?;
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
                reserve(buffer, count);
                buffer.extend((0..count).map(|i| read_position(&bytes[offset + i * stride..])));
                check_finite(buffer)?;
            }
        }
        match u32::try_from(buffer.len()) {
            Ok(_) => Ok(()),
            Err(_) => Err(MeshError::TooMany { what: "vertices", count: buffer.len() }),
        }
    }
}

/// Positions that are copied and checked at once, while the first-level cache holds them.
const BATCH: usize = 1024;

fn reserve(buffer: &mut Vec<[f32; 3]>, count: usize) {
    if buffer.capacity() < count {
        *buffer = vec_in_large_pages(count);
    }
}

fn read_position(bytes: &[u8]) -> [f32; 3] {
    [0, 4, 8].map(|at| f32::from_ne_bytes([bytes[at], bytes[at + 1], bytes[at + 2], bytes[at + 3]]))
}

/// # Errors
/// The first vertex that is not finite.
pub(crate) fn check_finite(positions: &[[f32; 3]]) -> Result<(), MeshError> {
    positions.chunks(BATCH).enumerate().try_for_each(|(number, batch)| check_batch(number, batch))
}

fn check_batch(number: usize, positions: &[[f32; 3]]) -> Result<(), MeshError> {
    if all_finite(positions) {
        return Ok(());
    }
    let bad = positions.iter().position(|position| !crate::geometry::is_finite(*position));
    bad.map_or(Ok(()), |at| Err(MeshError::NonFinite { at: number * BATCH + at }))
}

/// Whether no coordinate is infinite or NaN.
pub(crate) fn all_finite(positions: &[[f32; 3]]) -> bool {
    // An exponent of all ones means infinite or NaN: adding one to it carries into the sign bit.
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
            Self::ShortTriangles(triangles) => triangles.iter().map(|corners| corners.map(u32::from)).collect(),
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
            for at in [0, 1, BATCH - 1, BATCH, 3 * BATCH + 17] {
                let mut positions = vec![good; 3 * BATCH + 18];
                assert_eq!(check_finite(&positions), Ok(()));
                positions[at][at % 3] = bad;
                let mut buffer = Vec::new();
                assert_eq!(check_finite(&positions), Err(MeshError::NonFinite { at }));
                assert_eq!(Positions::Slice(&positions).write_into(&mut buffer), Err(MeshError::NonFinite { at }));
            }
        }
    }

    #[test]
    fn the_buffer_is_used_again() {
        let mut buffer = Vec::new();
        let given = vec![[1.0, 2.0, 3.0]; 5000];
        Positions::Slice(&given).write_into(&mut buffer).unwrap();
        let address = buffer.as_ptr();
        Positions::Slice(&given[..4000]).write_into(&mut buffer).unwrap();
        assert_eq!((buffer.as_ptr(), &buffer[..]), (address, &given[..4000]));
    }
}
