//! The lights: sun, sky, a lamp, and lights at points.

mod light_sample;
mod lighting;
mod point_light;
mod sky;
mod sphere_light;
#[cfg(test)]
mod test_numbers;

pub(super) use light_sample::LightSample;
pub use lighting::Lighting;
pub use point_light::{Cone, PointLight};
pub(super) use point_light::{LocalPointLight, draw_point_light};
pub use sky::Sky;
pub(super) use sphere_light::Lamp;
pub use sphere_light::SphereLight;
