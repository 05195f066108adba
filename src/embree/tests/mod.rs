//! Tests of the whole wrapper against analytic spheres.

mod packets;
mod sphere;
