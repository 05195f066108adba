//! How a patch is made of a triangle's vertices.

mod correction;
mod edge_derivatives;
mod many;
mod one;
mod validity;

pub use many::BuiltPatch;
