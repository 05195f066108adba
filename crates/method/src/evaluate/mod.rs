//! The surface at a place: guide, height and point.

mod guide;
mod height;
mod point;

pub(crate) use height::{Curvature, MIN_DAMPING_FACTOR};
pub use point::SurfacePoint;
