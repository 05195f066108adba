//! What users of curved geometry need of the spherical interpolation method: its options, the patch of
//! one triangle, and its points. All of the method is in the package `curvetri-method`.
//!
//! ```
//! use curvetri::method::{Patch, PatchFlags, PatchKind, Ray, Solver, Surface, Vector};
//!
//! // A triangle of the unit sphere: positions and unit normals are the same.
//! let corners = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
//! let corners = corners.map(|[x, y, z]| Vector { x, y, z });
//! let patch: Patch<f64> = Patch::new(corners, corners, PatchFlags::new(Surface::Smooth));
//! assert_eq!(patch.kind(), PatchKind::Curved);
//!
//! let middle = patch.point(1.0 / 3.0, 1.0 / 3.0).position;
//! assert!((middle.length() - 1.0).abs() < 1e-6);
//!
//! let ray = Ray {
//!     origin: middle * 2.0,
//!     direction: -middle,
//!     tnear: 0.0,
//!     tfar: f64::INFINITY,
//! };
//! let hit = patch.intersect(&ray, Solver::default());
//! assert!(hit.found && (hit.t - 1.0).abs() < 1e-6);
//! ```

pub use curvetri_method::{
    BoundsKind, FlatReason, Hit, Patch, PatchFlags, PatchKind, Ray, Scalar, Solver, Surface,
    SurfacePoint, Vector,
};
