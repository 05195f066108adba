//! A ray's way over a patch's plane.

use super::clip::RayInterval;
use super::ray::{Ray, localized};
use crate::bounds::RAY_EPSILONS;
use crate::numbers::{
    Constant, Cursor, Fields, Mask, Real, Scalar, Vector, from_array, inlined, to_array,
};
use crate::patch::Patch;

/// A ray's way over a patch's plane, clipped to where the surface can be: the paper's options 1 to
/// 5 are all this one interval (section 4.8).
#[derive(Clone, Copy, Debug)]
pub struct Segment<V: Real> {
    /// Where the interval begins, in the ray's parameter.
    pub(crate) start: V,
    /// Its length; the segment's own parameter runs from 0 to here.
    pub(crate) length: V,
    /// Whether there is an interval at all.
    pub(crate) alive: V::Mask,
    /// How far beside a guide a point may lie and still count as on it, in units of the patch's
    /// size: what rounding of the ray comes to.
    pub(crate) stray_tolerance: V,
    /// How near to zero F must be at the start for the ray to count as crossing the surface there: it
    /// came in through an edge, and rounding decides whether it crossed before or behind that. Below
    /// zero where the ray came in otherwise.
    pub(crate) entry_tolerance: V,
    /// The same at the end.
    pub(crate) exit_tolerance: V,
    /// The ray's `tnear`: roots before it are passed over.
    pub(crate) tnear: V,
    /// Length of the direction in units of the patch's size.
    pub(crate) speed: V,
    /// Barycentric coordinates of the vertical projection at the start, and their rates.
    pub(crate) b: [V; 3],
    pub(crate) b_rate: [V; 3],
    /// Height over the plane at the start, and its rate.
    pub(crate) z: V,
    pub(crate) z_rate: V,
}

/// How far beside a guide a hit may lie before the ray's own rounding, in epsilons of the patch's size.
///
/// Chosen, not derived: 64 epsilons are 8e-6, a quarter of the overlap of neighbours, so that a foot that is
/// moved as far still lies where neighbours overlap. False roots of F, where the inverse of the guide field
/// jumps, lie much further off.
const STRAY_EPSILONS: f64 = 64.0;

/// Rounding of F itself, beside what the ray's distance adds, in units of epsilon.
///
/// Measured, not derived: without it 87 of 6,000 rays along a long thread of small triangles, from inside,
/// were lost at ends of their way over a patch; Embree's robust flat triangles lose 55.
const CLEARANCE_EPSILONS: f64 = 8.0;

/// The steepest that F is expected to be along a ray, for a unit of its way.
///
/// Derived for slopes at the vertices: a surface with the normal's cosine c to the plane's rises by
/// `sqrt(1 / c^2 - 1)`, which is 8 for c = 0.12; the method takes triangles from c = 0.1 on.
const STEEPEST: f64 = 8.0;

/// How many numbers a segment is made of.
pub(crate) const SEGMENT_NUMBERS: usize = Segment::<f32>::COUNT;

/// All numbers but whether there is an interval.
impl<V: Real> Fields<V> for Segment<V> {
    const COUNT: usize = 15;

    #[inline(always)]
    fn visit(&mut self, cursor: &mut impl Cursor<V>) {
        cursor.number(&mut self.start);
        cursor.number(&mut self.length);
        cursor.number(&mut self.stray_tolerance);
        cursor.number(&mut self.entry_tolerance);
        cursor.number(&mut self.exit_tolerance);
        cursor.number(&mut self.tnear);
        cursor.number(&mut self.speed);
        cursor.number(&mut self.b[0]);
        cursor.number(&mut self.b[1]);
        cursor.number(&mut self.b[2]);
        cursor.number(&mut self.b_rate[0]);
        cursor.number(&mut self.b_rate[1]);
        cursor.number(&mut self.b_rate[2]);
        cursor.number(&mut self.z);
        cursor.number(&mut self.z_rate);
    }
}

impl<V: Real> Segment<V> {
    /// Whether no lane's ray comes near the surface.
    #[inline(always)]
    pub fn is_empty(&self) -> bool {
        !self.alive.any()
    }

    /// The part of the ray within an interval. It begins anew at the entry: the steps along the ray are
    /// then small against its position.
    #[inline(always)]
    pub(crate) fn new<S: Constant>(
        patch: &Patch<S>,
        ray: &Ray<V>,
        interval: &RayInterval<V>,
    ) -> Self
    where
        V: Real<Scalar = S>,
    {
        let [from, along] = localized(ray, patch.origin, patch.size.per_power_of_two());
        let distance = from.max_abs();
        let alive = interval.alive;
        let entry = V::select(alive, interval.start, ray.tnear);
        let local = Self::unclipped(patch, along.mul_add(entry, from), along, entry, ray.tfar);
        let epsilons = distance.constant(S::PRECISION * RAY_EPSILONS);
        let stray_tolerance =
            distance.mul_add(epsilons, distance.constant(S::PRECISION * STRAY_EPSILONS));
        let exit_tolerance = distance.mul_add(
            epsilons,
            distance.constant(S::PRECISION * CLEARANCE_EPSILONS),
        );
        let entered = ray.search_start().less(interval.start);
        Self {
            length: interval.length,
            alive,
            stray_tolerance,
            entry_tolerance: V::select(entered, exit_tolerance, -exit_tolerance),
            exit_tolerance,
            tnear: ray.tnear,
            ..local
        }
    }

    /// The whole line, from the ray's origin on.
    #[cfg(test)]
    pub(crate) fn unclipped_at_start<S: Constant>(patch: &Patch<S>, ray: &Ray<V>) -> Self
    where
        V: Real<Scalar = S>,
    {
        let [from, along] = localized(ray, patch.origin, patch.size.per_power_of_two());
        Self::unclipped(patch, from, along, ray.tnear, ray.tfar)
    }

    #[inline(always)]
    fn unclipped<S: Constant>(
        patch: &Patch<S>,
        from: Vector<V>,
        along: Vector<V>,
        start: V,
        end: V,
    ) -> Self
    where
        V: Real<Scalar = S>,
    {
        let lanes = start;
        let (zero, one) = (lanes.zero(), lanes.one());
        let normal = Vector::splat(lanes, patch.normal);
        let corner = from - Vector::splat(lanes, patch.base.corner);
        let [across, base] = Vector::splat_both(lanes, [patch.base.across, patch.base.along]);
        let (edge, foot) = (
            patch.base.edge.in_lanes(lanes),
            lanes.splat(patch.base.foot),
        );
        let coordinates = inlined(
            #[inline(always)]
            |b_m: V, x: V, sum: V| {
                let b_j = x.less_product(foot, b_m);
                edge.placed([sum - b_j - b_m, b_j, b_m])
            },
        );
        Self {
            start,
            length: end,
            alive: lanes.mask(true),
            stray_tolerance: zero,
            entry_tolerance: zero,
            exit_tolerance: zero,
            tnear: start,
            speed: along.length(),
            b: coordinates(across.dot(corner), base.dot(corner), one),
            b_rate: coordinates(across.dot(along), base.dot(along), zero),
            z: normal.dot(from),
            z_rate: normal.dot(along),
        }
    }

    /// How much later than a point of the plane the ray passes another one nearest, which lies off
    /// the first by these barycentric coordinates of the second and third vertex; and how far
    /// beside it, in units of the patch's size.
    #[inline(always)]
    pub(crate) fn passing<S: Scalar>(&self, patch: &Patch<S>, [u, v]: [V; 2]) -> [V; 2]
    where
        V: Real<Scalar = S>,
    {
        let [to_second, to_third] = Vector::splat_both(u, patch.spokes);
        let in_plane = to_second * self.b_rate[1] + to_third * self.b_rate[2];
        let along = in_plane + Vector::splat(u, patch.normal) * self.z_rate;
        let off = to_second * u + to_third * v;
        let later = along.dot(off) / along.dot(along);
        [later, (off - along * later).length()]
    }

    /// The tolerance at which a root is as good as the precision allows, in the segment's parameter.
    #[inline(always)]
    pub(crate) fn parameter_tolerance(&self) -> V {
        let epsilon = self.speed.constant(V::Scalar::PRECISION);
        epsilon / self.speed + epsilon * epsilon.constant(0.25) * self.start.abs()
    }

    /// All its numbers.
    #[inline(always)]
    pub(crate) fn numbers(&self) -> [V; SEGMENT_NUMBERS] {
        to_array(*self, self.start)
    }

    /// The segment of these numbers.
    #[inline(always)]
    pub(crate) fn from_numbers(numbers: &[V; SEGMENT_NUMBERS], alive: V::Mask) -> Self {
        let any = numbers[0];
        let blank = Self {
            start: any,
            length: any,
            alive,
            stray_tolerance: any,
            entry_tolerance: any,
            exit_tolerance: any,
            tnear: any,
            speed: any,
            b: [any; 3],
            b_rate: [any; 3],
            z: any,
            z_rate: any,
        };
        from_array(blank, numbers)
    }

    /// The segment of one ray in every lane of a value like this one, to be looked at in several
    /// places at once.
    #[inline(always)]
    pub(crate) fn in_lanes<L: Real<Scalar = V>>(&self, lanes: L) -> Segment<L>
    where
        V: Scalar,
    {
        // Not by `map`, which is not always inlined and then costs a lane more than its work.
        let mut numbers = [lanes; SEGMENT_NUMBERS];
        for (value, number) in numbers.iter_mut().zip(self.numbers()) {
            *value = lanes.splat(number);
        }
        Segment::from_numbers(&numbers, lanes.mask(self.alive))
    }

    /// What a steep surface may rise within a step of this width of the segment's parameter, in
    /// units of the patch's size.
    #[inline(always)]
    pub(crate) fn steps(&self, width: V) -> V {
        width * self.speed * width.constant(STEEPEST)
    }

    /// Begins the segment anew a little beyond `at`.
    #[inline(always)]
    pub(crate) fn skip_to(&mut self, at: V) {
        let at = at + self.parameter_tolerance() * at.constant(16.0);
        self.b = self.projection(at);
        self.z = self.z(at);
        self.start = self.start + at;
        self.entry_tolerance = -self.exit_tolerance;
        self.length = self.length - at;
        self.alive = self.alive & at.zero().less(self.length);
    }

    /// The ray's parameter at the segment's.
    #[inline(always)]
    pub(crate) fn t(&self, at: V) -> V {
        self.start + at
    }

    /// Height over the plane at the segment's parameter.
    #[inline(always)]
    pub(crate) fn z(&self, at: V) -> V {
        self.z_rate.mul_add(at, self.z)
    }

    /// Barycentric coordinates of the vertical projection at the segment's parameter.
    #[inline(always)]
    pub(crate) fn projection(&self, at: V) -> [V; 3] {
        three!(|i| self.b_rate[i].mul_add(at, self.b[i]))
    }

    /// Where the ray crosses the triangle's plane, in the segment's parameter, and in which lanes it
    /// does so within the segment.
    #[inline(always)]
    pub(crate) fn plane_crossing(&self) -> (V, V::Mask) {
        let at = -(self.z / self.z_rate);
        let zero = at.zero();
        let (early, late) = (at.less(zero), self.length.less(at));
        let near = (early & self.z.abs().at_most(self.entry_tolerance))
            | (late & self.z(self.length).abs().at_most(self.exit_tolerance));
        let within = zero.at_most(at) & at.at_most(self.length);
        (
            at.greater(zero).lesser(self.length),
            self.alive & (within | near),
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numbers::assert_counted;

    #[test]
    fn segments_and_rays_show_as_many_numbers_as_they_say() {
        assert_counted(Segment::from_numbers(&[0.0; SEGMENT_NUMBERS], true));
        assert_counted(Ray::blank(0.0));
    }
}
