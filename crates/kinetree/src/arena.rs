//! Memory for trees and for walks through them: large pages where the system has them, so that a step from node to node seldom waits for an address; and a stack
//! that costs nothing until it is used.

use std::mem::MaybeUninit;

/// A stack with room for `N`. Making one costs nothing: to zero it would be a call, and longer than the walk of many a ray.
pub(crate) struct Stack<T, const N: usize> {
    /// Everything from `top` on has been written.
    room: [MaybeUninit<T>; N],
    top: usize,
}

impl<T: Copy, const N: usize> Stack<T, N> {
    #[inline(always)]
    pub(crate) fn new() -> Self {
        Self { room: [const { MaybeUninit::uninit() }; N], top: N }
    }

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

/// Room for `count` values, in large pages if it is large.
pub(crate) fn with_room<T>(count: usize) -> Vec<T> {
    let room: Vec<T> = Vec::with_capacity(count);
    prefer_large_pages(&room);
    room
}

/// `count` times zero, in large pages if that is much. The system hands pages out zeroed, so nothing is written until the caller does.
pub(crate) fn zeroed<T: bytemuck::Zeroable>(count: usize) -> Vec<T> {
    let room = bytemuck::zeroed_vec(count);
    prefer_large_pages(&room);
    room
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
        let mut stack = Stack::<u32, 3>::new();
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
        let mut stack = Stack::<u32, 1>::new();
        stack.push(1);
        stack.push(2);
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
