//! What a ray is clipped to: a patch's three side planes (5) and the slab between its least and its
//! greatest height.

use super::columns::Visitor;
use super::frame::Frame;
use super::ray::{RAY_EPSILONS, Ray};
use super::real::{Constant, Mask, Real, Scalar, inlined};
use super::sides::roots;
use super::sphere::Sphere;
use super::vector::{Vector, vector};

/// How far beyond its sides a patch is still searched, in barycentric coordinates, before the
/// ray's own rounding: a guard, so that no ray slips between neighbours.
pub(super) const OVERLAP_EPSILONS: f64 = 256.0;
/// The least sine of a grazing angle that is made up for on thin triangles.
const LEAST_SINE: f64 = 1e-6;

/// The plane below the surface, whose normal is the triangle's.
const UP: usize = 3;

/// A half-space that the surface lies in, with room for rounding. Nothing is normalised: only the
/// sign counts, and where it changes along a ray.
#[derive(Clone, Copy, Debug)]
pub(super) struct Plane<S> {
    /// Inward.
    pub normal: Vector<S>,
    pub offset: S,
    /// How much further out for a unit of the distance that rays come from: of rounding, by so many epsilons
    /// of it; the normal is about as long.
    pub spread: S,
}

/// The planes around a patch, five in the same form, so that all can be looked at at once.
#[derive(Clone, Copy, Debug)]
pub(super) struct Hull<S> {
    origin: Vector<S>,
    unit: S,
    planes: [Plane<S>; 5],
    /// In the slab's place, where it was asked for.
    pub(super) sphere: Option<Sphere<S>>,
    /// Twice the area, of a flat triangle that is [thin](super::frame::THIN).
    thin: Option<S>,
    pub(super) exists: bool,
}

/// A ray's way clipped to where a surface can be, in the ray's parameter: the paper's options 1 to 5
/// are all this one interval (section 4.8).
#[derive(Clone, Copy, Debug)]
pub struct Interval<V: Real> {
    pub(super) start: V,
    pub(super) length: V,
    /// Whether there is such an interval.
    pub(super) alive: V::Mask,
}

impl<S: Constant> Hull<S> {
    /// The hull of no surface.
    #[inline(always)]
    pub fn empty(origin: Vector<S>) -> Self {
        let zero = origin.x.constant(0.0);
        let plane = Plane {
            normal: vector(zero, zero, zero),
            offset: zero,
            spread: zero,
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

impl<S: Constant> Hull<S> {
    /// The hull of a patch with these least and greatest heights, or with a sphere in their place; of a
    /// plane triangle, not a thin one, without heights.
    #[inline(always)]
    pub fn around(
        frame: &Frame<S>,
        normals: &[Vector<S>; 3],
        slab: Option<[S; 2]>,
        sphere: Option<Sphere<S>>,
    ) -> Self {
        let constant = inlined(
            #[inline(always)]
            |value: f64| frame.area2.constant(value),
        );
        let up = frame.cross * frame.winding;
        // Of the guides below.
        let longest_guide = match slab {
            Some(_) => constant(2.0),
            None => frame.area2,
        };
        let lengths = roots(frame.lengths2);
        let side = inlined(
            #[inline(always)]
            |k: usize| {
                // The guides' plane through the side; it stands upright where the triangle is flat.
                let guide = match slab {
                    Some(_) => normals[k] + normals[(k + 1) % 3],
                    None => up,
                };
                let reach = longest_guide * lengths[k];
                Plane::of_sides(frame.edges[k], guide, up, frame.winding, reach)
            },
        );
        // A flat triangle's slab has no thickness: there the crossing of its plane decides.
        let [below, above] = match slab {
            Some([least, most]) if sphere.is_none() => [-least * frame.area2, most * frame.area2],
            _ => [constant(f64::INFINITY); 2],
        };
        Self {
            origin: frame.origin,
            unit: frame.size.per_power_of_two(),
            planes: [
                side(0),
                side(1).through(frame.edges[0]),
                side(2),
                Plane::level(up, below, frame.area2),
                Plane::level(-up, above, frame.area2),
            ],
            sphere,
            thin: None,
            exists: true,
        }
    }
}

impl<V: Real> Plane<V> {
    /// Through a side that begins at the origin, along a guide of the side of any length; `up` is the
    /// triangle's normal, twice its area long, and `reach` is about as long as the normal will be.
    #[inline(always)]
    pub fn of_sides(
        edge: Vector<V>,
        guide: Vector<V>,
        up: Vector<V>,
        winding: V,
        reach: V,
    ) -> Self {
        // The value at the opposite vertex: a barycentric coordinate of 1.
        let whole = guide.dot(up);
        Self {
            normal: guide.cross(edge) * winding,
            offset: whole * whole.constant(V::Scalar::PRECISION * OVERLAP_EPSILONS),
            spread: reach * reach.constant(V::Scalar::PRECISION * RAY_EPSILONS),
        }
    }

    /// The same where the side begins elsewhere.
    #[inline(always)]
    pub fn through(self, way: Vector<V>) -> Self {
        Self {
            offset: self.offset - self.normal.dot(way),
            ..self
        }
    }

    /// Across the triangle's normal or its opposite, that far from the origin times twice the area.
    #[inline(always)]
    pub fn level(normal: Vector<V>, offset: V, area2: V) -> Self {
        Self {
            normal,
            offset,
            spread: area2 * area2.constant(V::Scalar::PRECISION * RAY_EPSILONS),
        }
    }
}

impl<S: Constant> Plane<S> {
    #[inline(always)]
    fn visit(&mut self, at: usize, by: &mut impl Visitor<S>) {
        by.vector(at, &mut self.normal);
        by.number(at + 3, &mut self.offset);
        by.number(at + 4, &mut self.spread);
    }
}

impl<S: Constant> Hull<S> {
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

impl<S: Scalar> Hull<S> {
    /// The same of a plane triangle of any height as well.
    #[inline(always)]
    pub fn new(
        frame: &Frame<S>,
        normals: &[Vector<S>; 3],
        slab: Option<[S; 2]>,
        sphere: Option<Sphere<S>>,
    ) -> Self {
        Self {
            thin: (slab.is_none() && frame.is_thin()).then_some(frame.area2),
            ..Self::around(frame, normals, slab, sphere)
        }
    }

    /// The part of the ray within all planes; none in lanes that are not valid.
    #[inline(always)]
    pub fn clip<V: Real<Scalar = S>>(&self, ray: &Ray<V>, valid: V::Mask) -> Interval<V> {
        let [from, along] = localized(ray, self.origin, self.unit);
        let like = ray.tnear;
        let zero = like.constant(0.0);
        let distance = from.max_abs();
        // Not cut at the ray's end, which is the nearest hit so far: the root must not depend on the
        // order in which patches are come by.
        let (mut lo, mut hi) = (like, like.constant(f64::INFINITY));
        let mut alive = valid & like.mask(self.exists);
        let grazing = self.grazing(along, distance);
        for plane in &self.planes {
            let normal = Vector::splat(like, plane.normal);
            let offset = like
                .splat(plane.spread)
                .mul_add(distance, like.splat(plane.offset));
            let mut value = normal.dot(from) + offset;
            let rate = normal.dot(along);
            if let Some([reach, later]) = grazing {
                value = value + reach * (rate.abs() * later + like.splat(plane.spread));
            }
            let crossing = -(value / rate);
            let (enters, leaves) = (zero.less(rate), rate.less(zero));
            lo = V::select(enters, crossing, lo).greater(lo);
            hi = V::select(leaves, crossing, hi).lesser(hi);
            alive = alive & (enters | leaves | zero.at_most(value));
        }
        if let Some(sphere) = &self.sphere {
            let (enters, leaves, meets) = sphere.chord(from, along, distance);
            lo = enters.greater(lo);
            hi = leaves.lesser(hi);
            alive = alive & meets;
        }
        Interval {
            start: lo,
            length: hi - lo,
            alive: alive & lo.at_most(hi) & lo.at_most(ray.tfar),
        }
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
        Some([distance + distance.constant(1.0), later])
    }
}

impl<V: Real> Interval<V> {
    /// Whether no lane's ray comes near the surface.
    #[inline(always)]
    pub fn is_empty(&self) -> bool {
        !self.alive.any()
    }
}

impl<S: Scalar> Interval<S> {
    /// The same interval in all lanes of a value like this one.
    #[inline(always)]
    pub(super) fn in_lanes<V: Real<Scalar = S>>(&self, like: V) -> Interval<V> {
        Interval {
            start: like.splat(self.start),
            length: like.splat(self.length),
            alive: like.mask(self.alive),
        }
    }
}

/// The ray's origin and direction in a patch's space and units.
#[inline(always)]
pub(super) fn localized<V: Real>(
    ray: &Ray<V>,
    origin: Vector<V::Scalar>,
    unit: V::Scalar,
) -> [Vector<V>; 2] {
    let unit = ray.tnear.splat(unit);
    let from = (ray.origin - Vector::splat(ray.tnear, origin)) * unit;
    [from, ray.direction * unit]
}
