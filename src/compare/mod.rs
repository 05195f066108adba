//! How far what one form of a surface shows is from what another one shows, through the same camera.
//!
//! A [`View`] is what a [`Scene`](crate::render::Scene) shows: its picture, its [`Outline`], and a
//! [`Probe`] of the surface through the middles of the pixels. [`View::apart_from`] sets two of them
//! beside each other: pictures by [`rmse`] and [`flip`], outlines in pixels, normals in degrees, and
//! the lit pixels that one of them darkens.

mod normals;
mod outline;
mod pictures;
mod probe;
mod spread;
mod terminator;
mod view;

pub use normals::{geometric_angles, shading_angles};
pub use outline::Outline;
pub use pictures::{Flip, flip, rmse};
pub use probe::{Probe, Seen, Sun};
pub use spread::Spread;
pub use terminator::{Darkened, darkened, marked};
pub use view::{Apart, View};
