//! The spherical interpolation method: pure maths of one curved triangle, no Embree.
//!
//! Source: Gusiatin, Gusiatin, Mikhal, "Ray tracing synthesis of images of triangulated surfaces
//! smoothed by the spherical interpolation method", 2018, doi 10.15587/1729-4061.2018.145531;
//! equation numbers in this room are the paper's. A surface point over the plane point `rp` is
//! `r = rp + g h` (1), with the guide vector `g` scaled so that its part along the plane's normal
//! is 1, and `h` the mean of the guide's parameters on the spheres of the three vertices (33).
//!
//! Everything is written once over [`Scalar`], [`Real`] and [`Jet`]: `f64` is the oracle for
//! `f32`, and tangents come from the same source by [`Dual`] numbers.

// Sides and vertices are named by their index, in formulas that are cyclic in it.
#![allow(clippy::needless_range_loop)]
// `!(a < b)` where a NaN has to fail the test.
#![allow(clippy::neg_cmp_op_on_partial_ord)]
// The product rule.
#![allow(clippy::suspicious_arithmetic_impl)]

mod block;
mod bounds;
mod boxes;
mod choice;
mod columns;
mod correction;
mod crossing;
mod dual;
mod finish;
mod flags;
mod folds;
mod frame;
mod guide;
mod height;
mod hit;
mod hull;
mod ita;
mod kept;
mod lanes;
mod outline;
mod packet;
mod pair_lanes;
mod pairs;
mod paraboloid;
mod patch;
mod point;
mod prepare;
mod range;
mod ray;
mod reach;
mod real;
mod record;
mod rim;
mod sides;
mod single;
mod sphere;
mod vector;

#[cfg(test)]
mod packet_tests;
#[cfg(test)]
mod tests;

pub use block::PatchBlock;
pub use columns::in_columns;
pub use dual::Dual;
pub use finish::MAX_PARTS;
pub use flags::{BoundsKind, PatchFlags, Surface};
pub use hit::{Hit, Solver};
pub use hull::Interval;
pub use kept::{Corners, KeptPatch};
pub use lanes::{Lanes, PATCHES, PatchMask, Patches, Quad};
pub use outline::Outline;
pub use packet::load_lanes;
pub use packet::{HitLanes, MAX_LANES, RayLanes};
pub use pairs::{PairHit, PairHits};
pub use patch::{FlatReason, Patch, PatchKind};
pub use point::SurfacePoint;
pub use prepare::Prepared;
pub use ray::{Ray, Segment};
pub use reach::Reach;
pub use real::{Constant, Jet, Mask, Real, Scalar};
pub use real::{inlined, three};
pub use record::PatchRecord;
pub use sphere::Sphere;
pub use vector::{Vector, vector};
