//! Lights at a point, all around or in a cone.

use glam::{DVec3, Vec3};

use super::light_sample::LightSample;

/// A light without size: its shadows are sharp, and neither camera nor mirrors nor glass show it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PointLight {
    /// Where it is, in the user's space.
    pub position: DVec3,
    /// Its irradiance on a surface that faces it at a distance of 1, over pi: a white surface's
    /// radiance there. With the square of the distance it becomes less.
    pub intensity: Vec3,
    /// The distance at which it has faded away, above 0; infinite for one that the square of the
    /// distance alone makes less. The fading is that of glTF's `KHR_lights_punctual`:
    /// `1 - (distance / range)^4`.
    pub range: f64,
    /// The cone it shines in; all around without.
    pub cone: Option<Cone>,
}

/// A spot light's cone. Between its two angles the light is the square of a ramp of the cosine, as in
/// glTF's `KHR_lights_punctual`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cone {
    /// Where the light shines to; unit length.
    pub axis: Vec3,
    /// Cosines of the angles to the axis within which the light is full and beyond which there is
    /// none; the first is the greater.
    pub cosines: [f32; 2],
}

/// The least difference of a cone's cosines.
const LEAST_RAMP: f32 = 1e-3;

/// A light at a point in the scene's local space.
#[derive(Clone, Copy, Debug)]
pub(in crate::render) struct LocalPointLight {
    position: Vec3,
    light: PointLight,
}

impl LocalPointLight {
    pub fn new(light: &PointLight, origin: DVec3) -> Self {
        Self {
            position: (light.position - origin).as_vec3(),
            light: *light,
        }
    }

    /// What comes from the light to a point if nothing is between; `None` where that is nothing.
    pub fn sample(&self, point: Vec3) -> Option<LightSample> {
        let towards = self.position - point;
        let distance = towards.length();
        let direction = towards.try_normalize()?;
        let left = 1.0 - (distance / self.light.range as f32).powi(4);
        let in_cone = self.light.cone.map_or(1.0, |cone| cone.share(-direction));
        let share = left.max(0.0) * in_cone;
        let weight = share * self.light.intensity / distance / distance;
        let sample = LightSample {
            direction,
            distance,
            weight,
        };
        (weight.is_finite() && weight.max_element() > 0.0).then_some(sample)
    }
}

impl Cone {
    fn share(&self, direction: Vec3) -> f32 {
        let [full, none] = self.cosines;
        let ramp = (direction.dot(self.axis) - none) / (full - none).max(LEAST_RAMP);
        ramp.clamp(0.0, 1.0).powi(2)
    }
}

/// One of the lights, drawn by what it adds to a white surface of this normal if nothing is between,
/// its weight enlarged for those that are not drawn: one ray finds the mean of all. `choice` is a
/// random number, 0 to 1.
pub(in crate::render) fn draw_point_light(
    points: &[LocalPointLight],
    point: Vec3,
    normal: Vec3,
    choice: f32,
) -> Option<LightSample> {
    let lit = |light: &LocalPointLight| {
        let sample = light.sample(point)?;
        let strength = normal.dot(sample.direction) * sample.weight.element_sum();
        (strength > 0.0).then_some((sample, strength))
    };
    let lit = || points.iter().filter_map(lit);
    let total: f32 = lit().map(|(_, strength)| strength).sum();
    let mut left = choice * total;
    let mut last = None;
    for (sample, strength) in lit() {
        last = Some(LightSample {
            weight: total / strength * sample.weight,
            ..sample
        });
        left -= strength;
        if left < 0.0 {
            break;
        }
    }
    last
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(position: DVec3) -> PointLight {
        PointLight {
            position,
            intensity: Vec3::new(4.0, 2.0, 1.0),
            range: f64::INFINITY,
            cone: None,
        }
    }

    fn weight(light: PointLight, point: Vec3) -> Vec3 {
        let sample = LocalPointLight::new(&light, DVec3::ZERO).sample(point);
        sample.map_or(Vec3::ZERO, |sample| sample.weight)
    }

    #[test]
    fn light_falls_with_the_square_of_the_distance_and_ends_at_the_range() {
        let far = DVec3::new(1e6, 0.0, 0.0);
        let light = at(far + 2.0 * DVec3::Z);
        let sample = LocalPointLight::new(&light, far)
            .sample(Vec3::ZERO)
            .unwrap();
        assert_eq!((sample.direction, sample.distance), (Vec3::Z, 2.0));
        assert_eq!(sample.weight, Vec3::new(1.0, 0.5, 0.25));
        let short = |range| PointLight {
            range,
            ..at(2.0 * DVec3::Z)
        };
        assert_eq!(weight(short(4.0), Vec3::ZERO), 0.9375 * sample.weight);
        assert_eq!(weight(short(2.0), Vec3::ZERO), Vec3::ZERO);
        assert_eq!(weight(short(1.0), Vec3::ZERO), Vec3::ZERO);
        assert!(
            LocalPointLight::new(&light, light.position)
                .sample(Vec3::ZERO)
                .is_none()
        );
    }

    #[test]
    fn a_cone_is_full_within_its_first_angle_and_dark_beyond_its_second() {
        let cosines = [30_f32, 60.0].map(|angle| angle.to_radians().cos());
        let spot = PointLight {
            cone: Some(Cone {
                axis: Vec3::NEG_Z,
                cosines,
            }),
            ..at(DVec3::Z)
        };
        let share = |degrees: f32| {
            let (sin, cos) = degrees.to_radians().sin_cos();
            weight(spot, Vec3::new(sin, 0.0, 1.0 - cos)).x / 4.0
        };
        for (degrees, expected) in [(0.0, 1.0), (29.9, 1.0), (60.1, 0.0), (170.0, 0.0)] {
            assert!((share(degrees) - expected).abs() < 1e-5, "{degrees}");
        }
        let middle = ((cosines[0] + cosines[1]) / 2.0).acos().to_degrees();
        assert!((share(middle) - 0.25).abs() < 1e-4);
    }

    #[test]
    fn drawn_lights_bring_the_light_of_all() {
        let lights = [
            at(DVec3::new(0.0, 1.0, 1.0)),
            at(DVec3::new(0.0, 0.0, -1.0)),
            at(DVec3::new(3.0, 0.0, 2.0)),
        ];
        let points = lights.map(|light| LocalPointLight::new(&light, DVec3::ZERO));
        let light = |sample: LightSample| sample.direction.z * sample.weight;
        let expected: Vec3 = [0, 2]
            .map(|n| light(points[n].sample(Vec3::ZERO).unwrap()))
            .iter()
            .sum();
        let count = 1000;
        let drawn = (0..count).map(|n| {
            draw_point_light(
                &points,
                Vec3::ZERO,
                Vec3::Z,
                (n as f32 + 0.5) / count as f32,
            )
            .unwrap()
        });
        let mean = drawn.map(light).sum::<Vec3>() / count as f32;
        assert!(
            (mean - expected).abs().max_element() < 1e-4,
            "{mean}, not {expected}"
        );
        let below = draw_point_light(&points, Vec3::ZERO, Vec3::NEG_Z, 0.999).unwrap();
        assert_eq!(below.direction, Vec3::NEG_Z, "the only one on this side");
        assert!(draw_point_light(&[], Vec3::ZERO, Vec3::Z, 0.5).is_none());
    }
}
