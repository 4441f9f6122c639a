//! Parallel radix sort of 64-bit keys.
//!
//! One pass distributes the keys by their most significant digit. Then groups of adjacent buckets
//! are sorted in parallel, each within a cache, least significant digit first.

use crate::memory::vec_in_large_pages;
use crate::threads::Threads;

const DIGIT_BITS: u32 = 11;
const DIGITS: usize = 1 << DIGIT_BITS;

/// The least number of keys in a group: half a megabyte with the second buffer.
const MIN_GROUP: usize = 32 * 1024;

/// Up to this many keys, a comparison sort is faster than clearing the counters.
const COMPARISON_SORT_LIMIT: usize = 1024;

/// Sorts keys that are already in order of their bits below `low`, and whose bits from `high` on
/// are zero.
pub(crate) fn sort(keys: &mut Vec<u64>, low: u32, high: u32, threads: &Threads) {
    if keys.len() <= COMPARISON_SORT_LIMIT {
        keys.sort_unstable();
        return;
    }
    let shift = high.saturating_sub(DIGIT_BITS).max(low);
    let mut ends = threads.reduce(keys, MIN_GROUP, &|slice| count(slice, shift), &|mut a, b| {
        a.iter_mut().zip(b.iter()).for_each(|(a, b)| *a += b);
        a
    });
    let mut distributed = vec_in_large_pages(keys.len());
    distributed.resize(keys.len(), 0);
    distribute(keys, &mut distributed, &mut starts(&ends), shift);
    let mut end = 0;
    ends.iter_mut().for_each(|count| {
        end += *count;
        *count = end;
    });
    let mut groups = Vec::new();
    let (mut rest, mut spare_rest, mut first) = (&mut distributed[..], &mut keys[..], 0);
    for &end in ends.iter() {
        let size = end as usize - first;
        if size >= MIN_GROUP || size > 0 && end as usize == first + rest.len() {
            let (group, others) = rest.split_at_mut(size);
            let (spare, spare_others) = spare_rest.split_at_mut(size);
            groups.push((group, spare));
            (rest, spare_rest, first) = (others, spare_others, end as usize);
        }
    }
    threads.for_each(&mut groups, 1, &|_, (group, spare)| sort_group(group, spare, low, high));
    *keys = distributed;
}

/// Sorts by the least significant digit first.
fn sort_group<'a>(mut keys: &'a mut [u64], mut spare: &'a mut [u64], low: u32, high: u32) {
    if keys.len() <= COMPARISON_SORT_LIMIT {
        keys.sort_unstable();
        return;
    }
    let mut in_place = true;
    for shift in (low..high).step_by(DIGIT_BITS as usize) {
        let counts = count(keys, shift);
        if counts.iter().any(|&count| count as usize == keys.len()) {
            continue;
        }
        distribute(keys, spare, &mut starts(&counts), shift);
        std::mem::swap(&mut keys, &mut spare);
        in_place = !in_place;
    }
    if !in_place {
        spare.copy_from_slice(keys);
    }
}

#[inline]
fn digit(key: u64, shift: u32) -> usize {
    (key >> shift) as usize & (DIGITS - 1)
}

/// The number of keys with each value of a digit.
fn count(keys: &[u64], shift: u32) -> Box<[u32; DIGITS]> {
    let mut counts = Box::new([0; DIGITS]);
    keys.iter().for_each(|&key| counts[digit(key, shift)] += 1);
    counts
}

/// The prefix sums: for each value of a digit, the number of keys with a smaller one.
fn starts(counts: &[u32; DIGITS]) -> [u32; DIGITS] {
    let mut next = 0;
    counts.map(|count| {
        next += count;
        next - count
    })
}

/// Distributes the keys to their buckets, keeping their order in each.
fn distribute(keys: &[u64], to: &mut [u64], starts: &mut [u32; DIGITS], shift: u32) {
    for &key in keys {
        let start = &mut starts[digit(key, shift)];
        to[*start as usize] = key;
        *start += 1;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_random::Random;

    #[test]
    fn digits_sort_as_comparing_does() {
        for seed in 0..20_u64 {
            let mut generator = Random(seed);
            let mut random = || generator.next() >> 33;
            let size = [0, 1, 2, 1000, 1025, 40_000, 150_000][seed as usize % 7];
            // Some inputs have few distinct codes, or codes that crowd together.
            let mask = [(1 << 44) - 1, 3, 0, 0x0FFF_0000_0FFF, 1 << 43][seed as usize % 5];
            let mut keys: Vec<u64> = (0..size).map(|id| (((random() << 31 ^ random()) & mask) << 20) | id).collect();
            let mut expected = keys.clone();
            expected.sort_unstable();
            sort(&mut keys, 20, 64, &Threads::default());
            assert!(keys == expected, "seed {seed}");
        }
    }
}
