//! Where a ray first meets a curved triangle.

use std::cell::Cell;

use super::clip::RayInterval;
use super::hit::{Hit, Solver};
use super::paraboloid::Stretch;
use super::ray::{Ray, beyond, is_thin};
use super::root::{MAX_PARTS, Root, Samples, Steps};
use super::segment::Segment;
use super::{bracketing, ita};
use crate::numbers::{Constant, Mask, Real, Scalar, Vector, inlined};
use crate::patch::{Patch, Rule, next};

/// A hit's barycentric coordinates may lie this far outside: neighbours overlap by 3.1e-5, and a ray's own
/// rounding is added to that. Derived from what hits promise, [-1e-4, 1 + 2e-4]: with two coordinates at this
/// limit the third is 1 + 1.8e-4, which leaves a tenth for rounding.
const MAX_OUTSIDE: f64 = 9e-5;

/// How far beyond an edge a hit may lie by the ray's own rounding, in units of how far beside a guide:
/// as far as the planes that rays are clipped to, whose normals are not quite as long as is counted on.
///
/// Derived: the planes count on guides of length 2; the sum of two unit normals is at least 2 / 1.25 long while
/// they are no more than 74 degrees apart.
const BESIDE: f64 = 1.25;

/// Most roots of one ray on one patch that are looked at for the first true one from `tnear` on.
const MAX_ROOTS: u32 = 6;
/// Height of the slab, in units of the patch's size, from which on a ray is sampled twice as densely.
const HIGH_SLAB: f64 = 0.4;
/// How far from zero F may be by rounding alone: as near as a root need be found, in epsilons of the patch's
/// size. F is the difference of two numbers up to about 1, so it has no value nearer to zero than one epsilon
/// that means anything; the second is a margin.
const NOISE_EPSILONS: f64 = 2.0;

impl<S: Scalar> Patch<S> {
    /// The first hits with `tnear <= t <= tfar`: the rays are clipped, and then the surface is searched.
    #[inline(always)]
    pub(crate) fn intersect_lanes<V: Real<Scalar = S>>(
        &self,
        ray: &Ray<V>,
        solver: Solver,
    ) -> Hit<V> {
        let interval = self.clip(ray, ray.tnear.mask(true));
        self.intersect_clipped(&interval, ray, solver)
    }

    /// Where the ray can meet the surface at all, in the valid lanes.
    #[doc(hidden)]
    #[inline(always)]
    pub fn clip<V: Real<Scalar = S>>(&self, ray: &Ray<V>, valid: V::Mask) -> RayInterval<V> {
        self.clip_volume.clip(ray, valid)
    }

    /// A ray's way over the patch within an interval.
    #[doc(hidden)]
    #[inline(always)]
    pub fn segment<V: Real<Scalar = S>>(
        &self,
        ray: &Ray<V>,
        interval: &RayInterval<V>,
    ) -> Segment<V> {
        Segment::new(self, ray, interval)
    }

    /// The first hits of rays that were [clipped](Patch::clip) before; those with several crossings are searched
    /// in all lanes together.
    #[inline(always)]
    pub(crate) fn intersect_clipped<V: Real<Scalar = S>>(
        &self,
        interval: &RayInterval<V>,
        ray: &Ray<V>,
        solver: Solver,
    ) -> Hit<V> {
        self.intersect_with_search(
            interval,
            ray,
            solver,
            #[inline(always)]
            |segment| self.search_roots(segment, solver.denser(self.is_high()), &|_, _| None),
        )
    }

    /// The same with another search for the rays that may have several crossings.
    #[inline(always)]
    pub(crate) fn intersect_with_search<V: Real<Scalar = S>>(
        &self,
        interval: &RayInterval<V>,
        ray: &Ray<V>,
        solver: Solver,
        search: impl FnOnce(Segment<V>) -> Hit<V>,
    ) -> Hit<V> {
        if interval.is_empty() {
            return Hit::none(ray.tnear);
        }
        let segment = Segment::new(self, ray, interval);
        let hit = match self.rule {
            Rule::Flat => self.flat_hit(&segment),
            _ => self.curved_hit(segment, solver, search),
        };
        Hit {
            found: hit.found & hit.t.at_most(ray.tfar),
            ..hit
        }
    }

    #[inline(always)]
    fn flat_hit<V: Real<Scalar = S>>(&self, segment: &Segment<V>) -> Hit<V> {
        let (at, inside) = segment.plane_crossing();
        let b = segment.projection(at);
        let ([u, v], moved) = self.moved_inside(b, inside);
        let (mut t, mut beside) = (segment.t(at), moved);
        if is_thin(self) {
            // A ray at a grazing angle that was moved onto an edge passes it elsewhere.
            let [later, off] = segment.passing(self, [u - b[1], v - b[2]]);
            (t, beside) = (t + later, off);
        }
        let on_triangle = inside & beside.at_most(segment.stray_tolerance * at.constant(BESIDE));
        let found = on_triangle & segment.tnear.at_most(t);
        Hit {
            found,
            t,
            u,
            v,
            evaluations: 0,
        }
    }

    /// The least parameter at which to look for the root after the one at `t`: beyond the reach of
    /// rounding, so that the same root is not found twice.
    pub fn beyond(&self, ray: &Ray<S>, t: S) -> S {
        beyond(self.origin, self.size, ray, t)
    }
}

impl<S: Constant> Patch<S> {
    /// Finds the first hits of rays that may meet the surface several times.
    #[inline(always)]
    pub(crate) fn search_roots<V: Real<Scalar = S>>(
        &self,
        mut segment: Segment<V>,
        solver: Solver,
        sampler: &impl Fn(&Segment<V>, Steps<V>) -> Option<Samples<V>>,
    ) -> Hit<V> {
        let mut hit = Hit::none(segment.start);
        for _ in 0..MAX_ROOTS {
            let root = self.first_root(&segment, solver, sampler, &mut hit.evaluations);
            // Far off the surface the inverse of the guide field can jump, and F with it, past zero:
            // no root.
            let near_zero = root.value.at_most(
                segment.stray_tolerance + segment.exit_tolerance + segment.steps(root.width),
            );
            let true_root = self.verify(&segment, root.at, root.found & near_zero, &mut hit);
            hit.found = hit.found | true_root;
            segment.alive = root.found & !true_root;
            if !segment.alive.any() {
                break;
            }
            segment.skip_to(root.at);
        }
        hit
    }

    #[inline(always)]
    fn first_root<V: Real<Scalar = S>>(
        &self,
        segment: &Segment<V>,
        solver: Solver,
        sampler: &impl Fn(&Segment<V>, Steps<V>) -> Option<Samples<V>>,
        evaluations: &mut u32,
    ) -> Root<V> {
        let count = Cell::new(*evaluations);
        let f = inlined(
            #[inline(always)]
            |at: V, mask: V::Mask| {
                count.set(count.get() + mask.count());
                at.out_of_line(
                    #[inline(always)]
                    || self.clearance(segment, at),
                )
            },
        );
        let (length, alive) = (segment.length, segment.alive);
        let root = match solver {
            Solver::Ita { bits, step } => {
                let parts = 1 << step;
                let steps = inlined(
                    #[inline(always)]
                    |start: V, part: V| {
                        let few = parts <= MAX_PARTS;
                        let samples = few.then(|| sampler(segment, Steps { start, part, parts }));
                        // The ends are known.
                        let new = if few { parts as u32 - 1 } else { 0 };
                        samples.flatten().inspect(|_| count.set(count.get() + new))
                    },
                );
                ita::first_root(f, steps, length, alive, bits, step)
            }
            Solver::Bracketing { parts } => {
                let parts = (parts as usize).clamp(2, MAX_PARTS);
                let (start, share) = (length.zero(), 1.0 / parts as f64);
                let part = length * length.constant(share);
                let samples = sampler(segment, Steps { start, part, parts });
                if samples.is_some() {
                    count.set(count.get() + parts as u32 + 1);
                }
                let close = [segment.parameter_tolerance(), self.noise(segment)];
                let ends = [segment.entry_tolerance, segment.exit_tolerance];
                bracketing::first_root(f, length, close, ends, alive, parts, samples.as_ref())
            }
        };
        *evaluations = count.get();
        root
    }

    /// Whether the slab is so high that a ray may stay in it long before it meets the surface, and graze it
    /// between samples.
    #[inline(always)]
    pub(crate) fn is_high(&self) -> S::Mask {
        let height = self.slab[1] - self.slab[0];
        height.constant(HIGH_SLAB).less(height)
    }

    /// The hits of rays that are known to have a single crossing first, and of the others by a search.
    #[inline(always)]
    pub(crate) fn curved_hit<V: Real<Scalar = S>>(
        &self,
        mut segment: Segment<V>,
        solver: Solver,
        search: impl FnOnce(Segment<V>) -> Hit<V>,
    ) -> Hit<V> {
        let mut hit = Hit::none(segment.start);
        if matches!(solver, Solver::Bracketing { .. }) {
            let evaluations = Cell::new(0);
            let f = inlined(
                #[inline(always)]
                |at: V, mask: V::Mask| {
                    evaluations.set(evaluations.get() + mask.count());
                    self.clearance(&segment, at)
                },
            );
            let stretch = self.stretch(&segment, segment.alive, &f);
            let single = segment.alive & stretch.single;
            let mut left = segment.alive & !stretch.clear;
            if single.any() {
                let missed = self.single_hit(&segment, &stretch, single, &f, &mut hit);
                left = left & !hit.found & !missed;
            }
            hit.evaluations = evaluations.get();
            segment.alive = left;
        }
        if !segment.alive.any() {
            return hit;
        }
        let other = search(segment);
        Hit {
            found: hit.found | other.found,
            t: V::select(other.found, other.t, hit.t),
            u: V::select(other.found, other.u, hit.u),
            v: V::select(other.found, other.v, hit.v),
            evaluations: hit.evaluations + other.evaluations,
        }
    }

    /// Finds the hits on stretches with a single one; gives the lanes that have none for certain.
    #[inline(always)]
    fn single_hit<V: Real<Scalar = S>>(
        &self,
        segment: &Segment<V>,
        stretch: &Stretch<V>,
        single: V::Mask,
        f: &impl Fn(V, V::Mask) -> V,
        hit: &mut Hit<V>,
    ) -> V::Mask {
        let noise = self.noise(segment);
        // Not the coarser tolerance of rays from afar: the error of a doubtful slope grows with it.
        let close = [noise / segment.speed, noise];
        let crossing = stretch.crossing(segment, single, close, f);
        hit.found = self.verify(segment, crossing.at, crossing.found, hit);
        let early = segment.t(crossing.at).less(segment.tnear);
        crossing.missed | (crossing.found & early & stretch.none_later)
    }

    /// Sets the hit where a root is one: not before `tnear`, the point there on its guide, and the foot inside.
    #[inline(always)]
    fn verify<V: Real<Scalar = S>>(
        &self,
        segment: &Segment<V>,
        at: V,
        found: V::Mask,
        hit: &mut Hit<V>,
    ) -> V::Mask {
        let (above, z) = (segment.projection(at), segment.z(at));
        let foot = self.foot_under(above, z);
        let ([u, v], moved) = self.moved_inside(foot.b, found);
        let tolerance = segment.stray_tolerance;
        let on_guide = self
            .strayed2(&foot, above, z)
            .at_most(tolerance * tolerance);
        let t = segment.t(at);
        let true_root = found
            & segment.tnear.at_most(t)
            & on_guide
            & moved.at_most(tolerance * tolerance.constant(BESIDE));
        hit.t = V::select(true_root, t, hit.t);
        hit.u = V::select(true_root, u, hit.u);
        hit.v = V::select(true_root, v, hit.v);
        true_root
    }

    /// How far from zero F may be by rounding alone: as near as a root need be found.
    #[inline(always)]
    fn noise<V: Real<Scalar = S>>(&self, segment: &Segment<V>) -> V {
        segment.length.constant(S::PRECISION * NOISE_EPSILONS)
    }

    /// F of equation (44), whose roots are the hits: the ray's height over the triangle's plane less
    /// the surface's over the foot of the guide there, in units of the patch's size. `at` is the
    /// segment's parameter, the ray's less that of the segment's start.
    #[doc(hidden)]
    #[inline(always)]
    pub fn clearance<V: Real<Scalar = S>>(&self, segment: &Segment<V>, at: V) -> V {
        let z = segment.z(at);
        z - self.height(&self.foot_under(segment.projection(at), z))
    }

    /// `b2` and `b3`, moved onto the nearest edge where rounding of a ray from afar put them
    /// further out than neighbours overlap; and how far that is, in units of the patch's size. In the
    /// lanes that matter.
    // The last of three steps leaves the furthest distance unread.
    #[allow(unused_assignments)]
    #[inline(always)]
    fn moved_inside<V: Real<Scalar = S>>(&self, b: [V; 3], mask: V::Mask) -> ([V; 2], V) {
        let lanes = b[0];
        let (zero, one) = (lanes.zero(), lanes.one());
        // The first is what the other two leave: on the way of a ray from very far away all three are
        // rounded differently, and those two are what is reported.
        let b = [one - b[1] - b[2], b[1], b[2]];
        let floor = lanes.constant(-MAX_OUTSIDE);
        // What is no number at all is not inside.
        let inside = floor.at_most(b[0]) & floor.at_most(b[1]) & floor.at_most(b[2]);
        let outside = mask & !inside;
        if !outside.any() {
            return ([b[1], b[2]], zero);
        }
        let (mut u, mut v, mut furthest) = (b[1], b[2], zero);
        each!(|k| {
            let (edge, j, m) = (&self.edges[k], next(k), next(next(k)));
            let distance = b[m] * lanes.splat(edge.height);
            let further = outside & distance.less(furthest);
            let along = b[m]
                .mul_add(lanes.splat(edge.foot), b[j])
                .greater(zero)
                .lesser(one);
            let mut on_edge = [zero; 3];
            on_edge[k] = one - along;
            on_edge[j] = along;
            u = V::select(further, on_edge[1], u);
            v = V::select(further, on_edge[2], v);
            furthest = V::select(further, distance, furthest);
        });
        let [to_second, to_third] = Vector::splat_both(lanes, self.spokes);
        let moved = (to_second * (b[1] - u) + to_third * (b[2] - v)).length();
        ([u, v], moved)
    }
}
