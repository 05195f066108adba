//! Which of a triangle's three edges, one answer a lane.

use super::cyclic::next;
use crate::numbers::{Constant, Cursor, Fields, Jet, Real, Vector, vector};

/// An edge of the triangle, one a lane.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Choice<V: Real> {
    /// Any value with the same lanes.
    pub lanes: V,
    first: V::Mask,
    second: V::Mask,
}

impl<V: Real> Choice<V> {
    /// Edge `k` is chosen where the opposite vertex's coordinate is the smallest.
    #[inline(always)]
    pub fn nearest(b: [V; 3]) -> Self {
        let lanes = b[0];
        let first = b[2].at_most(b[0]) & b[2].at_most(b[1]);
        Self {
            lanes,
            first,
            second: !first & b[0].at_most(b[1]),
        }
    }

    /// The longest edge, of these squared lengths; the earliest of equals.
    #[inline(always)]
    pub fn longest(lengths2: [V; 3]) -> Self {
        let [first, second, third] = lengths2;
        let later = first.less(second);
        let last = V::select(later, second, first).less(third);
        Self {
            lanes: first,
            first: !(last | later),
            second: later & !last,
        }
    }

    /// Edge `k` in every lane.
    #[inline(always)]
    pub fn only(lanes: V, k: usize) -> Self {
        Self {
            lanes,
            first: lanes.mask(k == 0),
            second: lanes.mask(k == 1),
        }
    }

    /// The chosen one of three values, one for each edge.
    #[inline(always)]
    pub fn pick<T: Jet<V>>(self, of: [T; 3]) -> T {
        T::select(self.first, of[0], T::select(self.second, of[1], of[2]))
    }

    /// The chosen one of three vectors, one for each edge.
    #[inline(always)]
    pub fn pick_vector(self, [a, b, c]: [Vector<V>; 3]) -> Vector<V> {
        vector(
            self.pick([a.x, b.x, c.x]),
            self.pick([a.y, b.y, c.y]),
            self.pick([a.z, b.z, c.z]),
        )
    }

    /// Values of the chosen edge's first and second vertex and of the opposite one, by vertex.
    #[inline(always)]
    pub fn placed(self, [first, second, opposite]: [V; 3]) -> [V; 3] {
        three!(|v| {
            // Vertex v is the first of edge v, the second of edge v - 1, opposite to edge v + 1.
            let before = self.is(next(next(v)));
            V::select(self.is(v), first, V::select(before, second, opposite))
        })
    }

    /// The same choice in every lane of a value like this one.
    #[inline(always)]
    pub fn in_lanes<L: Real<Scalar = V>>(self, lanes: L) -> Choice<L> {
        Choice {
            lanes,
            first: lanes.splat_mask(self.first),
            second: lanes.splat_mask(self.second),
        }
    }

    /// The chosen one of three constants.
    #[inline(always)]
    pub fn constant(self, of: impl Fn(usize) -> V::Scalar) -> V {
        self.pick(three!(|k| self.lanes.splat(of(k))))
    }

    /// The chosen one of three constants' truths.
    #[inline(always)]
    pub fn truth(self, of: impl Fn(usize) -> <V::Scalar as Real>::Mask) -> V::Mask {
        let of = three!(|k| self.lanes.splat_mask(of(k)));
        (self.first & of[0]) | (self.second & of[1]) | (self.is(2) & of[2])
    }

    /// Whether edge `k` is chosen.
    #[inline(always)]
    pub fn is(self, k: usize) -> V::Mask {
        match k {
            0 => self.first,
            1 => self.second,
            _ => !(self.first | self.second),
        }
    }
}

impl<V: Constant> Fields<V> for Choice<V> {
    const COUNT: usize = 2;

    #[inline(always)]
    fn visit(&mut self, cursor: &mut impl Cursor<V>) {
        cursor.truth(&mut self.first);
        cursor.truth(&mut self.second);
    }
}
