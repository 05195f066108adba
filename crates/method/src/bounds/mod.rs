//! What bounds a surface.

mod boxes;
mod clip_planes;
mod heights;
mod reach;
mod sphere;
mod unevenness;

pub(crate) use clip_planes::{OVERLAP_EPSILONS, RAY_EPSILONS};
pub(crate) use heights::{HeightNet, height_intervals};
pub use reach::DirectionalBounds;
pub(crate) use unevenness::HEIGHT;
