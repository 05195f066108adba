//! The sun, the sky, and a lamp; lights at points are in `point_light`.

use std::f32::consts::{PI, TAU};

use glam::{DVec3, Vec3};

use super::camera::UpAxis;
use super::point_light::PointLight;
use crate::embree::Ray;

/// What lights a scene.
#[derive(Clone, Debug, PartialEq)]
pub struct Lighting {
    /// Towards the sun, which is infinitely far and casts shadows; unit length.
    pub towards_sun: Vec3,
    /// The sun's irradiance on a surface that faces it, over pi: a white surface's radiance.
    pub sun: Vec3,
    /// The sky.
    pub sky: Sky,
    /// A lamp.
    pub lamp: Option<SphereLight>,
    /// Lights at points.
    pub points: Vec<PointLight>,
}

/// What shines from all around: one radiance from above the horizon and one from below it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sky {
    /// Upwards; unit length.
    pub up: Vec3,
    /// Radiance of what is above, and so of a white surface that faces straight up.
    pub above: Vec3,
    /// Radiance of what is below.
    pub below: Vec3,
    /// Contrast of a checkerboard on the sky, 0 (none) to 1: its squares, of 15 by 15 degrees of
    /// longitude and latitude, are by this share brighter and darker.
    pub checker: f32,
}

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

impl Lighting {
    /// A warm sun from the upper left and a blue sky.
    pub fn daylight(up: UpAxis) -> Self {
        let towards_sun = up.turn(DVec3::new(-0.55, 0.75, 0.6));
        Self {
            towards_sun: towards_sun.as_vec3().normalize(),
            sun: Vec3::new(0.95, 0.90, 0.80),
            sky: Sky {
                up: up.vector().as_vec3(),
                above: Vec3::new(0.24, 0.28, 0.34),
                below: Vec3::new(0.09, 0.08, 0.075),
                checker: 0.0,
            },
            lamp: None,
            points: Vec::new(),
        }
    }
}

impl Sky {
    /// The same radiance from everywhere: a furnace.
    pub fn uniform(radiance: Vec3) -> Self {
        Self {
            up: Vec3::Y,
            above: radiance,
            below: radiance,
            checker: 0.0,
        }
    }

    /// Radiance of a white surface with this unit normal of which nothing hides the sky; the
    /// checkerboard counts as its mean.
    pub fn on(&self, normal: Vec3) -> Vec3 {
        self.below.lerp(self.above, 0.5 + 0.5 * normal.dot(self.up))
    }

    /// Radiance from a direction, of unit length.
    pub fn radiance(&self, direction: Vec3) -> Vec3 {
        let height = direction.dot(self.up);
        let plain = if height >= 0.0 {
            self.above
        } else {
            self.below
        };
        if self.checker == 0.0 {
            return plain;
        }
        let (right, front) = self.up.any_orthonormal_pair();
        let longitude = direction.dot(front).atan2(direction.dot(right));
        let square = |angle: f32| (angle * (24.0 / TAU)).floor() as i32;
        let odd = (square(longitude) + square(height.clamp(-1.0, 1.0).asin())) & 1 == 1;
        plain * (1.0 + if odd { self.checker } else { -self.checker })
    }
}

/// A lamp in the scene's local space.
#[derive(Clone, Copy, Debug)]
pub(super) struct Lamp {
    centre: Vec3,
    radius: f32,
    radiance: Vec3,
}

/// A direction to a light, drawn at random.
#[derive(Clone, Copy, Debug)]
pub(super) struct LightSample {
    /// Unit.
    pub direction: Vec3,
    /// How far away the light is.
    pub distance: f32,
    /// Its radiance over the probability density of the direction, over pi (of a light at a point its
    /// irradiance over pi): times the cosine, the radiance of a white surface.
    pub weight: Vec3,
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
    use super::*;
    use crate::render::bsdf::cosine_direction;
    use crate::render::sampler::PixelSampler;

    const COUNT: u32 = 1 << 14;

    fn numbers() -> impl Iterator<Item = [f32; 4]> {
        let sampler = PixelSampler::new(3, 4, 5);
        (0..COUNT).map(move |n| sampler.sample(n).numbers(0))
    }

    #[test]
    fn the_light_of_the_sky_is_the_mean_of_what_comes_from_its_directions() {
        for up in [UpAxis::Y, UpAxis::Z] {
            for checker in [0.0, 0.5] {
                let sky = Sky {
                    checker,
                    ..Lighting::daylight(up).sky
                };
                for normal in [Vec3::Y, Vec3::NEG_Z, Vec3::new(0.6, -0.64, 0.48)] {
                    let sum: Vec3 = numbers()
                        .map(|[u, v, ..]| sky.radiance(cosine_direction(normal, [u, v])))
                        .sum();
                    let apart = (sum / COUNT as f32 - sky.on(normal)).abs().max_element();
                    let room = if checker == 0.0 { 1e-3 } else { 0.02 };
                    assert!(apart < room, "{apart} at {normal}, checker {checker}");
                }
            }
        }
    }

    #[test]
    fn a_checkered_sky_has_light_and_dark_squares() {
        let sky = Sky {
            checker: 0.25,
            ..Sky::uniform(Vec3::ONE)
        };
        let at = |longitude: f32| {
            let (right, front) = sky.up.any_orthonormal_pair();
            let (sin, cos) = longitude.to_radians().sin_cos();
            sky.radiance((cos * right + sin * front + 0.05 * sky.up).normalize())
                .x
        };
        assert_eq!([at(5.0), at(14.0)], [at(31.0), at(-20.0)]);
        let mut both = [at(5.0), at(20.0)];
        both.sort_by(f32::total_cmp);
        assert_eq!(both, [0.75, 1.25]);
    }

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
            let apart = (sum / COUNT as f32 - expected).abs().max_element();
            assert!(apart < 1e-4, "{apart} at {normal}");
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
