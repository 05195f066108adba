//! The volume that a ray is clipped to.

use super::sphere::Sphere;
use crate::numbers::{Constant, Vector, Visitor, vector};

/// A half-space that the surface lies in, with room for rounding. Nothing is normalised: only the
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
    /// In the slab's place, where it was asked for.
    pub(crate) sphere: Option<Sphere<S>>,
    /// Twice the area, of a flat triangle that is [thin](super::frame::THIN).
    pub(crate) thin: Option<S>,
    pub(crate) exists: bool,
}

impl<S: Constant> ClipVolume<S> {
    /// The hull of no surface.
    #[inline(always)]
    pub fn empty(origin: Vector<S>) -> Self {
        let zero = origin.x.constant(0.0);
        let plane = HalfSpace {
            normal: vector(zero, zero, zero),
            offset: zero,
            distance_tolerance: zero,
        };
        Self {
            origin,
            unit: origin.x.constant(1.0),
            planes: [plane; 5],
            sphere: None,
            thin: None,
            exists: false,
        }
    }
}

impl<S: Constant> HalfSpace<S> {
    #[inline(always)]
    fn visit(&mut self, at: usize, by: &mut impl Visitor<S>) {
        by.vector(at, &mut self.normal);
        by.number(at + 3, &mut self.offset);
        by.number(at + 4, &mut self.distance_tolerance);
    }
}

impl<S: Constant> ClipVolume<S> {
    /// Shows all numbers of a hull without a sphere.
    #[inline(always)]
    pub fn visit(&mut self, by: &mut impl Visitor<S>) {
        by.vector(0, &mut self.origin);
        by.number(3, &mut self.unit);
        let [a, b, c, d, e] = &mut self.planes;
        a.visit(4, by);
        b.visit(9, by);
        c.visit(14, by);
        d.visit(19, by);
        e.visit(24, by);
    }
}
