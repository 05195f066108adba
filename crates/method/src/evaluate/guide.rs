//! The guide field (section 4.3) and its inverse.
//!
//! On an edge the guide lies in the plane (5) through the edge and the sum of its two normals; on
//! the medians it is the plane's normal; in between it turns along the perpendicular to the edge,
//! (26) to (28). The guide over the foot is `nc + lean w` with `w` the inward perpendicular of the
//! edge whose sub-triangle the foot lies in.

use crate::numbers::{
    Constant, Jet, Real, Vector, at_least, capped, inlined, lesser, ratio_or_zero,
};
use crate::patch::{Choice, Patch, Rule};

/// A point of the triangle's plane with the guide that stands on it.
#[derive(Clone, Copy)]
pub(crate) struct Foot<V: Real, T> {
    /// Barycentric coordinates.
    pub b: [T; 3],
    /// How far the guide leans inward over the chosen edge, for a unit of height.
    pub lean: T,
    /// The sub-triangle.
    pub choice: Choice<V>,
}

impl<S: Constant> Patch<S> {
    /// The guide over a plane point.
    #[inline(always)]
    pub(crate) fn foot_at<V: Real<Scalar = S>, T: Jet<V>>(&self, b: [T; 3]) -> Foot<V, T> {
        self.foot_in(
            b,
            Choice::nearest([b[0].value(), b[1].value(), b[2].value()]),
        )
    }

    /// The guide over a plane point of the sub-triangle of the chosen edge.
    #[inline(always)]
    pub(crate) fn foot_in<V: Real<Scalar = S>, T: Jet<V>>(
        &self,
        b: [T; 3],
        choice: Choice<V>,
    ) -> Foot<V, T> {
        let lanes = choice.lanes;
        let one = lanes.one();
        let edges = &self.edges;
        let b_i = choice.pick(b);
        let b_m = choice.pick([b[2], b[0], b[1]]);
        let b_j = choice.pick([b[1], b[2], b[0]]);
        let along = b_m.times_add(choice.constant(|k| edges[k].foot), b_j);
        let limit = self.median(along, choice);
        let ramp = if self.any_obtuse {
            T::select(choice.truth(|k| edges[k].obtuse), lesser(b_i, b_j), limit)
        } else {
            limit
        };
        // At a vertex both the point and its median are at the edge: there the guide is the edge's.
        let tiny = lanes.constant(1e-30);
        let share = ratio_or_zero(b_m, ramp, tiny);
        let lean = (-capped(share, one))
            .plus(one)
            .times(choice.constant(|k| edges[k].lean));
        Foot { b, lean, choice }
    }

    /// The foot of the guide through a point of space, given the vertical projection's barycentric
    /// coordinates and the height over the plane.
    ///
    /// The medians' guides are vertical, so the foot's sub-triangle is the projection's.
    #[inline(always)]
    pub(crate) fn foot_under<V: Real<Scalar = S>>(&self, above: [V; 3], z: V) -> Foot<V, V> {
        let (zero, one) = (z.zero(), z.one());
        let edges = &self.edges;
        let choice = Choice::<V>::nearest(above);
        if self.rule == Rule::Flat {
            return Foot {
                b: above,
                lean: zero,
                choice,
            };
        }
        let foot = choice.constant(|k| edges[k].foot);
        let above_m = choice.pick([above[2], above[0], above[1]]);
        let above_j = choice.pick([above[1], above[2], above[0]]);
        let shift = choice.constant(|k| edges[k].tilt) * z;
        let along = above_m.mul_add(foot, above_j);
        let held = along.greater(zero).lesser(one);
        let limit = self.median(held, choice);
        let gap = limit - shift;
        let open = zero.less(gap);
        let share = V::select(open, above_m - shift, zero) / V::select(open, gap, one);
        let share = share.lesser(one);
        let mut b_m = share * limit;
        let mut b_j = held.less_product(b_m, foot);
        let mut turn = one - share;
        if self.any_obtuse {
            let obtuse = choice.truth(|k| edges[k].obtuse);
            let (ramp_m, ramp_share) = ramp_under(along, foot, above_m, shift);
            b_m = V::select(obtuse, ramp_m, b_m);
            b_j = V::select(obtuse, along.less_product(ramp_m, foot), b_j);
            turn = V::select(obtuse, one - ramp_share, turn);
        }
        let b_i = one - b_j - b_m;
        Foot {
            b: choice.placed([b_i, b_j, b_m]),
            lean: turn * choice.constant(|k| edges[k].lean),
            choice,
        }
    }

    /// How far beside a foot's guide the point lies that it was found for, squared, in units of the
    /// patch's size: zero but for rounding, except where the point is so far off the surface that no guide
    /// leads there.
    #[inline(always)]
    pub(crate) fn strayed2<V: Real<Scalar = S>>(
        &self,
        foot: &Foot<V, V>,
        above: [V; 3],
        z: V,
    ) -> V {
        let choice = foot.choice;
        let out = foot.lean * z * choice.constant(|k| self.edges[k].per_height);
        let back = out * choice.constant(|k| self.edges[k].foot);
        // How the chosen edge's first, second and opposite coordinate change along the guide.
        let shift = [back - out, -back, out];
        let missed = inlined(
            #[inline(always)]
            |v: usize| {
                let roles = choice.pick([shift[v], shift[(v + 2) % 3], shift[(v + 1) % 3]]);
                above[v] - foot.b[v] - roles
            },
        );
        let [to_second, to_third] = Vector::splat_both(z, self.spokes);
        let beside = to_second.mul_add(missed(1), to_third * missed(2));
        beside.dot(beside)
    }

    /// The coordinate of the opposite vertex where the perpendicular at `along` meets the median.
    #[inline(always)]
    fn median<V: Real<Scalar = S>, T: Jet<V>>(&self, along: T, choice: Choice<V>) -> T {
        let from_first = along.times(choice.constant(|k| self.edges[k].rise[0]));
        let from_second = (-along)
            .plus(choice.lanes.one())
            .times(choice.constant(|k| self.edges[k].rise[1]));
        at_least(lesser(from_first, from_second), choice.lanes.zero())
    }
}

/// The inverse of the ramp `s = b_m / min(b_i, b_j)`: the foot's `b_m` and `s`, given the
/// projection's `b_m` and the shift `tilt z`.
///
/// On either branch the divisor is linear in `b_m`, `a0 + a1 b_m`, which leaves a quadratic; its
/// root that stays finite as `a1` vanishes is the foot.
#[inline(always)]
fn ramp_under<V: Real>(along: V, foot: V, above_m: V, shift: V) -> (V, V) {
    let (zero, one, two) = (shift.zero(), shift.one(), shift.two());
    let (excess, four) = (above_m - shift, shift.constant(4.0));
    let tiny = shift.constant(1e-30);
    let root = inlined(
        #[inline(always)]
        |a0: V, a1: V| {
            let q = a0 - a1 * excess - shift;
            let discriminant = (q * q + four * a1 * a0 * excess).greater(zero);
            let size = discriminant.sqrt();
            // One root in two forms; each cancels for the other sign of q.
            let (over, divisor) = (
                V::select(q.less(zero), size - q, two * a0 * excess),
                V::select(q.less(zero), a1 + a1, q + size),
            );
            let open = tiny.less(divisor.abs());
            V::select(open, over, zero) / V::select(open, divisor, one)
        },
    );
    let by_first = root(one - along, foot - one);
    let by_second = root(along, -foot);
    let of_first = inlined(
        #[inline(always)]
        |b: V| one - along + b * (foot - one),
    );
    let of_second = inlined(
        #[inline(always)]
        |b: V| along - b * foot,
    );
    let first = of_first(by_first).at_most(of_second(by_first));
    let b_m = V::select(first, by_first, by_second);
    let ramp = V::select(first, of_first(by_first), of_second(by_second));
    let open = tiny.less(ramp);
    let share = V::select(open, b_m, zero) / V::select(open, ramp, one);
    (V::select(one.less(share), ramp, b_m), share.lesser(one))
}
