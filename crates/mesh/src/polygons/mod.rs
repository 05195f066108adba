//! Polygons, cut into triangles.

mod crossing;
mod cutter;
mod faces;

pub(crate) use faces::{Attributes, Faces};
