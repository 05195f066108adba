//! The spherical interpolation method: pure maths of one curved triangle, without Embree.
//!
//! Source: Gusiatin, Gusiatin, Mikhal, "Ray tracing synthesis of images of triangulated surfaces
//! smoothed by the spherical interpolation method", 2018, doi 10.15587/1729-4061.2018.145531;
//! equation and section numbers in this package are the paper's. A surface point over the plane point
//! `rp` is `r = rp + g h` (1). The guide vector `g` is scaled so that its part along the plane's normal
//! is 1, and `h` is the mean of the guide's parameters on the spheres of the three vertices (33).
//!
//! The folders, from the bottom up; each imports only from those above it in this list:
//! - `numbers`: scalars, SIMD lanes, vectors, derivatives and intervals. The kernel is written once over
//!   them: `f64` is the oracle for `f32`, and tangents come from the same source by dual numbers;
//! - `patch`: what is known of one triangle, data alone: vertices, frame, edges, flags, kinds;
//! - `evaluate`: the guide field (section 4.3), the height (33), and points with tangents and normals;
//! - `bounds`: heights, boxes, the sphere (3), the planes that a ray is clipped to;
//! - `store`: the packed form of a triangle, and blocks of unpacked ones side by side in columns;
//! - `build`: a patch from three vertices: the checks, the correction, one triangle or many at once. It
//!   imports `store`, because a patch is rounded to its packed form before anything is derived from it;
//! - `intersect`: rays: the clip, the segment, the roots of F (44), single rays, packets and pairs.

// Edges and vertices are named by their index, in formulas that are cyclic in it.
#![allow(clippy::needless_range_loop)]
// `!(a < b)` where a NaN has to fail the test.
#![allow(clippy::neg_cmp_op_on_partial_ord)]
// The product rule.
#![allow(clippy::suspicious_arithmetic_impl)]

#[macro_use]
mod numbers;

mod bounds;
mod build;
mod evaluate;
mod intersect;
mod patch;
mod store;

#[cfg(test)]
mod packet_tests;
#[cfg(test)]
mod tests;

pub use build::BuiltPatch;
pub use evaluate::SurfacePoint;
pub use intersect::{Hit, HitLanes, PairHit, PairHits, Precision, Ray, RayLanes, Solver};
pub use numbers::{MAX_LANES, PATCHES, Vector, vector};
pub use patch::{
    BoundsKind, FlatReason, Patch, PatchFlags, PatchKind, Sphere, Surface, TriangleVertices,
};
pub use store::{PackedPatch, PackedTriangle, PatchBlock};

// For the curved geometry of this workspace: no part of the interface that others can rely on.
#[doc(hidden)]
pub use bounds::DirectionalBounds;
#[doc(hidden)]
pub use numbers::{
    Lanes, PatchMask, Patches, Quad, Real, Scalar, SetBits, inlined, load_lanes, set_bits, three,
};
#[doc(hidden)]
pub use store::in_columns;
