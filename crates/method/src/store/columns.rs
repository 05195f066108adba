//! The numbers of several patches side by side: a column of each number, one patch a place in it.

use fearless_simd::{f32x8, prelude::*};

use crate::numbers::{Cursor, Fields, PATCHES, PairLanes, PatchMask, Patches, Real};

/// Columns of some numbers.
pub(crate) type Columns<const N: usize> = [[f32; PATCHES]; N];

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

/// Writes structs in lanes to the places of some lanes.
#[inline(always)]
pub(crate) fn store_lanes<S: Simd, F: Fields<Patches<S>>, const N: usize>(
    mut of: F,
    columns: &mut Columns<N>,
    lanes: PatchMask<S>,
) {
    const { assert!(N == F::COUNT) };
    of.visit(&mut StoreLanes {
        columns,
        next: 0,
        lanes,
    });
}

/// Structs in lanes, a place a lane; `blank` is any of their kind.
#[inline(always)]
pub(crate) fn load_lanes<S: Simd, F: Fields<Patches<S>>, const N: usize>(
    simd: S,
    columns: &Columns<N>,
    mut blank: F,
) -> F {
    const { assert!(N == F::COUNT) };
    blank.visit(&mut LoadLanes {
        simd,
        columns,
        next: 0,
    });
    blank
}

/// The struct in one place; `blank` is any of its kind.
#[inline(always)]
pub(crate) fn load_one<F: Fields<f32>, const N: usize>(
    columns: &Columns<N>,
    place: usize,
    mut blank: F,
) -> F {
    const { assert!(N == F::COUNT) };
    blank.visit(&mut LoadOne {
        columns,
        next: 0,
        place,
    });
    blank
}

/// Structs in lanes, each lane's of a place of its own; `blank` is any of their kind.
#[inline(always)]
pub(crate) fn pick_lanes<S: Simd, P: PairLanes<S>, F: Fields<P>, const N: usize>(
    simd: S,
    columns: &Columns<N>,
    places: P::Places,
    mut blank: F,
) -> F {
    const { assert!(N == F::COUNT) };
    blank.visit(&mut PickLanes::<S, P, N> {
        simd,
        columns,
        next: 0,
        places,
    });
    blank
}

struct StoreLanes<'a, S: Simd, const N: usize> {
    columns: &'a mut Columns<N>,
    next: usize,
    lanes: PatchMask<S>,
}

impl<S: Simd, const N: usize> Cursor<Patches<S>> for StoreLanes<'_, S, N> {
    #[inline(always)]
    fn number(&mut self, number: &mut Patches<S>) {
        let column = &mut self.columns[self.next];
        self.next += 1;
        let old = Patches(f32x8::from_slice(number.0.token(), &column[..]));
        Patches::select(self.lanes, *number, old)
            .0
            .store_slice(column);
    }

    #[inline(always)]
    fn truth(&mut self, truth: &mut PatchMask<S>) {
        let simd = truth.0.token();
        let (zero, one) = (f32x8::splat(simd, 0.0), f32x8::splat(simd, 1.0));
        self.number(&mut Patches::select(*truth, Patches(one), Patches(zero)));
    }
}

struct LoadLanes<'a, S: Simd, const N: usize> {
    simd: S,
    columns: &'a Columns<N>,
    next: usize,
}

impl<S: Simd, const N: usize> Cursor<Patches<S>> for LoadLanes<'_, S, N> {
    #[inline(always)]
    fn number(&mut self, number: &mut Patches<S>) {
        *number = Patches(f32x8::from_slice(self.simd, &self.columns[self.next]));
        self.next += 1;
    }

    #[inline(always)]
    fn truth(&mut self, truth: &mut PatchMask<S>) {
        let mut number = Patches(f32x8::splat(self.simd, 0.0));
        let zero = number;
        self.number(&mut number);
        *truth = zero.less(number);
    }
}

struct LoadOne<'a, const N: usize> {
    columns: &'a Columns<N>,
    next: usize,
    place: usize,
}

impl<const N: usize> Cursor<f32> for LoadOne<'_, N> {
    #[inline(always)]
    fn number(&mut self, number: &mut f32) {
        *number = self.columns[self.next][self.place];
        self.next += 1;
    }

    #[inline(always)]
    fn truth(&mut self, truth: &mut bool) {
        let mut number = 0.0;
        self.number(&mut number);
        *truth = number > 0.0;
    }
}

struct PickLanes<'a, S: Simd, P: PairLanes<S>, const N: usize> {
    simd: S,
    columns: &'a Columns<N>,
    next: usize,
    places: P::Places,
}

impl<S: Simd, P: PairLanes<S>, const N: usize> Cursor<P> for PickLanes<'_, S, P, N> {
    #[inline(always)]
    fn number(&mut self, number: &mut P) {
        *number = P::of_patches(self.simd, &self.columns[self.next], self.places);
        self.next += 1;
    }

    #[inline(always)]
    fn truth(&mut self, truth: &mut P::Mask) {
        let number = P::of_patches(self.simd, &self.columns[self.next], self.places);
        self.next += 1;
        *truth = number.zero().less(number);
    }
}
