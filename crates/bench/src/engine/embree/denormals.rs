//! Treats denormal numbers as zero in a scope.

/// While this value lives, its thread reads denormal numbers as zero and flushes denormal results
/// to zero. On other processors than x86-64 it does nothing.
pub(super) struct NoDenormals {
    #[cfg(target_arch = "x86_64")]
    before: u32,
}

/// The bits FTZ (flush to zero) and DAZ (denormals are zero) of MXCSR.
#[cfg(target_arch = "x86_64")]
const BITS: u32 = 1 << 15 | 1 << 6;

impl NoDenormals {
    pub(super) fn begin() -> Self {
        #[cfg(target_arch = "x86_64")]
        {
            let before = control();
            set_control(before | BITS);
            Self { before }
        }
        #[cfg(not(target_arch = "x86_64"))]
        Self {}
    }
}

impl Drop for NoDenormals {
    fn drop(&mut self) {
        #[cfg(target_arch = "x86_64")]
        set_control(self.before);
    }
}

#[cfg(target_arch = "x86_64")]
fn control() -> u32 {
    let mut value = 0_u32;
    // SAFETY: every x86-64 processor has the register; four bytes are written to a live variable.
    unsafe { std::arch::asm!("stmxcsr [{}]", in(reg) &raw mut value, options(nostack, preserves_flags)) };
    value
}

#[cfg(target_arch = "x86_64")]
fn set_control(value: u32) {
    // SAFETY: the value is one that the register held, with or without the two bits, both of which
    // every x86-64 processor has. While they are set, this program only copies and compares floats;
    // Embree, which computes, asks for them.
    unsafe { std::arch::asm!("ldmxcsr [{}]", in(reg) &raw const value, options(nostack, preserves_flags)) };
}

#[cfg(all(test, target_arch = "x86_64"))]
mod tests {
    use super::*;

    #[test]
    fn it_ends_as_it_began() {
        let before = control();
        {
            let _no_denormals = NoDenormals::begin();
            assert_eq!(control() & BITS, BITS);
        }
        assert_eq!(control() & BITS, before & BITS);
    }
}
