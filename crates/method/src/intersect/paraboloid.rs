//! A paraboloid in the surface's place, and how far the surface may be from it: what is known of a ray's way
//! before the surface is evaluated anywhere.
//!
//! The paraboloid goes through the three vertices and near to the edges' curves. Its height under a ray is a
//! quadratic, so that the ray has one turn, where it goes over from coming nearer to going off, or the other
//! way round. The surface's slope is off the paraboloid's by no more than the unevenness in the packed patch, so the
//! ray's turns over the surface lie close to that one, and before and behind them it crosses the surface
//! once at the most.

use super::segment::Segment;
use crate::bounds::HEIGHT;
use crate::numbers::{Constant, Mask, Real, inlined};
use crate::patch::{Patch, next};

/// The part of a ray's way on which it may cross the surface, once, in the segment's parameter.
pub(crate) struct Stretch<V: Real> {
    /// Where this is such a part, the only one that has to be looked at first.
    pub single: V::Mask,
    /// Where the ray does not come to the surface at all. What is neither may have several crossings.
    pub clear: V::Mask,
    pub from: V,
    pub to: V,
    /// Whether there is no crossing behind the stretch either.
    pub none_later: V::Mask,
    /// Whether there is none before it.
    pub none_sooner: V::Mask,
    /// Whether the ray goes up through the surface.
    pub rising: V::Mask,
    /// Where the ray crosses the paraboloid, held within the stretch.
    pub at: V,
    /// F's slope there, taken positive.
    pub slope: V,
    /// How much it may be off.
    pub doubt: V,
    /// The greatest that F's slope may be on the stretch.
    pub greatest_slope: V,
    /// The absolute value of F's second derivative.
    pub bend: V,
}

/// A ray's way over the paraboloid, in the segment's parameter: `c0 + c1 t + c2 t^2` above it.
#[derive(Clone, Copy)]
struct Course<V: Real> {
    c0: V,
    c1: V,
    c2: V,
    /// Whether there is a turn.
    bent: V::Mask,
    /// Where.
    turn: V,
    /// One over `2 c2`, or one.
    per_twice: V,
    /// The place nearest to the turn.
    nearest: V,
    length: V,
    /// How much F's slope may be off the paraboloid's.
    doubt: V,
    /// How far the surface may be off the paraboloid at the start, at the nearest place, and at the end.
    tolerances: [V; 3],
    /// And how much further for each step away from the nearest place: none where the tolerances hold everywhere.
    drift: V,
}

/// What is known of rays with one turn.
struct Turning<V: Real> {
    /// The turn lies between these two.
    before: V,
    after: V,
    /// Where the rest holds.
    sure: V::Mask,
    /// Whether they may cross the surface before the first.
    sooner: V::Mask,
    /// Whether they may behind the second.
    later: V::Mask,
}

impl<S: Constant> Patch<S> {
    /// The height of a ray over the paraboloid: `c0 + c1 t + c2 t^2`.
    #[inline(always)]
    fn over_paraboloid<V: Real<Scalar = S>>(&self, segment: &Segment<V>) -> [V; 3] {
        let (b, rate) = (segment.b, segment.b_rate);
        let (mut c0, mut c1) = (segment.z, segment.z_rate);
        let mut c2 = c0.zero();
        each!(|k| {
            let (i, j) = (k, next(k));
            let bulge = c0.splat(self.edges[k].bulge);
            c0 = c0.less_product(bulge, b[i] * b[j]);
            c1 = c1.less_product(bulge, b[i].mul_add(rate[j], rate[i] * b[j]));
            c2 = c2.less_product(bulge, rate[i] * rate[j]);
        });
        [c0, c1, c2]
    }

    /// The course of rays over the paraboloid.
    #[inline(always)]
    fn course<V: Real<Scalar = S>>(&self, segment: &Segment<V>) -> Course<V> {
        let [c0, c1, c2] = self.over_paraboloid(segment);
        let length = segment.length;
        let (zero, one) = (length.zero(), length.one());
        let uneven = length.splat(self.unevenness);
        let tolerance = uneven.mul_add(length.constant(HEIGHT), segment.exit_tolerance);
        let twice = c2 + c2;
        let bent = zero.less(twice.abs());
        let per_twice = one / V::select(bent, twice, one);
        let turn = -(c1 * per_twice);
        Course {
            c0,
            c1,
            c2,
            bent,
            turn,
            per_twice,
            nearest: turn.greater(zero).lesser(length),
            length,
            doubt: uneven * segment.speed,
            tolerances: [tolerance; 3],
            drift: zero,
        }
    }

    /// Where rays, in some lanes, may cross the surface: as the paraboloid says, or else with one evaluation of F
    /// by a function, where they turn.
    #[inline(always)]
    pub(crate) fn stretch<V: Real<Scalar = S>>(
        &self,
        segment: &Segment<V>,
        lanes: V::Mask,
        f: &impl Fn(V, V::Mask) -> V,
    ) -> Stretch<V> {
        let course = self.course(segment);
        let stretch = course.stretch();
        let unclear = lanes & !(stretch.single | stretch.clear) & course.is_measurable();
        if !unclear.any() {
            return stretch;
        }
        let value = course.nearest.out_of_line(
            #[inline(always)]
            || f(course.nearest, unclear),
        );
        let measured = course.measured(value, segment.exit_tolerance).stretch();
        Stretch::select(unclear, measured, stretch)
    }
}

impl<V: Real> Course<V> {
    /// The height over the paraboloid.
    #[inline(always)]
    fn height(&self, at: V) -> V {
        self.c2.mul_add(at, self.c1).mul_add(at, self.c0)
    }

    /// Whether one evaluation of F may decide more.
    #[inline(always)]
    fn is_measurable(&self) -> V::Mask {
        self.doubt.less(self.doubt.constant(f64::INFINITY))
    }

    /// With the paraboloid moved to where F has this value at the nearest place: from there on the two
    /// part by no more than their slopes differ.
    #[inline(always)]
    fn measured(self, value: V, rounding: V) -> Self {
        let from_start = self.doubt.mul_add(self.nearest, rounding);
        let to_end = self.doubt.mul_add(self.length - self.nearest, rounding);
        Self {
            c0: self.c0 + (value - self.height(self.nearest)),
            tolerances: [from_start, rounding, to_end],
            drift: self.doubt,
            ..self
        }
    }

    /// What there is to say of rays with one turn, somewhere in a part of the way where they are on one side of
    /// the surface for certain.
    #[inline(always)]
    fn turning(&self, end: V) -> Turning<V> {
        let (length, doubt) = (self.length, self.doubt);
        let zero = length.zero();
        let [start_tolerance, tolerance, end_tolerance] = self.tolerances;
        let twice = self.c2 + self.c2;
        let half = doubt * self.per_twice.abs();
        let (before, after) = (self.turn - half, self.turn + half);
        let there = self.height(self.nearest);
        // Where the ray goes off to both sides of the nearest place it comes back by no more than the first
        // of these, else it gets nearer within that part by no more than the second.
        let off = zero.less(twice * there);
        let slope_there = twice.mul_add(self.nearest, self.c1).abs();
        let pull = (self.drift - slope_there).greater(zero);
        let furthest = self.nearest.greater(length - self.nearest);
        let back = (pull * self.per_twice.abs()).lesser(furthest);
        let first = back * pull.less_product(self.c2.abs(), back);
        let second = half * doubt.mul_add(length.half(), self.drift);
        let sure = (tolerance + V::select(off, first, second)).less(there.abs());
        let crossed = inlined(
            #[inline(always)]
            |height: V, tolerance: V| !(zero.less(height * there) & tolerance.less(height.abs())),
        );
        Turning {
            before,
            after,
            sure: self.bent & sure,
            sooner: !off & zero.less(before) & crossed(self.c0, start_tolerance),
            later: !off & after.less(length) & crossed(end, end_tolerance),
        }
    }

    /// Where the rays may cross the surface.
    #[inline(always)]
    fn stretch(&self) -> Stretch<V> {
        let Self { c0, c1, c2, .. } = *self;
        let (length, doubt) = (self.length, self.doubt);
        let (zero, one) = (length.zero(), length.one());
        let [start_tolerance, _, end_tolerance] = self.tolerances;
        let twice = c2 + c2;
        let end_slope = twice.mul_add(length, c1);
        let end = self.height(length);
        // One way all along.
        let even = zero.less(c1 * end_slope) & doubt.less(c1.abs()) & doubt.less(end_slope.abs());
        let separate = even
            & zero.less(c0 * end)
            & start_tolerance.less(c0.abs())
            & end_tolerance.less(end.abs());
        let turning = self.turning(end);
        let turns = turning.sure & !even;
        let sooner = turns & turning.sooner;
        let later = turns & turning.later;
        let second = later & !sooner;
        let rising =
            (even & zero.less(c1)) | (sooner & twice.less(zero)) | (second & zero.less(twice));
        let from = V::select(second, turning.after.greater(zero), zero);
        let to = V::select(sooner, turning.before.lesser(length), length);
        // Of the quadratic's two roots the one where it changes as the ray does.
        let upward = inlined(
            #[inline(always)]
            |c: V| V::select(rising, c, -c),
        );
        let [c0, c1, twice] = [upward(c0), upward(c1), upward(twice)];
        let slope = c1.mul_sub(c1, (twice + twice) * c0).greater(zero).sqrt();
        let sum = c1 + slope;
        let open = zero.less(sum);
        let at = -(c0 + c0) / V::select(open, sum, one);
        let at = V::select(open, at, from).greater(from).lesser(to);
        Stretch {
            single: (even & !separate) | sooner | second,
            clear: separate | (turns & !sooner & !later),
            from,
            to,
            none_later: even | second,
            none_sooner: even | (sooner & !later),
            rising,
            at,
            slope: twice.mul_add(at, c1).greater(doubt),
            doubt,
            greatest_slope: c1.abs().greater(end_slope.abs()) + doubt,
            bend: twice.abs(),
        }
    }
}

impl<V: Real> Stretch<V> {
    /// This one in some lanes, the other in the others.
    #[inline(always)]
    fn select(mask: V::Mask, yes: Self, no: Self) -> Self {
        let truth = inlined(
            #[inline(always)]
            |yes: V::Mask, no: V::Mask| (mask & yes) | (!mask & no),
        );
        Self {
            single: truth(yes.single, no.single),
            clear: truth(yes.clear, no.clear),
            from: V::select(mask, yes.from, no.from),
            to: V::select(mask, yes.to, no.to),
            none_later: truth(yes.none_later, no.none_later),
            none_sooner: truth(yes.none_sooner, no.none_sooner),
            rising: truth(yes.rising, no.rising),
            at: V::select(mask, yes.at, no.at),
            slope: V::select(mask, yes.slope, no.slope),
            doubt: V::select(mask, yes.doubt, no.doubt),
            greatest_slope: V::select(mask, yes.greatest_slope, no.greatest_slope),
            bend: V::select(mask, yes.bend, no.bend),
        }
    }
}
