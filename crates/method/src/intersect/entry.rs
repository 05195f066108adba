//! Entry points for one ray or one place at a time.
//!
//! These functions are not generic in the end: [`Precision`] is implemented for `f32` and for `f64` in this
//! package, so that the kernel is compiled here once and not again in each package that calls it. For `f32`
//! they use the best instructions that the processor has; the results are the same with any.

use fearless_simd::{Level, dispatch, prelude::*};

use super::hit::{Hit, Solver};
use super::ray::Ray;
use crate::evaluate::SurfacePoint;
use crate::numbers::{Scalar, Vector};
use crate::patch::{Patch, PatchFlags};

/// `f32` or `f64`: the numbers that patches are made of.
pub trait Precision: Scalar {
    /// [`Patch::new`].
    #[doc(hidden)]
    fn new_patch(
        positions: [Vector<Self>; 3],
        normals: [Vector<Self>; 3],
        flags: PatchFlags,
    ) -> Patch<Self>;
    /// [`Patch::bounds`].
    #[doc(hidden)]
    fn patch_bounds(patch: &Patch<Self>) -> [Vector<Self>; 2];
    /// [`Patch::point`].
    #[doc(hidden)]
    fn patch_point(patch: &Patch<Self>, u: Self, v: Self) -> SurfacePoint<Self>;
    /// [`Patch::normal_at`].
    #[doc(hidden)]
    fn patch_normal(patch: &Patch<Self>, u: Self, v: Self) -> Vector<Self>;
    /// [`Patch::guide_at`].
    #[doc(hidden)]
    fn patch_guide(patch: &Patch<Self>, u: Self, v: Self) -> Vector<Self>;
    /// [`Patch::intersect`].
    #[doc(hidden)]
    fn intersect_patch(patch: &Patch<Self>, ray: &Ray<Self>, solver: Solver) -> Hit<Self>;
}

macro_rules! with_best_instructions {
    ($value:expr) => {
        dispatch!(Level::new(), simd => simd.vectorize(
            #[inline(always)]
            || $value
        ))
    };
}

macro_rules! as_it_is {
    ($value:expr) => {
        $value
    };
}

macro_rules! precision {
    ($float:ident, $run:ident) => {
        impl Precision for $float {
            fn new_patch(
                positions: [Vector<Self>; 3],
                normals: [Vector<Self>; 3],
                flags: PatchFlags,
            ) -> Patch<Self> {
                Patch::with_net(positions, normals, flags).0
            }
            fn patch_bounds(patch: &Patch<Self>) -> [Vector<Self>; 2] {
                patch.surface_box()
            }
            fn patch_point(patch: &Patch<Self>, u: Self, v: Self) -> SurfacePoint<Self> {
                $run!(patch.surface_point(u, v))
            }
            fn patch_normal(patch: &Patch<Self>, u: Self, v: Self) -> Vector<Self> {
                $run!(patch.geometric_normal(u, v))
            }
            fn patch_guide(patch: &Patch<Self>, u: Self, v: Self) -> Vector<Self> {
                patch.guide_vector(u, v)
            }
            fn intersect_patch(patch: &Patch<Self>, ray: &Ray<Self>, solver: Solver) -> Hit<Self> {
                patch.intersect_lanes(ray, solver)
            }
        }
    };
}

precision!(f32, with_best_instructions);
precision!(f64, as_it_is);

impl<S: Precision> Patch<S> {
    /// The curved triangle over three positions with unit normals.
    ///
    /// A pure function of its arguments: any two calls give the same patch. Positions may be in
    /// any units; the patch's own rays and points are in the same ones. What the method cannot
    /// take becomes flat or degenerate; see [`Patch::kind`].
    pub fn new(positions: [Vector<S>; 3], normals: [Vector<S>; 3], flags: PatchFlags) -> Self {
        S::new_patch(positions, normals, flags)
    }

    /// A box that contains the surface, in the units and axes of the positions: lower and upper
    /// corner. It is the tight one or the sphere's, by [the flags](PatchFlags::with_bounds).
    /// Conservative, rounding included; empty (`lower > upper`) for a degenerate triangle.
    pub fn bounds(&self) -> [Vector<S>; 2] {
        S::patch_bounds(self)
    }

    /// The surface over the plane point with barycentric coordinates `(1 - u - v, u, v)`.
    ///
    /// Analytic: derivatives are carried through the very source that computes the height. On a
    /// median, where the guide field has a kink, they are those of one side.
    pub fn point(&self, u: S, v: S) -> SurfacePoint<S> {
        S::patch_point(self, u, v)
    }

    /// The surface's own geometric normal at barycentric coordinates `(1 - u - v, u, v)`:
    /// [`SurfacePoint::normal`] without the rest.
    pub fn normal_at(&self, u: S, v: S) -> Vector<S> {
        S::patch_normal(self, u, v)
    }

    /// The guide `g` over the plane point with barycentric coordinates `(1 - u - v, u, v)`: the way
    /// from the plane to the surface, of equation (1), scaled so that its part along
    /// [`Patch::plane_normal`] is 1.
    pub fn guide_at(&self, u: S, v: S) -> Vector<S> {
        S::patch_guide(self, u, v)
    }

    /// The first hit with `tnear <= t <= tfar`.
    ///
    /// The plain form of the search, in one number at a time. [`PackedTriangle`](crate::PackedTriangle)
    /// gives the same answers faster.
    pub fn intersect(&self, ray: &Ray<S>, solver: Solver) -> Hit<S> {
        S::intersect_patch(self, ray, solver)
    }
}
