//! How a patch is made from a triangle's vertices: `one`, or `many` at once in SIMD lanes. `validity` says what
//! the method cannot take; `correction` makes neighbours agree along an edge, from the `edge_derivatives`.

mod correction;
mod edge_derivatives;
mod many;
mod one;
mod validity;

pub use many::BuiltPatch;
