//! Registers whose lanes are pairs of a ray and a patch: of eight, and of sixteen where the processor has such.

use fearless_simd::{f32x8, f32x16, mask32x8, mask32x16, prelude::*, u8x32, u8x64, u32x8, u32x16};

use super::lanes::{MAX_LANES, ManyMask, ManyPatches, PATCHES, PatchMask, Patches};
use super::scalar::Constant;

/// A register's pairs.
pub(crate) trait PairLanes<S: Simd>: Constant {
    /// How many there are.
    const LEN: usize;
    /// Where each lane's number is in a column.
    type Places: Copy;

    /// From the places of each number's four bytes.
    fn places(simd: S, bytes: &[u32]) -> Self::Places;
    /// Each lane's number of a column of patches.
    fn of_patches(simd: S, column: &[f32; PATCHES], places: Self::Places) -> Self;
    /// Each lane's number of a column of rays.
    fn of_rays(simd: S, column: &[f32; MAX_LANES], lanes: &[u8], places: Self::Places) -> Self;
    /// The first numbers of a slice.
    fn load(simd: S, from: &[f32]) -> Self;
    /// Writes the numbers to where a slice begins.
    fn store(self, to: &mut [f32]);
    /// From one bit a lane.
    fn lanes(simd: S, bits: u64) -> Self::Mask;
    /// One bit a lane.
    fn bits(mask: Self::Mask) -> u64;
}

macro_rules! pair_lanes {
    (
        $lanes:ident: $length:literal, $register:ident, $mask:ident, $mask_register:ident, $words:ident, $places:ty,
        |$column:ident, $at:ident| $of_patches:expr,
        |$rays:ident, $numbers:ident, $simd:ident, $of:ident| $of_rays:expr
    ) => {
        impl<S: Simd> PairLanes<S> for $lanes<S> {
            const LEN: usize = $length;
            type Places = $places;

            #[inline(always)]
            fn places(simd: S, bytes: &[u32]) -> Self::Places {
                $words::from_slice(simd, &bytes[..$length]).to_bytes()
            }
            #[inline(always)]
            fn of_patches(simd: S, column: &[f32; PATCHES], $at: Self::Places) -> Self {
                let $column = f32x8::from_slice(simd, column);
                Self($of_patches)
            }
            #[inline(always)]
            fn of_rays(
                $simd: S,
                $rays: &[f32; MAX_LANES],
                $numbers: &[u8],
                $of: Self::Places,
            ) -> Self {
                Self($of_rays)
            }
            #[inline(always)]
            fn load(simd: S, from: &[f32]) -> Self {
                Self($register::from_slice(simd, &from[..$length]))
            }
            #[inline(always)]
            fn store(self, to: &mut [f32]) {
                self.0.store_slice(&mut to[..$length]);
            }
            #[inline(always)]
            fn lanes(simd: S, bits: u64) -> Self::Mask {
                $mask($mask_register::from_bitmask(simd, bits))
            }
            #[inline(always)]
            fn bits(mask: Self::Mask) -> u64 {
                mask.0.to_bitmask()
            }
        }
    };
}

pair_lanes! {
    Patches: 8, f32x8, PatchMask, mask32x8, u32x8, u8x32<S>,
    |column, places| column.swizzle_dyn(places),
    // A register of eight does not hold a column of sixteen rays.
    |column, lanes, simd, _places| {
        let mut numbers = [0.0; 8];
        for (to, &lane) in numbers.iter_mut().zip(lanes) {
            *to = column[usize::from(lane) % MAX_LANES];
        }
        f32x8::from_slice(simd, &numbers)
    }
}
pair_lanes! {
    ManyPatches: 16, f32x16, ManyMask, mask32x16, u32x16, u8x64<S>,
    |column, places| column.combine(column).swizzle_dyn(places),
    |column, _lanes, simd, places| f32x16::from_slice(simd, column).swizzle_dyn(places)
}
