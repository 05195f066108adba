//! The numbers of several patches side by side: a column of each number, one patch a place in it.

use fearless_simd::{f32x8, prelude::*};

use crate::numbers::{
    PATCHES, PairLanes, PatchMask, Patches, Real, Vector, Visitor, inlined, three, vector,
};

/// How many numbers a hull is kept in.
pub(crate) const CLIP_VOLUME: usize = 29;
/// How many numbers a patch is kept in.
pub(crate) const PATCH: usize = 100;

/// The numbers of eight triangles side by side: a column of each number.
#[inline(always)]
pub fn in_columns<const N: usize>(of: impl Fn(usize) -> [f32; N]) -> [[f32; PATCHES]; N] {
    let mut columns = [[0.0; PATCHES]; N];
    for n in 0..PATCHES {
        for (column, number) in columns.iter_mut().zip(of(n)) {
            column[n] = number;
        }
    }
    columns
}

/// The positions and the normals of eight triangles, whose [`VERTICES`] numbers are in columns.
#[inline(always)]
pub(crate) fn vertices<S: Simd>(
    simd: S,
    columns: &[[f32; PATCHES]],
) -> [[Vector<Patches<S>>; 3]; 2] {
    let number = inlined(
        #[inline(always)]
        |n: usize| Patches(f32x8::from_slice(simd, &columns[n])),
    );
    let three_from = inlined(
        #[inline(always)]
        |first: usize| {
            three(
                #[inline(always)]
                |k| {
                    let n = first + 3 * k;
                    vector(number(n), number(n + 1), number(n + 2))
                },
            )
        },
    );
    [three_from(0), three_from(9)]
}

/// Puts the numbers of some lanes into columns.
pub(crate) struct Store<'a, S: Simd, const N: usize> {
    pub columns: &'a mut [[f32; PATCHES]; N],
    pub lanes: PatchMask<S>,
}

impl<S: Simd, const N: usize> Visitor<Patches<S>> for Store<'_, S, N> {
    #[inline(always)]
    fn number(&mut self, at: usize, number: &mut Patches<S>) {
        let column = &mut self.columns[at];
        let old = Patches(f32x8::from_slice(number.0.token(), &column[..]));
        Patches::select(self.lanes, *number, old)
            .0
            .store_slice(column);
    }

    #[inline(always)]
    fn truth(&mut self, at: usize, truth: &mut PatchMask<S>) {
        let simd = truth.0.token();
        let (zero, one) = (f32x8::splat(simd, 0.0), f32x8::splat(simd, 1.0));
        let (zero, one) = (Patches(zero), Patches(one));
        self.number(at, &mut Patches::select(*truth, one, zero));
    }
}

/// Takes one patch's numbers from columns.
pub(crate) struct Column<'a, const N: usize> {
    pub columns: &'a [[f32; PATCHES]; N],
    pub n: usize,
}

impl<const N: usize> Visitor<f32> for Column<'_, N> {
    #[inline(always)]
    fn number(&mut self, at: usize, number: &mut f32) {
        *number = self.columns[at][self.n];
    }

    #[inline(always)]
    fn truth(&mut self, at: usize, truth: &mut bool) {
        let mut number = 0.0;
        self.number(at, &mut number);
        *truth = number > 0.0;
    }
}

/// Takes a patch's numbers a lane from columns.
pub(crate) struct Pick<'a, S: Simd, P: PairLanes<S>, const N: usize> {
    pub columns: &'a [[f32; PATCHES]; N],
    pub simd: S,
    pub places: P::Places,
}

impl<S: Simd, P: PairLanes<S>, const N: usize> Visitor<P> for Pick<'_, S, P, N> {
    #[inline(always)]
    fn number(&mut self, at: usize, number: &mut P) {
        *number = P::of_patches(self.simd, &self.columns[at], self.places);
    }

    #[inline(always)]
    fn truth(&mut self, at: usize, truth: &mut P::Mask) {
        let number = P::of_patches(self.simd, &self.columns[at], self.places);
        *truth = number.constant(0.0).less(number);
    }
}
