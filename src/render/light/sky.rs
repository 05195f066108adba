//! The sky: light from all around.

use std::f32::consts::TAU;

use glam::Vec3;

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

#[cfg(test)]
mod tests {
    use super::super::lighting::Lighting;
    use super::super::test_numbers::{COUNT, numbers};
    use super::*;
    use crate::render::camera::UpAxis;
    use crate::render::integrate::cosine_direction;

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
                    let error = (sum / COUNT as f32 - sky.on(normal)).abs().max_element();
                    let tolerance = if checker == 0.0 { 1e-3 } else { 0.02 };
                    assert!(error < tolerance, "{error} at {normal}, checker {checker}");
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
}
