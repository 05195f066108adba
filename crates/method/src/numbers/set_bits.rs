//! The bits of a mask.

/// The places of the bits that are set, the least first.
///
/// ```
/// assert!(curvetri_method::set_bits(0b1010_u32).eq([1, 3]));
/// ```
#[inline(always)]
pub fn set_bits(mask: impl Into<u64>) -> SetBits {
    SetBits(mask.into())
}

/// An iterator over the places of the bits that are set.
#[derive(Clone, Copy, Debug)]
pub struct SetBits(u64);

impl Iterator for SetBits {
    type Item = usize;

    #[inline(always)]
    fn next(&mut self) -> Option<usize> {
        if self.0 == 0 {
            return None;
        }
        let place = self.0.trailing_zeros() as usize;
        self.0 &= self.0 - 1;
        Some(place)
    }
}
