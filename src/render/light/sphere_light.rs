//! A shining ball.

use std::f32::consts::{PI, TAU};

use glam::{DVec3, Vec3};

use super::light_sample::LightSample;
use crate::embree::Ray;

/// A shining ball: an area light. It casts no shadow and the camera does not see it, but mirrors and
/// glass show it, from all sides the same.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SphereLight {
    /// Its centre, in the user's space.
    pub centre: DVec3,
    /// Its radius, above 0, in the units of the meshes.
    pub radius: f64,
    /// Its radiance.
    pub radiance: Vec3,
}

/// A lamp in the scene's local space.
#[derive(Clone, Copy, Debug)]
pub(in crate::render) struct Lamp {
    centre: Vec3,
    radius: f32,
    radiance: Vec3,
}

impl Lamp {
    pub fn new(light: &SphereLight, origin: DVec3) -> Self {
        Self {
            centre: (light.centre - origin).as_vec3(),
            radius: light.radius as f32,
            radiance: light.radiance,
        }
    }

    /// A direction from a point to the lamp, all that it is seen in equally likely.
    pub fn sample(&self, point: Vec3, [u, v]: [f32; 2]) -> LightSample {
        let towards = self.centre - point;
        let distance = towards.length();
        // 1 less the cosine of the angle that the lamp's radius is seen at, without cancellation.
        let sine = self.radius / distance;
        let opening = if sine < 1.0 {
            sine * sine / (1.0 + (1.0 - sine * sine).sqrt())
        } else {
            2.0 // inside the lamp: all directions
        };
        let fall = u * opening;
        let axis = towards.try_normalize().unwrap_or(Vec3::Y);
        let (right, front) = axis.any_orthonormal_pair();
        let (sin, cos) = (TAU * v).sin_cos();
        let aside = (fall * (2.0 - fall)).max(0.0).sqrt();
        let direction = (1.0 - fall) * axis + aside * (cos * right + sin * front);
        LightSample {
            direction,
            distance: self.distance(point, direction).unwrap_or(distance),
            // The cone's solid angle is tau times its opening.
            weight: self.radiance * (TAU * opening / PI),
        }
    }

    /// What the lamp adds to a ray of unit direction that ends at `tfar`.
    pub fn emitted(&self, ray: &Ray, tfar: f32) -> Vec3 {
        match self.distance(ray.origin, ray.direction) {
            Some(t) if t < tfar => self.radiance,
            _ => Vec3::ZERO,
        }
    }

    /// Where a line forward from a point meets the lamp: where it enters, or from inside leaves it.
    fn distance(&self, point: Vec3, direction: Vec3) -> Option<f32> {
        let towards = self.centre - point;
        let along = towards.dot(direction);
        let aside = (towards - along * direction).length_squared();
        let half = self.radius * self.radius - aside;
        if half < 0.0 {
            return None;
        }
        let half = half.sqrt();
        [along - half, along + half].into_iter().find(|&t| t > 0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::super::test_numbers::{COUNT, numbers};
    use super::*;

    #[test]
    fn a_lamp_lights_a_surface_as_the_closed_form_says() {
        // A sphere wholly above the horizon: radiance times (radius / distance)^2 times the cosine.
        let lamp = Lamp {
            centre: Vec3::new(1.0, 2.0, 2.0),
            radius: 0.9,
            radiance: Vec3::new(2.0, 1.0, 0.5),
        };
        for (normal, cosine) in [
            (Vec3::Z, 2.0 / 3.0),
            (Vec3::Y, 2.0 / 3.0),
            (Vec3::X, 1.0 / 3.0),
        ] {
            let sum: Vec3 = numbers()
                .map(|[u, v, ..]| {
                    let sample = lamp.sample(Vec3::ZERO, [u, v]);
                    assert!((sample.direction.length() - 1.0).abs() < 1e-5);
                    let hit = sample.distance * sample.direction;
                    assert!((hit.distance(lamp.centre) - lamp.radius).abs() < 1e-3);
                    sample.weight * sample.direction.dot(normal)
                })
                .sum();
            let expected = lamp.radiance * (0.9_f32 / 3.0).powi(2) * cosine;
            let error = (sum / COUNT as f32 - expected).abs().max_element();
            assert!(error < 1e-4, "{error} at {normal}");
        }
    }

    #[test]
    fn a_lamp_far_away_keeps_its_solid_angle_and_one_around_a_point_shines_everywhere() {
        let lamp = |centre, radius| Lamp {
            centre,
            radius,
            radiance: Vec3::ONE,
        };
        let far = lamp(Vec3::new(0.0, 0.0, 1e4), 1.0).sample(Vec3::ZERO, [0.5; 2]);
        assert!((far.weight.x * 1e8 - 1.0).abs() < 1e-5, "{}", far.weight.x);
        let around = lamp(Vec3::X, 4.0);
        let mean: Vec3 = numbers()
            .map(|[u, v, ..]| around.sample(Vec3::ZERO, [u, v]))
            .map(|sample| sample.weight * sample.direction.z.max(0.0))
            .sum();
        assert!((mean.x / COUNT as f32 - 1.0).abs() < 1e-3, "{mean}");
        let ray = Ray::new(Vec3::ZERO, Vec3::NEG_X);
        assert_eq!(around.emitted(&ray, 3.5), Vec3::ONE);
        assert_eq!(around.emitted(&ray, 2.5), Vec3::ZERO);
    }
}
