//! A ray against one patch: the interval in which it can meet the surface, and the function whose
//! root is the hit.

use crate::numbers::{Cursor, Fields, Real, Scalar, Vector, vector};
use crate::patch::{Patch, Rule, THIN};
use crate::store::PackedTriangle;

/// A ray in the space of the patch's positions.
#[derive(Clone, Copy, Debug)]
pub struct Ray<V> {
    /// Where `t = 0`.
    pub origin: Vector<V>,
    /// The way for one unit of `t`; need not be unit.
    pub direction: Vector<V>,
    /// Least parameter of a hit.
    pub tnear: V,
    /// Greatest parameter of a hit.
    pub tfar: V,
}

impl<V: Real> Ray<V> {
    /// Where roots are looked for: from the origin on, or from `tnear` where that is below zero. Not from a
    /// greater `tnear`: a root then does not depend on where the ray begins, to the last bit, and a ray that
    /// begins at its own hit has it.
    #[inline(always)]
    pub(crate) fn search_start(&self) -> V {
        self.tnear.lesser(self.tnear.zero())
    }

    /// A ray that leads nowhere.
    #[inline(always)]
    pub(crate) fn blank(any: V) -> Self {
        let vector = vector(any, any, any);
        Self {
            origin: vector,
            direction: vector,
            tnear: any,
            tfar: any,
        }
    }
}

impl<V: Real> Fields<V> for Ray<V> {
    const COUNT: usize = 8;

    #[inline(always)]
    fn visit(&mut self, cursor: &mut impl Cursor<V>) {
        cursor.vector(&mut self.origin);
        cursor.vector(&mut self.direction);
        cursor.number(&mut self.tnear);
        cursor.number(&mut self.tfar);
    }
}

impl<S: Scalar> Ray<S> {
    /// The same ray in all lanes of a value like this one.
    #[inline(always)]
    pub(crate) fn in_lanes<V: Real<Scalar = S>>(&self, lanes: V) -> Ray<V> {
        Ray {
            origin: Vector::splat(lanes, self.origin),
            direction: Vector::splat(lanes, self.direction),
            tnear: lanes.splat(self.tnear),
            tfar: lanes.splat(self.tfar),
        }
    }
}

/// Whether a patch is a flat triangle so thin that rounding along its plane matters.
#[inline(always)]
pub(crate) fn is_thin<S: Scalar>(patch: &Patch<S>) -> bool {
    let height = patch.base.edge.constant(
        #[inline(always)]
        |k| patch.edges[k].height,
    );
    patch.rule == Rule::Flat && height < S::from_f64(THIN)
}

/// How far beyond a root the search for the next one begins, in units of the patch's size: 84 epsilons, more
/// than the 64 by which a hit may lie beside its guide. To it comes twice what rounding moves a ray by.
const BEYOND: f64 = 1e-5;

/// The least parameter at which to look for the root after the one at `t`, on a patch at `origin` of
/// this size.
pub(crate) fn beyond<S: Scalar>(origin: Vector<S>, size: S, ray: &Ray<S>, t: S) -> S {
    let way = ray.direction.length();
    let distance = (ray.origin - origin).length();
    let step = size * S::from_f64(BEYOND) + distance * S::EPSILON * S::from_f64(8.0);
    t + (step / way).greater(t.abs() * S::EPSILON * S::from_f64(2.0))
}

/// The ray's origin and direction in a patch's space and units.
#[inline(always)]
pub(crate) fn localized<V: Real>(
    ray: &Ray<V>,
    origin: Vector<V::Scalar>,
    unit: V::Scalar,
) -> [Vector<V>; 2] {
    let unit = ray.tnear.splat(unit);
    let from = (ray.origin - Vector::splat(ray.tnear, origin)) * unit;
    [from, ray.direction * unit]
}

impl PackedTriangle<'_> {
    /// The same as [`Patch::beyond`].
    pub fn beyond(&self, ray: &Ray<f32>, t: f32) -> f32 {
        beyond(self.vertices().positions[0], self.vertices().size(), ray, t)
    }
}
