//! Sorting keys by their digits, without comparing them.
//!
//! One pass deals the keys out by their first digit. From then on groups of neighbouring digits are sorted for themselves, at the same time and
//! within a cache, by the last digit first.

use crate::memory::vec_in_large_pages;
use crate::threads::Threads;

const DIGIT_BITS: u32 = 11;
const DIGITS: usize = 1 << DIGIT_BITS;

/// Keys of this number are worth a group of their own; half a megabyte with its spare copy.
const GROUP: usize = 32 * 1024;

/// Below this, comparing is faster than clearing counters.
const FEW: usize = 1024;

/// Sorts keys that are in order already as far as their bits below `low` go, and that have no bits from `high` on.
pub(crate) fn sort(keys: &mut Vec<u64>, low: u32, high: u32, threads: &Threads) {
    if keys.len() <= FEW {
        keys.sort_unstable();
        return;
    }
    let shift = high.saturating_sub(DIGIT_BITS).max(low);
    let mut ends = threads.reduce(keys, GROUP, &|piece| count(piece, shift), &|mut a, b| {
        a.iter_mut().zip(b.iter()).for_each(|(a, b)| *a += b);
        a
    });
    let mut dealt = vec_in_large_pages(keys.len());
    dealt.resize(keys.len(), 0);
    deal(keys, &mut dealt, &mut starts(&ends), shift);
    let mut end = 0;
    ends.iter_mut().for_each(|count| {
        end += *count;
        *count = end;
    });
    let mut groups = Vec::new();
    let (mut rest, mut spare_rest, mut first) = (&mut dealt[..], &mut keys[..], 0);
    for &end in ends.iter() {
        let size = end as usize - first;
        if size >= GROUP || size > 0 && end as usize == first + rest.len() {
            let (group, others) = rest.split_at_mut(size);
            let (spare, spare_others) = spare_rest.split_at_mut(size);
            groups.push((group, spare));
            (rest, spare_rest, first) = (others, spare_others, end as usize);
        }
    }
    threads.for_each(&mut groups, 1, &|_, (group, spare)| sort_group(group, spare, low, high));
    *keys = dealt;
}

/// Sorts by the last digit, then by the one before, and so on.
fn sort_group<'a>(mut keys: &'a mut [u64], mut spare: &'a mut [u64], low: u32, high: u32) {
    if keys.len() <= FEW {
        keys.sort_unstable();
        return;
    }
    let mut in_place = true;
    for shift in (low..high).step_by(DIGIT_BITS as usize) {
        let counts = count(keys, shift);
        if counts.iter().any(|&count| count as usize == keys.len()) {
            continue;
        }
        deal(keys, spare, &mut starts(&counts), shift);
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

/// How many keys have each digit.
fn count(keys: &[u64], shift: u32) -> Box<[u32; DIGITS]> {
    let mut counts = Box::new([0; DIGITS]);
    keys.iter().for_each(|&key| counts[digit(key, shift)] += 1);
    counts
}

/// How many keys have a smaller digit, for each digit.
fn starts(counts: &[u32; DIGITS]) -> [u32; DIGITS] {
    let mut next = 0;
    counts.map(|count| {
        next += count;
        next - count
    })
}

/// Puts each key where its digit starts, in their order.
fn deal(keys: &[u64], to: &mut [u64], starts: &mut [u32; DIGITS], shift: u32) {
    for &key in keys {
        let start = &mut starts[digit(key, shift)];
        to[*start as usize] = key;
        *start += 1;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn digits_sort_as_comparing_does() {
        for seed in 0..20_u64 {
            let mut state = seed;
            let mut random = || {
                state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
                state >> 33
            };
            let size = [0, 1, 2, 1000, 1025, 40_000, 150_000][seed as usize % 7];
            // Few different codes now and then, and codes that crowd together.
            let mask = [(1 << 44) - 1, 3, 0, 0x0FFF_0000_0FFF, 1 << 43][seed as usize % 5];
            let mut keys: Vec<u64> = (0..size).map(|id| (((random() << 31 ^ random()) & mask) << 20) | id).collect();
            let mut expected = keys.clone();
            expected.sort_unstable();
            sort(&mut keys, 20, 64, &Threads::default());
            assert!(keys == expected, "seed {seed}");
        }
    }
}
