//! How far what one form of a surface shows is from what another one shows, through the same camera.
//!
//! A [`View`] is what a [`Scene`](crate::render::Scene) shows: its picture, its [`Outline`], and a
//! [`Probe`] of the surface through the middles of the pixels. [`View::difference_from`] sets two of them
//! beside each other: pictures by [`rmse`] and [`flip`], outlines in pixels, normals in degrees, and
//! the lit pixels that one of them darkens.
//!
//! ```
//! use curvetri::compare::{Difference, View, marked};
//! use curvetri::curved::CurvedOptions;
//! use curvetri::mesh::Mesh;
//! use curvetri::render::{Background, Form, Framing, Picture, Scene, UpAxis, render};
//! use glam::DVec3;
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let corners = vec![DVec3::X, DVec3::Y, DVec3::Z];
//! let mesh = Mesh::new(corners.clone(), Some(corners), vec![[0, 1, 2]])?;
//! let device = curvetri::linked::device()?;
//! let framing = Framing { up: UpAxis::Y, fov_degrees: Some(35.0), aspect: 1.0, shadows_of: None };
//! let view = |form| -> Result<View, Box<dyn std::error::Error>> {
//!     let scene = Scene::new(&device, vec![mesh.clone()], form)?;
//!     let picture = Picture::new(64, 64, framing.camera(&scene), UpAxis::Y);
//!     let (film, _) = render(&scene, &picture, &|_, _| ())?;
//!     Ok(View::new(&scene, &picture, film.to_rgb8(Background::default(), 0.0))?)
//! };
//! let (flat, curved) = (view(Form::Flat)?, view(Form::Curved(CurvedOptions::default()))?);
//! let difference: Difference = flat.difference_from(&curved);
//! assert!(difference.flip > 0.0 && difference.outline.is_some_and(|outline| outline.max > 0.1));
//! let darkened = marked(&flat.image, &flat.probe, &curved.probe);
//! assert_eq!(darkened.dimensions(), (64, 64));
//! # Ok(())
//! # }
//! ```

mod normals;
mod outline;
mod pictures;
mod probe;
mod summary;
mod terminator;
mod view;

pub use outline::Outline;
pub use pictures::{Flip, flip, rmse};
pub use probe::{Probe, ProbedSurface, Sun};
pub use summary::Summary;
pub use terminator::{Darkened, darkened, marked};
pub use view::{Difference, View};
