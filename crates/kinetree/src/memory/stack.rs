//! A fixed-size stack that is not zeroed.

use std::mem::MaybeUninit;

/// Uninitialised memory for a stack of `N` values. Zeroing it would be a call to `memset`, which
/// takes longer than the traversal of a short ray.
pub(crate) struct StackBuffer<T, const N: usize>([MaybeUninit<T>; N]);

impl<T: Copy, const N: usize> StackBuffer<T, N> {
    #[inline(always)]
    pub(crate) fn new() -> Self {
        Self([const { MaybeUninit::uninit() }; N])
    }

    /// An empty stack in this memory.
    #[inline(always)]
    pub(crate) fn stack(&mut self) -> Stack<'_, T, N> {
        Stack { memory: &mut self.0, top: N }
    }
}

/// A stack in borrowed memory, so that its top can stay in a register. It grows downwards.
pub(crate) struct Stack<'a, T, const N: usize> {
    /// The values from `top` on are initialised.
    memory: &'a mut [MaybeUninit<T>; N],
    top: usize,
}

impl<T: Copy, const N: usize> Stack<'_, T, N> {
    /// # Panics
    /// When the stack is full.
    #[inline(always)]
    pub(crate) fn push(&mut self, value: T) {
        let top = self.top.wrapping_sub(1);
        self.memory[top] = MaybeUninit::new(value);
        self.top = top;
    }

    #[inline(always)]
    pub(crate) fn pop(&mut self) -> Option<T> {
        let top = self.top;
        if top >= N {
            return None;
        }
        self.top = top + 1;
        // SAFETY: the values from `top` on are initialised.
        Some(unsafe { self.memory[top].assume_init() })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_pushed_last_is_popped_first() {
        let mut buffer = StackBuffer::<u32, 3>::new();
        let mut stack = buffer.stack();
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
        let mut buffer = StackBuffer::<u32, 1>::new();
        let mut stack = buffer.stack();
        stack.push(1);
        stack.push(2);
    }
}
