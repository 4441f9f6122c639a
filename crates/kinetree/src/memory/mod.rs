//! Memory for trees and traversal: a [stack](stack), vectors in [large pages](large_pages), and
//! vectors [filled in parallel](chunk_writer).

mod chunk_writer;
mod large_pages;
mod stack;

pub(crate) use chunk_writer::{ChunkWriter, fill_in_chunks, vec_in_chunks};
pub(crate) use large_pages::vec_in_large_pages;
pub(crate) use stack::{Stack, StackBuffer};
