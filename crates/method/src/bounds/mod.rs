//! What bounds a surface: its `heights`, and from them `boxes`, the paper's `sphere` (3), the `clip_planes` that
//! rays are clipped to, the extent along any direction (`directional`), and how far it is from a paraboloid
//! (`unevenness`).

mod boxes;
mod clip_planes;
mod directional;
mod heights;
mod sphere;
mod unevenness;

pub(crate) use clip_planes::{OVERLAP_EPSILONS, RAY_EPSILONS};
pub use directional::DirectionalBounds;
pub(crate) use heights::{HeightNet, height_intervals};
pub(crate) use unevenness::HEIGHT;
