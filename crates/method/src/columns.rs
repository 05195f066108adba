//! The numbers of several patches side by side: a column of each number, one patch a place in it.

use fearless_simd::{f32x8, prelude::*};

use super::kept::Corners;
use super::lanes::{PATCHES, PatchMask, Patches};
use super::pair_lanes::PairLanes;
use super::patch::Patch;
use super::real::{Constant, Real, inlined, three};
use super::vector::{Vector, vector};

/// How many numbers a hull is kept in.
pub(super) const HULL: usize = 29;
/// How many numbers a patch is kept in.
pub(super) const PATCH: usize = 100;

/// How many numbers a triangle's vertices are.
pub(super) const VERTICES: usize = 18;

impl Corners {
    /// All numbers, the positions first.
    #[inline(always)]
    pub(super) fn numbers(&self) -> [f32; VERTICES] {
        let mut numbers = [0.0; VERTICES];
        self.write(&mut numbers);
        numbers
    }

    /// Writes all numbers, the positions first.
    #[inline(always)]
    pub(super) fn write(&self, to: &mut [f32]) {
        let vertices = self.positions.iter().chain(&self.normals);
        for (to, from) in to.chunks_exact_mut(3).zip(vertices) {
            to.copy_from_slice(&from.to_array());
        }
    }
}

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
pub(super) fn vertices<S: Simd>(
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

/// Sees every number that rays ask for of a patch, each at its place.
pub(super) trait Visitor<S: Constant> {
    fn number(&mut self, at: usize, number: &mut S);
    fn truth(&mut self, at: usize, truth: &mut S::Mask);

    #[inline(always)]
    fn vector(&mut self, at: usize, vector: &mut Vector<S>) {
        self.number(at, &mut vector.x);
        self.number(at + 1, &mut vector.y);
        self.number(at + 2, &mut vector.z);
    }
}

impl<S: Constant> Patch<S> {
    /// Shows all numbers that rays ask for of a curved patch, by the tensor's rule and without loose ends.
    #[inline(always)]
    pub(super) fn visit(&mut self, by: &mut impl Visitor<S>) {
        by.vector(0, &mut self.origin);
        by.number(3, &mut self.size);
        by.vector(4, &mut self.spokes[0]);
        by.vector(7, &mut self.spokes[1]);
        by.vector(10, &mut self.normal);
        self.visit_part(0, 13, by);
        self.visit_part(1, 37, by);
        self.visit_part(2, 61, by);
        let base = &mut self.base;
        base.side.visit(85, by);
        by.vector(87, &mut base.corner);
        by.vector(90, &mut base.along);
        by.vector(93, &mut base.across);
        by.number(96, &mut base.foot);
        by.number(97, &mut self.slab[0]);
        by.number(98, &mut self.slab[1]);
        by.number(99, &mut self.unevenness);
    }

    /// Those of a vertex, its gradient and the side from there: 24.
    #[inline(always)]
    fn visit_part(&mut self, k: usize, at: usize, by: &mut impl Visitor<S>) {
        by.vector(at, &mut self.gradients[k]);
        self.sides[k].visit(at + 3, by);
        let vertex = &mut self.vertices[k];
        by.number(at + 19, &mut vertex.normal);
        by.number(at + 20, &mut vertex.inward[0]);
        by.number(at + 21, &mut vertex.inward[1]);
        by.number(at + 22, &mut vertex.inward[2]);
        by.number(at + 23, &mut vertex.between);
    }
}

/// Puts the numbers of some lanes into columns.
pub(super) struct Store<'a, S: Simd, const N: usize> {
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
pub(super) struct Column<'a, const N: usize> {
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
pub(super) struct Pick<'a, S: Simd, P: PairLanes<S>, const N: usize> {
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
