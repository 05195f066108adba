//! What the method promises of whole meshes: hits lie on the surface, closed bodies stay closed, neighbours
//! agree, boxes hold the surface.

mod boxes;
mod cad;
mod paper;
mod residual;
mod smoothness;
mod watertight;
mod watertight_moved;
