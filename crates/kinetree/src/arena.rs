//! Memory for trees: large pages where the system has them, so that a step from node to node seldom waits for an address.

/// Room for `count` values, in large pages if it is large.
pub(crate) fn with_room<T>(count: usize) -> Vec<T> {
    let room: Vec<T> = Vec::with_capacity(count);
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
    fn room_is_room_whatever_its_size() {
        for count in [0, 1, 1000, 3_000_000] {
            let mut room: Vec<u64> = with_room(count);
            assert!(room.capacity() >= count);
            room.extend(0..count as u64);
            assert!(room.iter().enumerate().all(|(i, x)| i as u64 == *x));
        }
    }
}
