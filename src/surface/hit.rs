//! Where a ray first meets a curved triangle.

use super::finish::{self, MAX_PARTS};
use super::ita;
use super::patch::{Patch, PatchKind, Rule};
use super::ray::{Ray, Segment};
use super::real::{Mask, Real, Scalar};

/// A hit's barycentric coordinates may lie this far outside: neighbours overlap a little.
const MAX_OUTSIDE: f64 = 9e-5;

/// How far beyond a root the search for the next one begins, in units of the patch's size.
const BEYOND: f64 = 1e-5;

/// How the root along a ray is found.
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
    Finish {
        /// Parts, 2 to 16.
        parts: u32,
    },
}

impl Default for Solver {
    fn default() -> Self {
        Solver::Finish { parts: 8 }
    }
}

/// Where a ray meets the surface first, one answer a lane.
#[derive(Clone, Copy, Debug)]
pub struct Hit<V: Real> {
    /// Whether it does; the other fields are undefined where it does not.
    pub found: V::Mask,
    /// The ray's parameter.
    pub t: V,
    /// `b2` at the guide's foot, within [-1e-4, 1 + 1e-4].
    pub u: V,
    /// `b3` at the guide's foot, within [-1e-4, 1 + 1e-4].
    pub v: V,
    /// How often the surface was evaluated.
    pub evaluations: u32,
}

impl<S: Scalar> Patch<S> {
    /// The first hit with `tnear < t <= tfar`.
    #[inline(always)]
    pub fn intersect<V: Real<Scalar = S>>(&self, ray: &Ray<V>, solver: Solver) -> Hit<V> {
        let nothing = V::constant(0.0);
        let miss = Hit {
            found: V::Mask::splat(false),
            t: nothing,
            u: nothing,
            v: nothing,
            evaluations: 0,
        };
        if self.kind() == PatchKind::Degenerate {
            return miss;
        }
        let segment = Segment::clip(self, ray);
        if !segment.alive.any() {
            return miss;
        }
        let mut evaluations = 0;
        let (at, found) = match self.rule {
            Rule::Flat => {
                let at = segment.plane_crossing();
                let inside = V::constant(0.0).at_most(at) & at.at_most(segment.length);
                (at, segment.alive & inside)
            }
            _ => self.first_root(&segment, solver, &mut evaluations),
        };
        let t = segment.start + at;
        let found = found & ray.tnear.less(t) & t.at_most(ray.tfar);
        let foot = self.foot_under(segment.projection(at), segment.z(at));
        let [u, v] = kept_inside(foot.b);
        Hit {
            found,
            t,
            u,
            v,
            evaluations,
        }
    }

    /// The least parameter at which to look for the root after the one at `t`: beyond the reach of
    /// rounding, so that the same root is not found twice.
    pub fn beyond(&self, ray: &Ray<S>, t: S) -> S {
        let way = ray.direction.length();
        let distance = (ray.origin - self.origin).length();
        let step = self.size * S::from_f64(BEYOND) + distance * S::EPSILON * S::from_f64(8.0);
        t + (step / way).greater(t.abs() * S::EPSILON * S::from_f64(2.0))
    }

    #[inline(always)]
    fn first_root<V: Real<Scalar = S>>(
        &self,
        segment: &Segment<V>,
        solver: Solver,
        evaluations: &mut u32,
    ) -> (V, V::Mask) {
        // F of equation (44): the ray's height over the plane, less the surface's over its foot.
        let f = |at: V| {
            *evaluations += 1;
            let z = segment.z(at);
            z - self.height(&self.foot_under(segment.projection(at), z))
        };
        let root = match solver {
            Solver::Ita { bits, step } => ita::first_root(f, segment.length, bits, step),
            Solver::Finish { parts } => {
                let tolerance = finish::tolerance(segment.speed, segment.start);
                let parts = (parts as usize).clamp(2, MAX_PARTS);
                finish::first_root(f, segment.length, tolerance, segment.alive, parts)
            }
        };
        (root.at, root.found & segment.alive)
    }
}

/// `b2` and `b3`, moved inside where rounding of a ray from afar put them further out than
/// neighbours overlap.
#[inline(always)]
fn kept_inside<V: Real>(b: [V; 3]) -> [V; 2] {
    let floor = V::constant(-MAX_OUTSIDE);
    let b = b.map(|b| b.greater(floor));
    let unit = V::constant(1.0) / (b[0] + b[1] + b[2]);
    [b[1] * unit, b[2] * unit]
}
