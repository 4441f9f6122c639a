//! Which of the children that a ray enters is visited first, and which go onto the stack.

use crate::memory::Stack;
use crate::simd::Isa;
use crate::wide::{LANES, WIDE_STACK, WideLink};

/// An entry of the stack: the bits of the entry distance in the upper half, a link in the lower
/// half. The smaller of two is nearer.
pub(in crate::traverse) type Entry = u64;

/// The nearest of the lanes whose entry comes before their exit ([`Isa::lt_bits`]); the others go
/// onto the stack, the next one on top.
///
/// Nearly all steps enter at most four children. They are sorted by branch-free networks, one for
/// each count, which is faster than sorting in vectors. (Compare Fuetterling et al. 2017,
/// "Accelerated Single Ray Tracing for Wide Vector Units".)
#[inline(always)]
pub(super) fn choose<I: Isa>(
    isa: I,
    entry: I::F8,
    exit: I::F8,
    links: &[u32; LANES],
    stack: &mut Stack<'_, Entry, WIDE_STACK>,
) -> Option<WideLink> {
    let all = isa.lt_bits(entry, exit);
    let rest = all & all.wrapping_sub(1);
    if rest == 0 {
        return if all == 0 { None } else { Some(predicted(isa, links, all)) };
    }
    let entries = isa.zip_u64(entry, links);
    let (a, b) = (entry_of(&entries, all), entry_of(&entries, rest));
    let (low, high) = (a.min(b), a.max(b));
    if rest & (rest - 1) == 0 {
        stack.push(high);
        return Some(predicted(isa, links, if a < b { all } else { rest }));
    }
    let rest = rest & (rest - 1);
    let c = entry_of(&entries, rest);
    let rest = rest & (rest - 1);
    if rest == 0 {
        stack.push(high.max(c));
        stack.push(high.min(c).max(low));
        return Some(link_of(low.min(c)));
    }
    let d = entry_of(&entries, rest);
    let rest = rest & (rest - 1);
    let (near, far) = (c.min(d), c.max(d));
    let (one, other) = (low.max(near), high.min(far));
    let four = [low.min(near), one.min(other), one.max(other), high.max(far)];
    if rest == 0 {
        stack.push(four[3]);
        stack.push(four[2]);
        stack.push(four[1]);
        return Some(link_of(four[0]));
    }
    Some(link_of(insert(four, rest, &entries, stack)))
}

/// As [`choose`], where any hit will do: the lanes are visited in their order.
#[inline(always)]
pub(super) fn choose_in_order<I: Isa>(
    isa: I,
    entry: I::F8,
    exit: I::F8,
    links: &[u32; LANES],
    stack: &mut Stack<'_, Entry, WIDE_STACK>,
) -> Option<WideLink> {
    let all = isa.lt_bits(entry, exit);
    if all == 0 {
        return None;
    }
    let mut rest = all & all.wrapping_sub(1);
    while rest != 0 {
        let last = 31 - rest.leading_zeros();
        rest ^= 1 << last;
        // At distance zero, so that none is skipped as too far.
        stack.push(u64::from(links[last as usize & 7]));
    }
    Some(predicted(isa, links, all))
}

/// Where the first lane in the mask leads.
#[inline(always)]
fn predicted<I: Isa>(isa: I, links: &[u32; LANES], mask: u32) -> WideLink {
    WideLink::from_bits(isa.predicted(links, mask.trailing_zeros() as usize))
}

/// Five or more.
#[inline(always)]
fn insert(
    four: [Entry; 4],
    mut rest: u32,
    entries: &[Entry; LANES],
    stack: &mut Stack<'_, Entry, WIDE_STACK>,
) -> Entry {
    let mut sorted = [four[0], four[1], four[2], four[3], 0, 0, 0, 0];
    let mut count = 4;
    while rest != 0 {
        let new = entry_of(entries, rest);
        rest &= rest - 1;
        let mut at = count;
        while at > 0 && sorted[(at - 1) & 7] > new {
            sorted[at & 7] = sorted[(at - 1) & 7];
            at -= 1;
        }
        sorted[at & 7] = new;
        count += 1;
    }
    while count > 1 {
        count -= 1;
        stack.push(sorted[count & 7]);
    }
    sorted[0]
}

/// Pops the nearest entry that is not too far by now.
#[inline(always)]
pub(super) fn next(stack: &mut Stack<'_, Entry, WIDE_STACK>, t_max: f32) -> Option<WideLink> {
    while let Some(entry) = stack.pop() {
        if (entry >> 32) as u32 <= t_max.to_bits() {
            return Some(link_of(entry));
        }
    }
    None
}

#[inline(always)]
fn link_of(entry: Entry) -> WideLink {
    WideLink::from_bits(entry as u32)
}

/// Of the first lane in the mask.
#[inline(always)]
fn entry_of(entries: &[Entry; LANES], mask: u32) -> Entry {
    entries[mask.trailing_zeros() as usize & 7]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::memory::StackBuffer;
    use crate::simd::{Kernel, Level};

    struct Chosen {
        in_order: bool,
        entry: [f32; LANES],
        mask: u32,
    }

    impl Kernel for Chosen {
        type Output = Vec<Entry>;

        #[inline(always)]
        fn run<I: Isa>(self, isa: I) -> Vec<Entry> {
            let links = [10, 11, 12, 13, 14, 15, 16, 17];
            let mut exit = [-1.0; LANES];
            for lane in 0..LANES {
                exit[lane] = if self.mask >> lane & 1 == 1 { f32::INFINITY } else { -1.0 };
            }
            let mut room = StackBuffer::new();
            let mut stack = room.stack();
            let (entry, exit) = (isa.load(&self.entry), isa.load(&exit));
            let mut all = Vec::new();
            if self.in_order {
                let first = choose_in_order(isa, entry, exit, &links, &mut stack);
                all.extend(first.map(|link| u64::from(link.bits())));
            } else if let Some(link) = choose(isa, entry, exit, &links, &mut stack) {
                let distance = self.entry[(link.bits() - 10) as usize & 7].to_bits();
                all.push(u64::from(distance) << 32 | u64::from(link.bits()));
            }
            while let Some(entry) = stack.pop() {
                all.push(entry);
            }
            all
        }
    }

    #[test]
    fn those_that_are_entered_come_out_from_near_to_far_on_every_level() {
        for entry in [[5.0_f32, 1.0, 9.0, 2.0, 0.0, 2.5, 8.0, 3.0], [1.0, 1.0, 0.0, 1.0, 0.0, 7.0, 1.0, 0.5]] {
            for mask in 0..256 {
                let lanes = (0..LANES).filter(|lane| mask >> lane & 1 == 1);
                let mut expected: Vec<Entry> =
                    lanes.map(|lane| u64::from(entry[lane].to_bits()) << 32 | (lane as u64 + 10)).collect();
                expected.sort_unstable();
                for level in Level::available() {
                    let chosen = level.run(Chosen { in_order: false, entry, mask });
                    assert_eq!(chosen, expected, "{level:?}, {mask:08b}");
                }
            }
        }
    }

    #[test]
    fn where_any_will_do_they_come_out_in_the_order_of_the_lanes() {
        let entry = [5.0_f32, 1.0, 9.0, 2.0, 0.0, 2.5, 8.0, 3.0];
        for mask in 0..256 {
            let expected: Vec<Entry> = (0..8).filter(|lane| mask >> lane & 1 == 1).map(|lane| lane + 10).collect();
            for level in Level::available() {
                let chosen = level.run(Chosen { in_order: true, entry, mask: mask as u32 });
                assert_eq!(chosen, expected, "{level:?}, {mask:08b}");
            }
        }
    }
}
