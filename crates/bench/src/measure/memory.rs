//! The heap memory of a build: counted by the allocator of this program, and by the C library for
//! engines in C++.

use std::alloc::{GlobalAlloc, Layout, System};
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicIsize, Ordering::Relaxed};

/// The system's allocator, which counts while `count` runs.
pub(crate) struct Counting;

static COUNTED: AtomicBool = AtomicBool::new(false);
static NOW: AtomicIsize = AtomicIsize::new(0);
static MOST: AtomicIsize = AtomicIsize::new(0);
/// Held while a job is counted, so that only one is at a time.
static WINDOW: Mutex<()> = Mutex::new(());

fn add(bytes: isize) {
    if COUNTED.load(Relaxed) {
        let now = NOW.fetch_add(bytes, Relaxed) + bytes;
        MOST.fetch_max(now, Relaxed);
    }
}

// SAFETY: every call is forwarded unchanged to the system's allocator; counting touches no memory
// but three atomics.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        add(layout.size() as isize);
        // SAFETY: the caller fulfils the requirements of the system's allocator.
        unsafe { System.alloc(layout) }
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        add(layout.size() as isize);
        // SAFETY: as above.
        unsafe { System.alloc_zeroed(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        add(-(layout.size() as isize));
        // SAFETY: as above.
        unsafe { System.dealloc(pointer, layout) }
    }

    unsafe fn realloc(&self, pointer: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        add(size as isize - layout.size() as isize);
        // SAFETY: as above.
        unsafe { System.realloc(pointer, layout, size) }
    }
}

/// The heap memory of a job.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct HeapUse {
    /// Bytes that are still allocated at its end.
    pub(crate) after: usize,
    /// The most bytes that were allocated at once.
    pub(crate) peak: usize,
}

/// Runs a job and counts what all threads allocate meanwhile.
pub(crate) fn count<R>(job: impl FnOnce() -> R) -> (R, HeapUse) {
    let _one_at_a_time = WINDOW.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
    NOW.store(0, Relaxed);
    MOST.store(0, Relaxed);
    COUNTED.store(true, Relaxed);
    let result = job();
    COUNTED.store(false, Relaxed);
    let bytes = |count: &AtomicIsize| count.load(Relaxed).max(0) as usize;
    (result, HeapUse { after: bytes(&NOW), peak: bytes(&MOST) })
}

/// Bytes that the C library has allocated, if it can tell.
#[cfg_attr(not(feature = "tinybvh"), allow(dead_code))]
pub(crate) fn c_heap_bytes() -> Option<usize> {
    #[cfg(all(target_os = "linux", target_env = "gnu"))]
    {
        // SAFETY: the call has no arguments and reads the C library's counters.
        let counts = unsafe { libc::mallinfo2() };
        Some(counts.uordblks + counts.hblkhd)
    }
    #[cfg(not(all(target_os = "linux", target_env = "gnu")))]
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn current_and_peak_bytes_are_counted_separately() {
        // The memory is reserved but never touched. Other tests allocate meanwhile, but far less.
        let (kept, heap_use) = count(|| {
            drop(Vec::<u8>::with_capacity(400_000_000));
            Vec::<u8>::with_capacity(100_000_000)
        });
        assert!(kept.capacity() >= 100_000_000);
        assert!((50_000_000..150_000_000).contains(&heap_use.after), "{heap_use:?}");
        assert!((350_000_000..450_000_000).contains(&heap_use.peak), "{heap_use:?}");
    }
}
