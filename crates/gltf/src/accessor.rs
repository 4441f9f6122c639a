//! Reading numbers out of buffers.
//!
//! glTF 2.0 specification, section 3.6.2. Everything is checked before it is used: views lie within
//! buffers, elements within views, and sparse indices within the accessor.

use std::sync::Arc;

use crate::budget::Budget;
use crate::document::Document;
use crate::error::{Item, Problem};
use crate::json::{Accessor, ComponentType, ElementType, Index, Sparse, View};

/// Reads accessors of one file.
pub(crate) struct Accessors<'a> {
    document: &'a Document,
    buffers: &'a [Arc<[u8]>],
    budget: &'a Budget,
}

/// Elements of one size at equal distances; all of them lie within `bytes`.
struct Elements<'a> {
    bytes: &'a [u8],
    size: usize,
    stride: usize,
    count: usize,
}

impl<'a> Elements<'a> {
    fn iter(&self) -> impl Iterator<Item = &'a [u8]> + use<'a> {
        let (bytes, size, stride) = (self.bytes, self.size, self.stride);
        (0..self.count).map(move |i| &bytes[i * stride..i * stride + size])
    }
}

impl<'a> Accessors<'a> {
    pub(crate) fn new(document: &'a Document, buffers: &'a [Arc<[u8]>], budget: &'a Budget) -> Self {
        Self { document, buffers, budget }
    }

    /// Vectors of `N` numbers; integers are mapped to 0..=1 or -1..=1 when the accessor is
    /// normalised.
    pub(crate) fn floats<const N: usize>(
        &self,
        index: Index<Accessor>,
        element_type: ElementType,
        from: &Item,
    ) -> Result<Vec<[f32; N]>, Problem> {
        let (accessor, item) = self.accessor(index, element_type, from)?;
        let component = component_type(accessor, &item)?;
        match (component, accessor.normalized) {
            (ComponentType::F32, _) => self.read(accessor, &item, f32::from_le_bytes),
            (ComponentType::U32, _) => self.read(accessor, &item, |b| u32::from_le_bytes(b) as f32),
            (ComponentType::U8, false) => self.read(accessor, &item, |[b]| f32::from(b)),
            (ComponentType::U8, true) => self.read(accessor, &item, |[b]| f32::from(b) / 255.0),
            (ComponentType::I8, false) => self.read(accessor, &item, |b| f32::from(i8::from_le_bytes(b))),
            (ComponentType::I8, true) => {
                self.read(accessor, &item, |b| (f32::from(i8::from_le_bytes(b)) / 127.0).max(-1.0))
            }
            (ComponentType::U16, false) => self.read(accessor, &item, |b| f32::from(u16::from_le_bytes(b))),
            (ComponentType::U16, true) => self.read(accessor, &item, |b| f32::from(u16::from_le_bytes(b)) / 65535.0),
            (ComponentType::I16, false) => self.read(accessor, &item, |b| f32::from(i16::from_le_bytes(b))),
            (ComponentType::I16, true) => {
                self.read(accessor, &item, |b| (f32::from(i16::from_le_bytes(b)) / 32767.0).max(-1.0))
            }
        }
    }

    /// Vectors of `N` unsigned integers.
    pub(crate) fn integers<const N: usize>(
        &self,
        index: Index<Accessor>,
        element_type: ElementType,
        from: &Item,
    ) -> Result<Vec<[u32; N]>, Problem> {
        let (accessor, item) = self.accessor(index, element_type, from)?;
        match component_type(accessor, &item)? {
            ComponentType::U8 => self.read(accessor, &item, |[b]| u32::from(b)),
            ComponentType::U16 => self.read(accessor, &item, |b| u32::from(u16::from_le_bytes(b))),
            ComponentType::U32 => self.read(accessor, &item, u32::from_le_bytes),
            _ => Err(item.invalid("holds no unsigned integers, where they are needed")),
        }
    }

    /// The type of the elements of an accessor.
    pub(crate) fn element_type(&self, index: Index<Accessor>, from: &Item) -> Result<ElementType, Problem> {
        match self.document.get(index, "accessor", from)?.element_type {
            ElementType::Unknown => Err(Item::new("accessor", index.value()).invalid("has an unknown type")),
            element_type => Ok(element_type),
        }
    }

    /// The bytes of a buffer view.
    pub(crate) fn view(&self, index: Index<View>, from: &Item) -> Result<&'a [u8], Problem> {
        let view = self.document.get(index, "buffer view", from)?;
        let item = Item::named("buffer view", index.value(), view.name.as_deref());
        self.document.get(view.buffer, "buffer", &item)?;
        let bytes: &'a [u8] = &self.buffers[view.buffer.value()];
        let start = view.byte_offset;
        let end = start.checked_add(view.byte_length).filter(|&end| end <= bytes.len() as u64);
        match end {
            Some(end) => Ok(&bytes[start as usize..end as usize]),
            None => Err(item.invalid("lies beyond its buffer")),
        }
    }

    fn accessor(
        &self,
        index: Index<Accessor>,
        element_type: ElementType,
        from: &Item,
    ) -> Result<(&'a Accessor, Item), Problem> {
        let accessor = self.document.get(index, "accessor", from)?;
        let item = Item::named("accessor", index.value(), accessor.name.as_deref());
        match accessor.element_type {
            found if found == element_type => Ok((accessor, item)),
            ElementType::Unknown => Err(item.invalid("has an unknown type")),
            found => Err(item.invalid(format!("is {found:?}, where {element_type:?} is needed by {from}"))),
        }
    }

    fn read<T: Copy + Default, const N: usize, const S: usize>(
        &self,
        accessor: &Accessor,
        item: &Item,
        decode: impl Fn([u8; S]) -> T + Copy,
    ) -> Result<Vec<[T; N]>, Problem> {
        let count = accessor.count;
        self.budget.spend_numbers(count.saturating_mul(N as u64), item)?;
        let element = |bytes: &[u8]| -> [T; N] {
            std::array::from_fn(|i| decode(bytes[i * S..][..S].try_into().expect("a slice of S has S bytes")))
        };
        let mut values = match accessor.buffer_view {
            Some(view) => self.elements(view, accessor.byte_offset, count, N * S, item)?.iter().map(element).collect(),
            None => vec![[T::default(); N]; count as usize],
        };
        if let Some(sparse) = &accessor.sparse {
            if sparse.count > count {
                return Err(item.invalid("replaces more elements than it has"));
            }
            let indices = self.sparse_indices(sparse, item)?;
            let (view, offset) = (sparse.values.buffer_view, sparse.values.byte_offset);
            let replacements = self.elements(view, offset, sparse.count, N * S, item)?;
            for (index, bytes) in indices.zip(replacements.iter()) {
                let length = values.len();
                let value = values.get_mut(index as usize);
                *value.ok_or_else(|| item.invalid(format!("replaces element {index} of {length}")))? = element(bytes);
            }
        }
        Ok(values)
    }

    fn sparse_indices(&self, sparse: &Sparse, item: &Item) -> Result<impl Iterator<Item = u32> + use<'a>, Problem> {
        let size = match ComponentType::of(sparse.indices.component_type) {
            Some(ComponentType::U8) => 1,
            Some(ComponentType::U16) => 2,
            Some(ComponentType::U32) => 4,
            _ => return Err(item.invalid("has sparse indices of an unknown type")),
        };
        let indices = &sparse.indices;
        let elements = self.elements(indices.buffer_view, indices.byte_offset, sparse.count, size, item)?;
        Ok(elements.iter().map(|bytes| bytes.iter().rev().fold(0, |value, &byte| value << 8 | u32::from(byte))))
    }

    /// `count` elements of `size` bytes from `offset` in a view, if they are there.
    fn elements(
        &self,
        view: Index<View>,
        offset: u64,
        count: u64,
        size: usize,
        item: &Item,
    ) -> Result<Elements<'a>, Problem> {
        let bytes = self.view(view, item)?;
        let stride = self.document.get(view, "buffer view", item)?.byte_stride.unwrap_or(size as u64);
        if stride < size as u64 {
            return Err(item.invalid(format!("has elements of {size} bytes that are only {stride} bytes apart")));
        }
        let end = match count.checked_sub(1) {
            None => Some(0),
            Some(gaps) => gaps
                .checked_mul(stride)
                .and_then(|start_of_last| start_of_last.checked_add(size as u64))
                .and_then(|length| length.checked_add(offset)),
        };
        match end {
            Some(end) if end <= bytes.len() as u64 => {
                let bytes = if count == 0 { &[] } else { &bytes[offset as usize..end as usize] };
                Ok(Elements { bytes, size, stride: stride as usize, count: count as usize })
            }
            _ => Err(item.invalid("lies beyond its buffer view")),
        }
    }
}

fn component_type(accessor: &Accessor, item: &Item) -> Result<ComponentType, Problem> {
    ComponentType::of(accessor.component_type).ok_or_else(|| item.invalid("has an unknown component type"))
}
