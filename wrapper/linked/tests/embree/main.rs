//! The wrapper over the linked Embree, against analytic spheres.

mod filters;
mod instances;
mod lifetimes;
mod meshes;
mod packets;
mod panics;
mod rays;
mod sphere;
mod triangles;
