//! Tests of the whole wrapper against analytic spheres.

mod filters;
mod instances;
mod lifetimes;
mod meshes;
mod packets;
mod panics;
mod rays;
mod sphere;
mod triangles;
