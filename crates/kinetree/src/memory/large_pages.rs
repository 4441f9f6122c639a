//! Vectors in large pages, where the system has them, which saves TLB misses in traversal.

/// An empty vector of capacity `count`, in large pages if it is large.
pub(crate) fn vec_in_large_pages<T>(count: usize) -> Vec<T> {
    let vec: Vec<T> = Vec::with_capacity(count);
    prefer_large_pages(&vec);
    vec
}

/// Asks for large pages for the memory of a vector. Call it before the vector is filled: pages that
/// are mapped already stay small.
#[cfg(target_os = "linux")]
fn prefer_large_pages<T>(vec: &Vec<T>) {
    const LARGE: usize = 2 << 20;
    let start = vec.as_ptr() as usize;
    let end = start + vec.capacity() * size_of::<T>();
    let (first, last) = (start.next_multiple_of(LARGE), end / LARGE * LARGE);
    if first < last {
        // SAFETY: the range lies within memory that `vec` owns; the advice changes neither its
        // contents nor who may use it, and its failure is harmless.
        unsafe { libc::madvise(first as *mut libc::c_void, last - first, libc::MADV_HUGEPAGE) };
    }
}

#[cfg(not(target_os = "linux"))]
fn prefer_large_pages<T>(_: &Vec<T>) {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_vector_has_room_whatever_its_size() {
        for count in [0, 1, 1000, 3_000_000] {
            let mut vec: Vec<u64> = vec_in_large_pages(count);
            assert!(vec.capacity() >= count);
            vec.extend(0..count as u64);
            assert!(vec.iter().enumerate().all(|(i, x)| i as u64 == *x));
        }
    }
}
