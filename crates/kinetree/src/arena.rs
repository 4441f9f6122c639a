//! Memory for trees and for walks through them: large pages where the system has them, so that a step from node to node seldom waits for an address; and a stack
//! that costs nothing until it is used.

use std::mem::MaybeUninit;

use crate::threads::Threads;

/// Room for a stack of `N`. Making it costs nothing: to zero it would be a call, and longer than the walk of many a ray.
pub(crate) struct StackRoom<T, const N: usize>([MaybeUninit<T>; N]);

impl<T: Copy, const N: usize> StackRoom<T, N> {
    #[inline(always)]
    pub(crate) fn new() -> Self {
        Self([const { MaybeUninit::uninit() }; N])
    }

    /// With nothing on it.
    #[inline(always)]
    pub(crate) fn stack(&mut self) -> Stack<'_, T, N> {
        Stack { room: &mut self.0, top: N }
    }
}

/// A stack in room that stands elsewhere, so that its top can stay in a register.
pub(crate) struct Stack<'a, T, const N: usize> {
    /// Everything from `top` on has been written.
    room: &'a mut [MaybeUninit<T>; N],
    top: usize,
}

impl<T: Copy, const N: usize> Stack<'_, T, N> {
    /// # Panics
    /// When the stack is full.
    #[inline(always)]
    pub(crate) fn push(&mut self, value: T) {
        let top = self.top.wrapping_sub(1);
        self.room[top] = MaybeUninit::new(value);
        self.top = top;
    }

    #[inline(always)]
    pub(crate) fn pop(&mut self) -> Option<T> {
        let top = self.top;
        if top >= N {
            return None;
        }
        self.top = top + 1;
        // SAFETY: everything from `top` on has been written.
        Some(unsafe { self.room[top].assume_init() })
    }
}

/// Memory read in rows of eight numbers, from places that are counted in units of eight bytes, so that an address is a place added to where the rows begin.
#[derive(Clone, Copy)]
pub(crate) struct Rows<'a> {
    rows: &'a [[f32; 8]],
    /// The last place that has eight rows behind it.
    last: usize,
}

/// A place with eight rows behind it.
#[derive(Clone, Copy)]
pub(crate) struct EightRows<'a> {
    rows: &'a [[f32; 8]],
    /// At most `last`.
    place: usize,
}

impl<'a> Rows<'a> {
    /// How many places there are to a row.
    pub(crate) const PLACES: usize = size_of::<[f32; 8]>() / 8;

    /// `None` when there are less than eight rows.
    #[inline(always)]
    pub(crate) fn new(rows: &'a [[f32; 8]]) -> Option<Self> {
        Some(Self { rows, last: rows.len().checked_sub(8)? * Self::PLACES })
    }

    /// # Panics
    /// When there are no eight rows behind the place.
    #[inline(always)]
    pub(crate) fn at(self, place: u32) -> EightRows<'a> {
        let place = place as usize;
        assert!(place <= self.last, "no rows behind place {place}");
        EightRows { rows: self.rows, place }
    }
}

impl<'a> EightRows<'a> {
    /// # Panics
    /// When the number is not below eight.
    #[inline(always)]
    pub(crate) fn row(self, number: usize) -> &'a [f32; 8] {
        assert!(number < 8, "one of eight rows");
        // The row comes first, because it does not change from node to node.
        let row = self.rows.as_ptr().wrapping_add(number);
        // SAFETY: behind the place there are eight rows, all of which live as long as the slice; and every place is aligned for numbers of four bytes.
        unsafe { &*row.cast::<u64>().wrapping_add(self.place).cast::<[f32; 8]>() }
    }
}

/// Room for `count` values, in large pages if it is large.
pub(crate) fn with_room<T>(count: usize) -> Vec<T> {
    let room: Vec<T> = Vec::with_capacity(count);
    prefer_large_pages(&room);
    room
}

/// A piece of a list that is being written.
pub(crate) struct Piece<'a, T> {
    room: &'a mut [MaybeUninit<T>],
    /// Everything before this has been written.
    len: usize,
}

impl<T: Copy> Piece<'_, T> {
    /// # Panics
    /// When the piece is full.
    #[inline(always)]
    pub(crate) fn push(&mut self, value: T) {
        self.room[self.len] = MaybeUninit::new(value);
        self.len += 1;
    }

    /// What has been pushed.
    #[inline(always)]
    pub(crate) fn written(&self) -> &[T] {
        // SAFETY: everything before `len` has been written, and `MaybeUninit<T>` is laid out as `T` is.
        unsafe { &*(&raw const self.room[..self.len] as *const [T]) }
    }

    /// How many have to be pushed in all.
    #[inline(always)]
    pub(crate) fn size(&self) -> usize {
        self.room.len()
    }
}

/// A list that all threads write at once, each a piece at a time, in memory that nobody has touched before; and what the writers have found out. They are told the
/// number of their first item.
///
/// # Panics
/// When a piece is not full in the end.
pub(crate) fn written<T: Copy + Send, R: Send>(
    count: usize,
    piece: usize,
    threads: &Threads,
    write: &(impl Fn(usize, &mut Piece<'_, T>) -> R + Sync),
) -> (Vec<T>, Vec<R>) {
    written_into(with_room(count), count, piece, threads, write)
}

/// The same in a list that is empty, and has room.
///
/// # Panics
/// When a piece is not full in the end, or the room is too small.
pub(crate) fn written_into<T: Copy + Send, R: Send>(
    mut list: Vec<T>,
    count: usize,
    piece: usize,
    threads: &Threads,
    write: &(impl Fn(usize, &mut Piece<'_, T>) -> R + Sync),
) -> (Vec<T>, Vec<R>) {
    assert!(list.is_empty(), "a list that is written from its start");
    let rooms = list.spare_capacity_mut()[..count].chunks_mut(piece);
    let mut work: Vec<(Piece<'_, T>, Option<R>)> = rooms.map(|room| (Piece { room, len: 0 }, None)).collect();
    threads.for_each(&mut work, 1, &|number, (room, found)| *found = Some(write(number * piece, room)));
    assert!(work.iter().all(|(piece, _)| piece.len == piece.room.len()), "a piece is not full");
    let found = work.into_iter().filter_map(|(_, found)| found).collect();
    // SAFETY: the pieces are all that there is, and all of them have been written to their ends.
    unsafe { list.set_len(count) };
    (list, found)
}

/// Asks for large pages behind the room of a vector. Best before it is filled: pages that are there already stay small.
#[cfg(target_os = "linux")]
fn prefer_large_pages<T>(room: &Vec<T>) {
    const LARGE: usize = 2 << 20;
    let start = room.as_ptr() as usize;
    let end = start + room.capacity() * size_of::<T>();
    let (first, last) = (start.next_multiple_of(LARGE), end / LARGE * LARGE);
    if first < last {
        // SAFETY: the range lies within memory that `room` owns; the advice changes neither its contents nor who may use it, and failing is harmless.
        unsafe { libc::madvise(first as *mut libc::c_void, last - first, libc::MADV_HUGEPAGE) };
    }
}

#[cfg(not(target_os = "linux"))]
fn prefer_large_pages<T>(_: &Vec<T>) {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_pushed_last_is_popped_first() {
        let mut room = StackRoom::<u32, 3>::new();
        let mut stack = room.stack();
        assert_eq!(stack.pop(), None);
        for value in [1, 2, 3] {
            stack.push(value);
        }
        assert_eq!([stack.pop(), stack.pop()], [Some(3), Some(2)]);
        stack.push(4);
        assert_eq!([stack.pop(), stack.pop(), stack.pop()], [Some(4), Some(1), None]);
    }

    #[test]
    #[should_panic]
    fn a_full_stack_takes_no_more() {
        let mut room = StackRoom::<u32, 1>::new();
        let mut stack = room.stack();
        stack.push(1);
        stack.push(2);
    }

    #[test]
    fn rows_stand_behind_their_places() {
        let numbers: Vec<[f32; 8]> =
            (0..24).map(|row| [0, 1, 2, 3, 4, 5, 6, 7].map(|i| (8 * row + i) as f32)).collect();
        assert!(Rows::new(&numbers[..7]).is_none());
        let rows = Rows::new(&numbers).unwrap();
        for place in 0..=64 {
            let eight = rows.at(place);
            for row in 0..8 {
                assert_eq!(eight.row(row)[0], (2 * place as usize + 8 * row) as f32);
            }
        }
        assert!(std::panic::catch_unwind(|| rows.at(65)).is_err());
        assert!(std::panic::catch_unwind(|| rows.at(u32::MAX)).is_err());
        assert!(std::panic::catch_unwind(|| rows.at(0).row(8)).is_err());
    }

    #[test]
    fn what_is_written_in_pieces_is_one_list() {
        for threads in [Threads::one(), Threads::default()] {
            for count in [0, 1, 99, 100, 101, 5000] {
                let (list, sums) = written(count, 100, &threads, &|first, piece| {
                    (first..first + piece.size()).for_each(|i| piece.push(i));
                    piece.written().iter().sum::<usize>()
                });
                assert!(list.iter().copied().eq(0..count));
                assert_eq!(sums.len(), count.div_ceil(100));
                assert_eq!(sums.iter().sum::<usize>(), list.iter().sum());
            }
        }
    }

    #[test]
    #[should_panic(expected = "not full")]
    fn a_piece_has_to_be_filled() {
        written(150, 100, &Threads::one(), &|first, piece| (first..100).for_each(|i| piece.push(i)));
    }

    #[test]
    fn room_is_room_whatever_its_size() {
        for count in [0, 1, 1000, 3_000_000] {
            let mut room: Vec<u64> = with_room(count);
            assert!(room.capacity() >= count);
            room.extend(0..count as u64);
            assert!(room.iter().enumerate().all(|(i, x)| i as u64 == *x));
        }
    }
}
