//! The surface at a place: the `guide` (section 4.3), the `height` along it (33), and the `point` with its
//! tangents and normal.

mod guide;
mod height;
mod point;

pub(crate) use height::{Curvature, MIN_DAMPING_FACTOR};
pub use point::SurfacePoint;
