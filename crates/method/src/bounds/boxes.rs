//! Boxes of patches, from the control points that bound their heights.

use super::heights::{HeightNet, height_intervals};
use crate::numbers::{Constant, Interval, Scalar, Vector, inlined, vector};
use crate::patch::{Patch, PatchKind, Rule, next};

impl<S: Scalar> Patch<S> {
    /// A box that contains the surface, in the units and axes of the positions: lower and upper
    /// corner. Tight, or the sphere's, by [the flags](crate::PatchFlags::with_bounds).
    /// Conservative, rounding included; empty (`lower > upper`) for a degenerate triangle.
    pub(crate) fn surface_box(&self) -> [Vector<S>; 2] {
        let net = match self.rule {
            Rule::Flat => None,
            _ => Some(HeightNet::new(self, &height_intervals(self)).corrected(self)),
        };
        self.bounds_by(net.as_ref())
    }

    /// The same, of what is known of the heights unless the patch is flat.
    pub(crate) fn bounds_by(&self, net: Option<&HeightNet<S>>) -> [Vector<S>; 2] {
        if self.kind() == PatchKind::Degenerate {
            let huge = S::HUGE;
            return [huge, -huge].map(|v| Vector { x: v, y: v, z: v });
        }
        match self.sphere() {
            Some(sphere) => sphere.bounds(self),
            None => self.tight_box(net),
        }
    }
}

impl<S: Constant> Patch<S> {
    /// The least box that is known to hold the surface over heights in these ranges, or the plane
    /// triangle.
    #[inline(always)]
    pub(crate) fn tight_box(&self, net: Option<&HeightNet<S>>) -> [Vector<S>; 2] {
        let x = self.axis_range(
            net,
            #[inline(always)]
            |v| v.x,
        );
        let y = self.axis_range(
            net,
            #[inline(always)]
            |v| v.y,
        );
        let z = self.axis_range(
            net,
            #[inline(always)]
            |v| v.z,
        );
        [vector(x.lo, y.lo, z.lo), vector(x.hi, y.hi, z.hi)]
    }

    /// The range of one coordinate over the surface.
    #[inline(always)]
    fn axis_range(
        &self,
        net: Option<&HeightNet<S>>,
        of: impl Fn(Vector<S>) -> S + Copy,
    ) -> Interval<S> {
        let zero = self.area2.zero();
        let points = [zero, of(self.spokes[0]), of(self.spokes[1])];
        let mut hull = Interval::between(points[1], points[2]).hull(Interval::of(zero));
        if let Some(net) = net {
            let guide = self.guide_range(of);
            let third = zero.constant(1.0 / 3.0);
            each!(|k| {
                let (p, q) = (points[k], points[next(k)]);
                let near = [(p + p + q) * third, (p + q + q) * third];
                for end in 0..2 {
                    let out = net.edges[k][end].times(guide);
                    hull = hull.hull(out.plus(Interval::of(near[end])));
                }
            });
            let centre = (points[1] + points[2]) * third;
            hull = hull.hull(net.centre.times(guide).plus(Interval::of(centre)));
        }
        self.in_space(hull, of)
    }

    /// A range of one coordinate inside the patch as one of the positions' coordinate, widened by
    /// what rounding moves: inside, and in adding the origin again.
    #[inline(always)]
    pub(crate) fn in_space(&self, hull: Interval<S>, of: impl Fn(Vector<S>) -> S) -> Interval<S> {
        let epsilons = inlined(
            #[inline(always)]
            |count: f64| hull.lo.constant(count * S::PRECISION),
        );
        let hull = hull.widened(epsilons(32.0) + hull.max_abs() * epsilons(8.0));
        let origin = of(self.origin);
        let outside = (origin.abs() + hull.max_abs() * self.size) * epsilons(4.0);
        Interval {
            lo: hull.lo * self.size + origin,
            hi: hull.hi * self.size + origin,
        }
        .widened(outside)
    }

    /// The range of one coordinate of the guide vectors.
    #[inline(always)]
    fn guide_range(&self, of: impl Fn(Vector<S>) -> S) -> Interval<S> {
        let upright = of(self.normal);
        let mut guide = Interval::of(upright);
        each!(|k| {
            let edge = &self.edges[k];
            let inward = of(self.gradients[next(next(k))]) * edge.height;
            guide = guide.hull(Interval::of(upright + edge.lean * inward));
        });
        guide
    }
}
