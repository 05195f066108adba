//! How numbers are packed.

use crate::numbers::{Constant, Scalar, inlined};
use crate::patch::Patch;

/// Binary digits of the greatest coefficient.
const DIGITS: i32 = 15;

/// Exponents of the unit: what is below the least is nothing, and nothing is above the greatest.
const EXPONENTS: [i32; 2] = [-100, 100];

impl<S: Constant> Patch<S> {
    /// Rounds the correction to what a record holds of it, before anything is computed from it.
    #[inline(always)]
    pub(crate) fn round_correction(&mut self) {
        let unit = self.correction_unit();
        // What is added to this keeps no digits below the unit.
        let coarse = unit * unit.constant(1.5 / S::PRECISION);
        // The greatest may round up beyond the digits.
        let most = unit * unit.constant(i16::MAX.into());
        each!(|k| {
            let [a, b, c] = self.edges[k].correction;
            let rounded = inlined(
                #[inline(always)]
                |value: S| ((value + coarse) - coarse).greater(-most).lesser(most),
            );
            self.edges[k].correction = [rounded(a), rounded(b), rounded(c)];
        });
    }

    /// The unit, a power of two, in which the greatest coefficient takes all the digits. Rounding to it
    /// does not change it.
    #[inline(always)]
    pub(crate) fn correction_unit(&self) -> S {
        let lanes = self.area2;
        let mut greatest = lanes.zero();
        each!(|k| {
            let [a, b, c] = self.edges[k].correction;
            greatest = a.abs().greater(greatest);
            greatest = b.abs().greater(greatest);
            greatest = c.abs().greater(greatest);
        });
        let [least, most] = EXPONENTS.map(|exponent| lanes.constant(2f64.powi(exponent)));
        let unit = greatest.power_of_two() * lanes.constant(2f64.powi(1 - DIGITS));
        unit.greater(least).lesser(most)
    }
}

/// Exact, for the exponents of normal numbers.
#[inline(always)]
pub(crate) fn power_of_two(exponent: i32) -> f32 {
    f32::from_bits(((exponent + 127) as u32) << 23)
}

/// Unevenness is packed as a number with three binary digits behind the leading one, from this power of two on.
const LEAST_EXPONENT: i32 = -14;

/// The code of unevenness that is not known, or beyond the greatest.
pub(crate) const UNKNOWN: u8 = u8::MAX;

/// The low bits of an `f32` that are dropped.
const DROPPED: u32 = 20;

/// The code of the least number, before it is counted from zero.
const LEAST: u32 = ((127 + LEAST_EXPONENT) as u32) << 3;

/// The code of unevenness; rounded up.
pub(crate) fn pack_unevenness<S: Scalar>(unevenness: S) -> u8 {
    let single = unevenness.to_f64() as f32;
    // No number fails the comparison.
    if !(0.0..f32::MAX).contains(&single) {
        return UNKNOWN;
    }
    let steps = single
        .to_bits()
        .div_ceil(1 << DROPPED)
        .saturating_sub(LEAST);
    steps.min(UNKNOWN.into()) as u8
}

/// Unevenness from its code.
#[inline(always)]
pub(crate) fn unpack_unevenness(code: u8) -> f32 {
    if code == UNKNOWN {
        return f32::INFINITY;
    }
    f32::from_bits((u32::from(code) + LEAST) << DROPPED)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_kept_is_not_less_and_stays_what_it_is() {
        for n in 0..2000 {
            let number = 1e-6 * 1.01f64.powi(n);
            let there = f64::from(unpack_unevenness(pack_unevenness(number)));
            assert!(there >= number, "{there} for {number}");
            assert!(
                there.max(1e-4) <= 1.13 * number.max(1e-4) || number > 1e5,
                "{there} for {number}"
            );
            assert_eq!(pack_unevenness(there), pack_unevenness(number));
        }
        for unknown in [f64::NAN, f64::INFINITY, -1.0, 1e30] {
            assert_eq!(unpack_unevenness(pack_unevenness(unknown)), f32::INFINITY);
        }
    }
}
