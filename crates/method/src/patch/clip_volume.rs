//! The volume that a ray is clipped to.

use super::sphere::Sphere;
use crate::numbers::{Constant, Cursor, Fields, Vector, vector};

/// A half-space that the surface lies in, rounding included. Nothing is normalised: only the
/// sign counts, and where it changes along a ray.
#[derive(Clone, Copy, Debug)]
pub(crate) struct HalfSpace<S> {
    /// Inward.
    pub normal: Vector<S>,
    pub offset: S,
    /// How much further out for a unit of the distance that rays come from: of rounding, by so many epsilons
    /// of it; the normal is about as long.
    pub distance_tolerance: S,
}

/// The planes around a patch, five in the same form, so that all can be looked at at once.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ClipVolume<S> {
    pub(crate) origin: Vector<S>,
    pub(crate) unit: S,
    pub(crate) planes: [HalfSpace<S>; 5],
    /// In the slab's place, where it was requested.
    pub(crate) sphere: Option<Sphere<S>>,
    /// Twice the area, of a flat triangle that is [thin](super::THIN).
    pub(crate) thin: Option<S>,
    pub(crate) exists: bool,
}

impl<S: Constant> ClipVolume<S> {
    /// The hull of no surface.
    #[inline(always)]
    pub fn empty(origin: Vector<S>) -> Self {
        let zero = origin.x.zero();
        let plane = HalfSpace {
            normal: vector(zero, zero, zero),
            offset: zero,
            distance_tolerance: zero,
        };
        Self {
            origin,
            unit: origin.x.one(),
            planes: [plane; 5],
            sphere: None,
            thin: None,
            exists: false,
        }
    }
}

impl<S: Constant> Fields<S> for HalfSpace<S> {
    const COUNT: usize = 5;

    #[inline(always)]
    fn visit(&mut self, cursor: &mut impl Cursor<S>) {
        cursor.vector(&mut self.normal);
        cursor.number(&mut self.offset);
        cursor.number(&mut self.distance_tolerance);
    }
}

/// All numbers of a volume without a sphere.
impl<S: Constant> Fields<S> for ClipVolume<S> {
    const COUNT: usize = 3 + 1 + 5 * HalfSpace::<S>::COUNT;

    #[inline(always)]
    fn visit(&mut self, cursor: &mut impl Cursor<S>) {
        cursor.vector(&mut self.origin);
        cursor.number(&mut self.unit);
        let [a, b, c, d, e] = &mut self.planes;
        a.visit(cursor);
        b.visit(cursor);
        c.visit(cursor);
        d.visit(cursor);
        e.visit(cursor);
    }
}
