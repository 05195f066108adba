//! What a ray is clipped to: a patch's three edge planes (5) and the slab between its least and its
//! greatest height.

use super::ray::{Ray, localized};
use crate::bounds::{OVERLAP_EPSILONS, RAY_EPSILONS};
use crate::numbers::{Mask, Real, Scalar, Vector};
use crate::patch::{ClipVolume, HalfSpace, Sphere};

/// The least sine of a grazing angle that is made up for on thin triangles: the tolerance grows with one over
/// the sine, and below this, 8 epsilons, the sine is rounding itself.
const LEAST_SINE: f64 = 1e-6;

/// The plane below the surface, whose normal is the triangle's.
const UP: usize = 3;

/// A ray's way clipped to where a surface can be, in the ray's parameter: the paper's options 1 to 5
/// are all this one interval (section 4.8).
#[derive(Clone, Copy, Debug)]
pub struct RayInterval<V: Real> {
    pub(crate) start: V,
    pub(crate) length: V,
    /// Whether there is such an interval.
    pub(crate) alive: V::Mask,
}

impl<S: Scalar> ClipVolume<S> {
    /// The part of the ray within all planes; none in lanes that are not valid.
    #[inline(always)]
    pub fn clip<V: Real<Scalar = S>>(&self, ray: &Ray<V>, valid: V::Mask) -> RayInterval<V> {
        let [from, along] = localized(ray, self.origin, self.unit);
        let lanes = ray.tnear;
        let distance = from.max_abs();
        // Not cut at the ray's end, which is the nearest hit so far: the root must not depend on the
        // order in which patches are tested.
        let (mut lo, mut hi) = (ray.search_start(), lanes.constant(f64::INFINITY));
        let mut alive = valid & lanes.mask(self.exists);
        let grazing = self.grazing(along, distance);
        for plane in &self.planes {
            let plane = plane.in_lanes(lanes);
            let mut value = plane.value(from, distance);
            let rate = plane.normal.dot(along);
            if let Some([reach, later]) = grazing {
                value = value + reach * (rate.abs() * later + plane.distance_tolerance);
            }
            let crossing = Crossing::new(value, rate);
            lo = crossing.entry(lo).greater(lo);
            hi = crossing.exit(hi).lesser(hi);
            alive = alive & crossing.passes;
        }
        if let Some(sphere) = &self.sphere {
            let (enters, leaves, meets) = sphere.chord(from, along, distance);
            lo = enters.greater(lo);
            hi = leaves.lesser(hi);
            alive = alive & meets;
        }
        RayInterval::between(lo, hi, alive, ray.tfar)
    }

    /// For the rays at a thin triangle: how far rounding reaches, in its epsilons, and how much later
    /// than they would they cross the plane for it.
    #[inline(always)]
    fn grazing<V: Real<Scalar = S>>(&self, along: Vector<V>, distance: V) -> Option<[V; 2]> {
        let area2 = self.thin?;
        let epsilons = S::EPSILON * S::from_f64(RAY_EPSILONS);
        let rise = Vector::splat(distance, self.planes[UP].normal).dot(along);
        let least = along.length() * distance.splat(area2 * S::from_f64(LEAST_SINE));
        let later = distance.splat(area2 * epsilons) / rise.abs().greater(least);
        Some([distance + distance.one(), later])
    }
}

impl<S: Scalar> HalfSpace<S> {
    /// The same half-space in every lane of a value like this one.
    #[inline(always)]
    fn in_lanes<V: Real<Scalar = S>>(&self, lanes: V) -> HalfSpace<V> {
        HalfSpace {
            normal: Vector::splat(lanes, self.normal),
            offset: lanes.splat(self.offset),
            distance_tolerance: lanes.splat(self.distance_tolerance),
        }
    }
}

impl<V: Real> HalfSpace<V> {
    /// How far inside a point is, times the normal's length, for rays that come from this distance.
    #[inline(always)]
    pub(crate) fn value(&self, from: Vector<V>, distance: V) -> V {
        self.normal.dot(from) + self.distance_tolerance.mul_add(distance, self.offset)
    }
}

/// Where a ray crosses the plane that bounds a half-space, and which part of it lies inside.
pub(crate) struct Crossing<V: Real> {
    /// The ray's parameter there.
    at: V,
    /// Whether the ray enters there.
    enters: V::Mask,
    /// Whether it leaves there.
    leaves: V::Mask,
    /// Whether some part of it lies inside.
    pub passes: V::Mask,
}

impl<V: Real> Crossing<V> {
    /// Of a ray that starts with this [value](HalfSpace::value), which changes at this rate.
    #[inline(always)]
    pub fn new(value: V, rate: V) -> Self {
        let zero = value.zero();
        let at = -(value / rate);
        let (enters, leaves) = (zero.less(rate), rate.less(zero));
        Self {
            at,
            enters,
            leaves,
            passes: enters | leaves | zero.at_most(value),
        }
    }

    /// Where the ray enters; a value that bounds nothing where it does not.
    #[inline(always)]
    pub fn entry(&self, otherwise: V) -> V {
        V::select(self.enters, self.at, otherwise)
    }

    /// Where the ray leaves; a value that bounds nothing where it does not.
    #[inline(always)]
    pub fn exit(&self, otherwise: V) -> V {
        V::select(self.leaves, self.at, otherwise)
    }
}

impl<V: Real> RayInterval<V> {
    /// Between two parameters, where the second is not less and the ray gets to the first.
    #[inline(always)]
    pub(crate) fn between(lo: V, hi: V, alive: V::Mask, tfar: V) -> Self {
        Self {
            start: lo,
            length: hi - lo,
            alive: alive & lo.at_most(hi) & lo.at_most(tfar),
        }
    }

    /// Whether no lane's ray comes near the surface.
    #[inline(always)]
    pub fn is_empty(&self) -> bool {
        !self.alive.any()
    }
}

impl<S: Scalar> RayInterval<S> {
    /// The same interval in all lanes of a value like this one.
    #[inline(always)]
    pub(crate) fn in_lanes<V: Real<Scalar = S>>(&self, lanes: V) -> RayInterval<V> {
        RayInterval {
            start: lanes.splat(self.start),
            length: lanes.splat(self.length),
            alive: lanes.mask(self.alive),
        }
    }
}

impl<S: Scalar> Sphere<S> {
    /// Where a line enters the sphere and leaves it, and whether it does; in the units of the patch,
    /// of a ray that comes from this distance.
    ///
    /// The sphere goes through the vertices, where rounding must not lose a ray: so it is taken a
    /// guard larger. The chord is computed from the point nearest to the centre, which loses no digits
    /// to the way there.
    #[inline(always)]
    pub(crate) fn chord<V: Real<Scalar = S>>(
        &self,
        from: Vector<V>,
        along: Vector<V>,
        distance: V,
    ) -> (V, V, V::Mask) {
        let lanes = distance;
        let ulps = lanes.splat(S::EPSILON * S::from_f64(2.0 * RAY_EPSILONS));
        let guard = distance * ulps + lanes.splat(S::EPSILON * S::from_f64(OVERLAP_EPSILONS));
        let radius = lanes.splat(self.radius) + guard;
        // Squares of very short and of very long directions are out of range.
        let scale = lanes.one() / along.max_abs();
        let direction = along * scale;
        let length2 = direction.dot(direction);
        let to_start = from - Vector::splat(lanes, self.centre);
        let nearest = -(to_start.dot(direction) / length2);
        let beside = to_start + direction * nearest;
        let square = radius * radius - beside.dot(beside);
        let zero = lanes.zero();
        let half = (square.greater(zero) / length2).sqrt();
        let (enter, leave) = ((nearest - half) * scale, (nearest + half) * scale);
        (enter, leave, zero.at_most(square))
    }
}
