//! Vectors that several threads fill in parallel, in chunks.

use std::mem::MaybeUninit;

use super::vec_in_large_pages;
use crate::threads::Threads;

/// A chunk of a vector that is being filled.
pub(crate) struct ChunkWriter<'a, T> {
    memory: &'a mut [MaybeUninit<T>],
    /// The values before this index are initialised.
    len: usize,
}

impl<T: Copy> ChunkWriter<'_, T> {
    /// # Panics
    /// When the chunk is full.
    #[inline(always)]
    pub(crate) fn push(&mut self, value: T) {
        self.memory[self.len] = MaybeUninit::new(value);
        self.len += 1;
    }

    /// The values pushed so far.
    #[inline(always)]
    pub(crate) fn written(&self) -> &[T] {
        // SAFETY: everything before `len` has been written, and `MaybeUninit<T>` is laid out as `T`
        // is.
        unsafe { &*(&raw const self.memory[..self.len] as *const [T]) }
    }

    /// The number of values that must be pushed in all.
    #[inline(always)]
    pub(crate) fn size(&self) -> usize {
        self.memory.len()
    }
}

/// Fills a new vector of `count` values in parallel, and returns it with the results of `write`,
/// one per chunk. `write` gets the index of the chunk's first value.
///
/// # Panics
/// When `write` leaves a chunk unfilled.
pub(crate) fn vec_in_chunks<T: Copy + Send, R: Send>(
    count: usize,
    chunk: usize,
    threads: &Threads,
    write: &(impl Fn(usize, &mut ChunkWriter<'_, T>) -> R + Sync),
) -> (Vec<T>, Vec<R>) {
    fill_in_chunks(vec_in_large_pages(count), count, chunk, threads, write)
}

/// As [`vec_in_chunks`], in an empty vector that has the capacity.
///
/// # Panics
/// When `write` leaves a chunk unfilled, or the capacity is below `count`.
pub(crate) fn fill_in_chunks<T: Copy + Send, R: Send>(
    mut list: Vec<T>,
    count: usize,
    chunk: usize,
    threads: &Threads,
    write: &(impl Fn(usize, &mut ChunkWriter<'_, T>) -> R + Sync),
) -> (Vec<T>, Vec<R>) {
    assert!(list.is_empty(), "a list that is written from its start");
    if count <= chunk {
        // One chunk needs no list of chunks, which takes longer to allocate than many a chunk to
        // fill.
        let mut writer = ChunkWriter { memory: &mut list.spare_capacity_mut()[..count], len: 0 };
        let found = if count > 0 { vec![write(0, &mut writer)] } else { Vec::new() };
        assert!(writer.len == count, "a chunk is not full");
        // SAFETY: the chunk covers the first `count` values, and has been written to its end.
        unsafe { list.set_len(count) };
        return (list, found);
    }
    let memories = list.spare_capacity_mut()[..count].chunks_mut(chunk);
    let mut work: Vec<(ChunkWriter<'_, T>, Option<R>)> =
        memories.map(|memory| (ChunkWriter { memory, len: 0 }, None)).collect();
    threads.for_each(&mut work, 1, &|number, (writer, found)| *found = Some(write(number * chunk, writer)));
    assert!(work.iter().all(|(chunk, _)| chunk.len == chunk.memory.len()), "a chunk is not full");
    let found = work.into_iter().filter_map(|(_, found)| found).collect();
    // SAFETY: the chunks cover the first `count` values, and each has been written to its end.
    unsafe { list.set_len(count) };
    (list, found)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_written_in_chunks_is_one_vector() {
        for threads in [Threads::one(), Threads::default()] {
            for count in [0, 1, 99, 100, 101, 5000] {
                let (list, sums) = vec_in_chunks(count, 100, &threads, &|first, chunk| {
                    (first..first + chunk.size()).for_each(|i| chunk.push(i));
                    chunk.written().iter().sum::<usize>()
                });
                assert!(list.iter().copied().eq(0..count));
                assert_eq!(sums.len(), count.div_ceil(100));
                assert_eq!(sums.iter().sum::<usize>(), list.iter().sum());
            }
        }
    }

    #[test]
    #[should_panic(expected = "not full")]
    fn a_chunk_has_to_be_filled() {
        vec_in_chunks(150, 100, &Threads::one(), &|first, chunk| (first..100).for_each(|i| chunk.push(i)));
    }
}
