//! Registers whose lanes are pairs of a ray and a patch: of eight, and of sixteen where the processor has such.

use fearless_simd::{f32x8, f32x16, mask32x8, mask32x16, prelude::*, u8x32, u8x64, u32x8, u32x16};

use super::lanes::{ManyMask, ManyPatches, PATCHES, PatchMask, Patches};
use super::packet::MAX_LANES;
use super::real::Constant;

/// A register's pairs.
pub(super) trait PairLanes<S: Simd>: Constant {
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

impl<S: Simd> PairLanes<S> for Patches<S> {
    const LEN: usize = 8;
    type Places = u8x32<S>;

    #[inline(always)]
    fn places(simd: S, bytes: &[u32]) -> Self::Places {
        u32x8::from_slice(simd, &bytes[..8]).to_bytes()
    }
    #[inline(always)]
    fn of_patches(simd: S, column: &[f32; PATCHES], places: Self::Places) -> Self {
        Self(f32x8::from_slice(simd, column).swizzle_dyn(places))
    }
    #[inline(always)]
    fn of_rays(simd: S, column: &[f32; MAX_LANES], lanes: &[u8], _: Self::Places) -> Self {
        let mut numbers = [0.0; 8];
        for (to, &lane) in numbers.iter_mut().zip(lanes) {
            *to = column[usize::from(lane) % MAX_LANES];
        }
        Self::load(simd, &numbers)
    }
    #[inline(always)]
    fn load(simd: S, from: &[f32]) -> Self {
        Self(f32x8::from_slice(simd, &from[..8]))
    }
    #[inline(always)]
    fn store(self, to: &mut [f32]) {
        self.0.store_slice(&mut to[..8]);
    }
    #[inline(always)]
    fn lanes(simd: S, bits: u64) -> Self::Mask {
        PatchMask(mask32x8::from_bitmask(simd, bits))
    }
    #[inline(always)]
    fn bits(mask: Self::Mask) -> u64 {
        mask.0.to_bitmask()
    }
}

impl<S: Simd> PairLanes<S> for ManyPatches<S> {
    const LEN: usize = 16;
    type Places = u8x64<S>;

    #[inline(always)]
    fn places(simd: S, bytes: &[u32]) -> Self::Places {
        u32x16::from_slice(simd, &bytes[..16]).to_bytes()
    }
    #[inline(always)]
    fn of_patches(simd: S, column: &[f32; PATCHES], places: Self::Places) -> Self {
        let column = f32x8::from_slice(simd, column);
        Self(column.combine(column).swizzle_dyn(places))
    }
    #[inline(always)]
    fn of_rays(simd: S, column: &[f32; MAX_LANES], _: &[u8], places: Self::Places) -> Self {
        Self(f32x16::from_slice(simd, column).swizzle_dyn(places))
    }
    #[inline(always)]
    fn load(simd: S, from: &[f32]) -> Self {
        Self(f32x16::from_slice(simd, &from[..16]))
    }
    #[inline(always)]
    fn store(self, to: &mut [f32]) {
        self.0.store_slice(&mut to[..16]);
    }
    #[inline(always)]
    fn lanes(simd: S, bits: u64) -> Self::Mask {
        ManyMask(mask32x16::from_bitmask(simd, bits))
    }
    #[inline(always)]
    fn bits(mask: Self::Mask) -> u64 {
        mask.0.to_bitmask()
    }
}
