//! A 64-bit checksum.
//!
//! Each step mixes in eight bytes and is a bijection of the state, so a change of a single word
//! always changes the result; of other changes, about one in 2^64 goes unnoticed. It detects
//! damaged and mixed-up files. It is not cryptographic: collisions are easy to make.
//!
//! Fowler, Noll and Vo 1991, "FNV hash", with words instead of bytes, and a shift that carries high
//! bits to low ones.

/// The state of a checksum.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Digest(u64);

impl Digest {
    pub(crate) fn new() -> Self {
        Self(0xCBF2_9CE4_8422_2325)
    }

    #[inline]
    pub(crate) fn word(&mut self, word: u64) {
        let mixed = (self.0 ^ word).wrapping_mul(0x9E37_79B9_7F4A_7C15);
        self.0 = mixed ^ mixed >> 32;
    }

    /// Adds three 32-bit numbers.
    #[inline]
    pub(crate) fn triple(&mut self, [a, b, c]: [u32; 3]) {
        self.word(u64::from(a) | u64::from(b) << 32);
        self.word(c.into());
    }

    /// Adds bytes and their number.
    pub(crate) fn bytes(&mut self, bytes: &[u8]) {
        let (words, rest) = bytes.as_chunks::<8>();
        words.iter().for_each(|word| self.word(u64::from_le_bytes(*word)));
        let mut last = [0; 8];
        last[..rest.len()].copy_from_slice(rest);
        self.word(u64::from_le_bytes(last));
        self.word(bytes.len() as u64);
    }

    pub(crate) fn finish(mut self) -> u64 {
        self.word(0);
        self.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn digest(bytes: &[u8]) -> u64 {
        let mut digest = Digest::new();
        digest.bytes(bytes);
        digest.finish()
    }

    #[test]
    fn every_flipped_bit_and_every_length_shows() {
        let bytes: Vec<u8> = (0..77).map(|i| (i * 37 % 255 + 1) as u8).collect();
        let mut found = vec![digest(&bytes)];
        for bit in 0..bytes.len() * 8 {
            let mut flipped = bytes.clone();
            flipped[bit / 8] ^= 1 << (bit % 8);
            found.push(digest(&flipped));
        }
        found.extend((0..bytes.len()).map(|length| digest(&bytes[..length])));
        // Trailing zeros count.
        found.extend((0..20).map(|length| digest(&vec![0; length])).skip(1));
        let count = found.len();
        found.sort_unstable();
        found.dedup();
        assert_eq!(found.len(), count);
    }
}
