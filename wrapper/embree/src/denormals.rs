//! Denormal numbers as zero, on threads that trace.

use std::marker::PhantomData;

/// Treats denormal numbers as zero on this thread until the guard is dropped: flush-to-zero and
/// denormals-are-zero, which Embree recommends for every thread that traces (computing with denormals
/// is a hundred times slower). Does nothing where the processor has no such setting that is known here.
///
/// ```
/// use curvetri_embree::flush_denormals;
///
/// let flushed = flush_denormals();
/// // trace on this thread
/// drop(flushed);
/// ```
#[must_use = "the setting ends with the guard"]
pub fn flush_denormals() -> FlushedDenormals {
    FlushedDenormals {
        before: control::read_and_set(),
        thread: PhantomData,
    }
}

/// Ends [`flush_denormals`] when dropped.
///
/// ```
/// use curvetri_embree::{FlushedDenormals, flush_denormals};
///
/// struct Worker {
///     _flushed: FlushedDenormals,
/// }
///
/// let worker = Worker { _flushed: flush_denormals() };
/// # drop(worker);
/// ```
pub struct FlushedDenormals {
    before: u32,
    // the setting is the thread's own
    thread: PhantomData<*const ()>,
}

impl Drop for FlushedDenormals {
    fn drop(&mut self) {
        control::restore(self.before);
    }
}

#[cfg(target_arch = "x86_64")]
mod control {
    use std::arch::asm;

    /// Flush-to-zero (bit 15) and denormals-are-zero (bit 6) of MXCSR.
    const FLUSH: u32 = 1 << 15 | 1 << 6;

    fn read() -> u32 {
        let mut value = 0_u32;
        // SAFETY: stores the register into four bytes that are ours.
        unsafe { asm!("stmxcsr [{}]", in(reg) &mut value, options(nostack, preserves_flags)) };
        value
    }

    fn write(value: u32) {
        // SAFETY: loads a value that was read from the register, but for bits that every x86-64
        // processor has.
        unsafe { asm!("ldmxcsr [{}]", in(reg) &value, options(nostack, preserves_flags)) };
    }

    pub fn read_and_set() -> u32 {
        let before = read();
        write(before | FLUSH);
        before & FLUSH
    }

    pub fn restore(before: u32) {
        write(read() & !FLUSH | before);
    }
}

#[cfg(not(target_arch = "x86_64"))]
mod control {
    pub fn read_and_set() -> u32 {
        0
    }

    pub fn restore(_before: u32) {}
}

#[cfg(all(test, target_arch = "x86_64"))]
mod tests {
    use std::hint::black_box;

    use super::*;

    #[test]
    fn denormals_are_zero_while_the_guard_lives() {
        let half = |value: f32| black_box(black_box(value) * black_box(0.5));
        assert_ne!(half(f32::MIN_POSITIVE), 0.0);
        let outer = flush_denormals();
        {
            let _inner = flush_denormals();
            assert_eq!(half(f32::MIN_POSITIVE), 0.0);
        }
        assert_eq!(half(f32::MIN_POSITIVE), 0.0);
        drop(outer);
        assert_ne!(half(f32::MIN_POSITIVE), 0.0);
    }
}
