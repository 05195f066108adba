//! How a ray's root is found, and what comes of it.

use crate::numbers::{Mask, Real, Scalar};

/// How the root along a ray is found.
///
/// ```
/// use curvetri_method::Solver;
///
/// assert_eq!(Solver::default(), Solver::Bracketing { parts: 8 });
/// assert_eq!(Solver::ITA, Solver::Ita { bits: 24, step: 3 });
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Solver {
    /// The paper's iterative algorithm: `bits` binary digits, `step` at a time (n and n1).
    Ita {
        /// Binary digits of the root.
        bits: u32,
        /// Digits a step; each step takes `2^step - 1` evaluations.
        step: u32,
    },
    /// Sampling in `parts` equal parts, then a superlinear bracketing method.
    Bracketing {
        /// Parts, 2 to 16.
        parts: u32,
    },
}

impl Solver {
    /// The paper's iterative algorithm with all the digits that single precision has (n = 24), and
    /// the fewest a step that miss no root in practice (n1 = 3).
    pub const ITA: Solver = Solver::Ita { bits: 24, step: 3 };
}

impl Solver {
    /// The same with twice the parts, if so.
    #[inline(always)]
    pub(crate) fn denser(self, twice: bool) -> Self {
        match self {
            Solver::Bracketing { parts } if twice => Solver::Bracketing { parts: 2 * parts },
            _ => self,
        }
    }
}

impl Default for Solver {
    fn default() -> Self {
        Solver::Bracketing { parts: 8 }
    }
}

/// Where a ray meets the surface first, one answer a lane.
#[derive(Clone, Copy, Debug)]
pub struct Hit<V: Real> {
    /// Whether it does; the other fields are undefined where it does not.
    pub found: V::Mask,
    /// The ray's parameter.
    pub t: V,
    /// `b2` at the guide's foot, within [-1e-4, 1 + 2e-4].
    pub u: V,
    /// `b3` at the guide's foot, within [-1e-4, 1 + 2e-4].
    pub v: V,
    /// How often the surface was evaluated, the sum over the lanes.
    pub evaluations: u32,
}

impl<V: Real> Hit<V> {
    /// No hit, in as many lanes as `like` has.
    #[inline(always)]
    pub(crate) fn none(lanes: V) -> Self {
        let zero = lanes.zero();
        Self {
            found: lanes.mask(false),
            t: zero,
            u: zero,
            v: zero,
            evaluations: 0,
        }
    }
}

impl<S: Scalar> Hit<S> {
    /// The same hit in all lanes of a value like this one.
    #[inline(always)]
    pub(crate) fn in_lanes<V: Real<Scalar = S>>(&self, lanes: V) -> Hit<V> {
        let found = lanes.mask(self.found);
        Hit {
            found,
            t: lanes.splat(self.t),
            u: lanes.splat(self.u),
            v: lanes.splat(self.v),
            evaluations: self.evaluations * lanes.mask(true).count(),
        }
    }
}
