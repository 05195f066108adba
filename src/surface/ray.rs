//! A ray against one patch: the interval in which it can meet the surface, and the function whose
//! root is the hit.

use super::patch::{Patch, Rule, next};
use super::real::{Mask, Real, Scalar, inlined, three};
use super::vector::Vector;

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

/// A ray's way over a patch's plane, clipped to where the surface can be: the paper's options 1 to
/// 5 are all this one interval (section 4.8).
#[derive(Clone, Copy, Debug)]
pub struct Segment<V: Real> {
    /// Where the interval begins, in the ray's parameter.
    pub(super) start: V,
    /// Its length; the segment's own parameter runs from 0 to here.
    pub(super) length: V,
    /// Whether there is an interval at all.
    pub(super) alive: V::Mask,
    /// How far beside a guide a point may lie and still count as on it, in units of the patch's
    /// size: what rounding of the ray comes to.
    pub(super) stray_room: V,
    /// Length of the direction in units of the patch's size.
    speed: V,
    /// Barycentric coordinates of the vertical projection at the start, and their rates.
    b: [V; 3],
    b_rate: [V; 3],
    /// Height over the plane at the start, and its rate.
    z: V,
    z_rate: V,
}

/// How far beyond its sides a patch is still searched, in barycentric coordinates, before the
/// ray's own rounding: a guard, so that no ray slips between neighbours.
pub(super) const OVERLAP_EPSILONS: f64 = 256.0;
/// How far beside a guide a hit may lie before the ray's own rounding.
const STRAY_EPSILONS: f64 = 64.0;
/// The steepest that F is expected to be along a ray, for a unit of its way.
const STEEPEST: f64 = 8.0;
/// What a ray from one unit away moves by rounding, in units of epsilon.
pub(super) const RAY_EPSILONS: f64 = 4.0;
/// A flat triangle lower than this, in units of its size, is thin: the guard's share of its height
/// does not make up for rounding of the triangle itself, nor for how far along its plane a ray at a
/// grazing angle is moved by its own.
const THIN: f64 = 1.0 / 32.0;
/// The least sine of a grazing angle that is made up for.
const LEAST_SINE: f64 = 1e-3;

/// How far beyond side `k` a ray from this distance, in units of the patch's size, still counts.
///
/// Rounding moves a ray by some epsilons of the way from its origin to the patch, and by different
/// ones for two neighbours.
#[inline(always)]
fn guard<S: Scalar, V: Real<Scalar = S>>(patch: &Patch<S>, k: usize, distance: V) -> V {
    let ulps = S::EPSILON * S::from_f64(RAY_EPSILONS) / patch.sides[k].height;
    distance * distance.splat(ulps) + distance.splat(S::EPSILON * S::from_f64(OVERLAP_EPSILONS))
}

/// Whether a patch is a flat triangle so thin that rounding along its plane matters.
#[inline(always)]
pub(super) fn is_thin<S: Scalar>(patch: &Patch<S>) -> bool {
    patch.rule == Rule::Flat && patch.sides[patch.base].height < S::from_f64(THIN)
}

#[inline(always)]
pub(super) fn max_abs<V: Real>(v: Vector<V>) -> V {
    v.x.abs().greater(v.y.abs()).greater(v.z.abs())
}

impl<V: Real> Segment<V> {
    /// Whether no lane's ray comes near the surface.
    #[inline(always)]
    pub fn is_empty(&self) -> bool {
        !self.alive.any()
    }

    /// The part of the ray between the three side planes (5) and within the slab of heights, or in the
    /// paper's form within the sphere of greatest curvature (3); none in lanes that are not valid.
    #[inline(always)]
    pub(super) fn clip<S: Scalar>(patch: &Patch<S>, ray: &Ray<V>, valid: V::Mask) -> Self
    where
        V: Real<Scalar = S>,
    {
        let unit = ray.tnear.splat(S::from_f64(1.0) / patch.size);
        let from = (ray.origin - Vector::splat(ray.tnear, patch.origin)) * unit;
        let along = ray.direction * unit;
        // Not cut at the ray's end, which is the nearest hit so far: the root must not depend on the
        // order in which patches are come by.
        let end = ray.tfar.constant(f64::INFINITY);
        let mut segment = Self::unclipped(patch, from, along, ray.tnear, end);
        let distance = max_abs(from);
        segment.clip_to(patch, distance, valid);
        if let Some(sphere) = &patch.sphere {
            segment.keep_within(sphere.chord(from, along, distance));
        }
        segment.alive = segment.alive & segment.start.at_most(ray.tfar);
        if segment.is_empty() {
            return segment;
        }
        // Begin anew at the entry: the steps along the ray are then small against its position.
        let entry = V::select(segment.alive, segment.start, ray.tnear);
        let local = Self::unclipped(patch, from + along * entry, along, entry, ray.tfar);
        let like = distance;
        let epsilons = like.splat(S::EPSILON * S::from_f64(RAY_EPSILONS));
        let stray_room = distance * epsilons + like.splat(S::EPSILON * S::from_f64(STRAY_EPSILONS));
        Self {
            start: entry,
            length: segment.length,
            alive: segment.alive,
            stray_room,
            ..local
        }
    }

    /// The whole line, from the ray's origin on.
    #[cfg(test)]
    pub(super) fn unclipped_at_start<S: Scalar>(patch: &Patch<S>, ray: &Ray<V>) -> Self
    where
        V: Real<Scalar = S>,
    {
        let unit = ray.tnear.splat(S::from_f64(1.0) / patch.size);
        let from = (ray.origin - Vector::splat(ray.tnear, patch.origin)) * unit;
        Self::unclipped(patch, from, ray.direction * unit, ray.tnear, ray.tfar)
    }

    #[inline(always)]
    fn unclipped<S: Scalar>(
        patch: &Patch<S>,
        from: Vector<V>,
        along: Vector<V>,
        start: V,
        end: V,
    ) -> Self
    where
        V: Real<Scalar = S>,
    {
        let like = start;
        let (zero, one) = (like.constant(0.0), like.constant(1.0));
        let normal = Vector::splat(like, patch.normal);
        let (i, j, m) = (patch.base, next(patch.base), next(next(patch.base)));
        let corner = match i {
            0 => from,
            _ => from - Vector::splat(like, patch.spokes[i - 1]),
        };
        let (across, base) = (
            Vector::splat(like, patch.gradients[m]),
            Vector::splat(like, patch.along_base),
        );
        let foot = like.splat(patch.sides[i].foot);
        let coordinates = inlined(
            #[inline(always)]
            |b_m: V, x: V, sum: V| {
                let mut b = [zero; 3];
                b[m] = b_m;
                b[j] = x - foot * b_m;
                b[i] = sum - b[j] - b_m;
                b
            },
        );
        Self {
            start,
            length: end,
            alive: like.mask(true),
            stray_room: zero,
            speed: along.length(),
            b: coordinates(across.dot(corner), base.dot(corner), one),
            b_rate: coordinates(across.dot(along), base.dot(along), zero),
            z: normal.dot(from),
            z_rate: normal.dot(along),
        }
    }

    /// On a thin flat triangle, how much later a ray crosses the plane for a unit of height.
    #[inline(always)]
    fn grazing<S: Scalar>(&self, patch: &Patch<S>) -> Option<V>
    where
        V: Real<Scalar = S>,
    {
        is_thin(patch).then(
            #[inline(always)]
            || {
                let least = self.speed * self.speed.constant(LEAST_SINE);
                self.speed.constant(1.0) / self.z_rate.abs().greater(least)
            },
        )
    }

    /// How much later than a point of the plane the ray passes another one nearest, which lies off
    /// the first by these barycentric coordinates of the second and third vertex; and how far
    /// beside it, in units of the patch's size.
    #[inline(always)]
    pub(super) fn passing<S: Scalar>(&self, patch: &Patch<S>, [u, v]: [V; 2]) -> [V; 2]
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

    /// Sets `start`, `length` and `alive`, all still in the ray's parameter from its origin.
    #[inline(always)]
    fn clip_to<S: Scalar>(&mut self, patch: &Patch<S>, distance: V, valid: V::Mask)
    where
        V: Real<Scalar = S>,
    {
        let (mut lo, mut hi) = (self.start, self.length);
        let like = distance;
        let mut alive = valid;
        let mut keep = inlined(
            #[inline(always)]
            |value: V, rate: V| {
                // Where value + rate t >= 0.
                let zero = rate.constant(0.0);
                let crossing = -(value / rate);
                lo = V::select(zero.less(rate), crossing, lo).greater(lo);
                hi = V::select(rate.less(zero), crossing, hi).lesser(hi);
                let moves = zero.less(rate) | rate.less(zero);
                alive = alive & (moves | zero.at_most(value));
            },
        );
        let grazing = self.grazing(patch);
        for (k, side) in patch.sides.iter().enumerate() {
            let m = next(next(k));
            let tilt = like.splat(side.tilt);
            let mut guard = guard(patch, k, distance);
            if let Some(inverse) = grazing {
                let room = like.splat(S::EPSILON * S::from_f64(RAY_EPSILONS));
                let ways =
                    self.b_rate[m].abs() * inverse + like.splat(S::from_f64(1.0) / side.height);
                guard = guard + (distance + like.constant(1.0)) * room * ways;
            }
            keep(
                self.b[m] - tilt * self.z + guard,
                self.b_rate[m] - tilt * self.z_rate,
            );
        }
        // A flat triangle's slab has no thickness: there the crossing of its plane decides.
        if patch.rule != Rule::Flat && patch.sphere.is_none() {
            let room = like.splat(S::EPSILON * S::from_f64(RAY_EPSILONS)) * distance;
            let [zmin, zmax] = [like.splat(patch.slab[0]), like.splat(patch.slab[1])];
            keep(self.z - zmin + room, self.z_rate);
            keep(zmax - self.z + room, -self.z_rate);
        }
        self.start = lo;
        self.length = hi - lo;
        self.alive = alive & lo.at_most(hi);
    }

    /// Cuts what lies outside an interval of the ray's parameter; all where there is none.
    #[inline(always)]
    fn keep_within(&mut self, (lo, hi, exists): (V, V, V::Mask)) {
        let end = hi.lesser(self.start + self.length);
        self.start = lo.greater(self.start);
        self.length = end - self.start;
        self.alive = self.alive & exists & self.start.at_most(end);
    }

    /// The tolerance at which a root is as good as the precision allows, in the segment's parameter.
    #[inline(always)]
    pub(super) fn tolerance(&self) -> V {
        let epsilon = self.speed.splat(V::Scalar::EPSILON);
        epsilon / self.speed + epsilon * epsilon.constant(0.25) * self.start.abs()
    }

    /// The segment of one ray in every lane of a value like this one, to be looked at in several
    /// places at once.
    #[inline(always)]
    pub(super) fn in_lanes<L: Real<Scalar = V>>(&self, like: L) -> Segment<L>
    where
        V: Scalar,
    {
        let all = inlined(
            #[inline(always)]
            |of: [V; 3]| [like.splat(of[0]), like.splat(of[1]), like.splat(of[2])],
        );
        Segment {
            start: like.splat(self.start),
            length: like.splat(self.length),
            alive: like.mask(self.alive),
            stray_room: like.splat(self.stray_room),
            speed: like.splat(self.speed),
            b: all(self.b),
            b_rate: all(self.b_rate),
            z: like.splat(self.z),
            z_rate: like.splat(self.z_rate),
        }
    }

    /// What a steep surface may rise within a step of this width of the segment's parameter, in
    /// units of the patch's size.
    #[inline(always)]
    pub(super) fn steps(&self, width: V) -> V {
        width * self.speed * width.constant(STEEPEST)
    }

    /// Begins the segment anew a little beyond `at`.
    #[inline(always)]
    pub(super) fn skip_to(&mut self, at: V) {
        let at = at + self.tolerance() * at.constant(16.0);
        self.b = self.projection(at);
        self.z = self.z(at);
        self.start = self.start + at;
        self.length = self.length - at;
        self.alive = self.alive & at.constant(0.0).less(self.length);
    }

    /// Height over the plane at the segment's parameter.
    #[inline(always)]
    pub(super) fn z(&self, at: V) -> V {
        self.z + self.z_rate * at
    }

    /// Barycentric coordinates of the vertical projection at the segment's parameter.
    #[inline(always)]
    pub(super) fn projection(&self, at: V) -> [V; 3] {
        three(
            #[inline(always)]
            |i| self.b[i] + self.b_rate[i] * at,
        )
    }

    /// Where the ray crosses the triangle's plane, in the segment's parameter.
    #[inline(always)]
    pub(super) fn plane_crossing(&self) -> V {
        -(self.z / self.z_rate)
    }
}
