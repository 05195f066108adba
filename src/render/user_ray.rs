//! A ray of the caller's own, and why it may not be one that can be traced.

use glam::{DVec3, Vec3};
use thiserror::Error;

use super::scene::Scene;
use super::vicinity::{NearRay, Vicinity};
use crate::embree::LEAST_COMPONENT;

/// A ray in the user's space: the points `origin + t direction` with `tnear <= t <= tfar`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UserRay {
    /// Where t = 0.
    pub origin: DVec3,
    /// Need not be of unit length: t counts in its length.
    pub direction: DVec3,
    /// Where the ray begins; less than 0 is 0.
    pub tnear: f64,
    /// Where the ray ends; may be infinite.
    pub tfar: f64,
}

/// Why a [`UserRay`] cannot be traced: it hits nothing.
#[derive(Clone, Copy, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum RayFault {
    /// A part of it is NaN.
    #[error("its {0} is not a number (NaN)")]
    NotANumber(&'static str),
    /// A component is larger than [`Scene::reach`](crate::embree::Scene::reach), or infinite. The origin's
    /// components count from the scene's origin.
    #[error(
        "its {what} has a component of {component:e}, but the largest that can be traced is {reach:e}"
    )]
    TooLarge {
        /// Origin or direction.
        what: &'static str,
        /// The component.
        component: f32,
        /// The largest that can be traced.
        reach: f32,
    },
    /// No component of the direction is as large as [`LEAST_COMPONENT`].
    #[error("its direction is zero, or has no component of {LEAST_COMPONENT:e} or more")]
    NoDirection,
    /// It ends before it begins.
    #[error("its tnear, {tnear}, is greater than its tfar, {tfar}")]
    Ends {
        /// Where it begins.
        tnear: f64,
        /// Where it ends.
        tfar: f64,
    },
}

impl UserRay {
    /// The ray in a scene's local space, moved along itself if it comes from far away. One that ends before it
    /// comes near has its end before its beginning, and hits nothing.
    ///
    /// # Errors
    /// If it cannot be traced there.
    pub(super) fn localized(&self, scene: &Scene) -> Result<NearRay, RayFault> {
        let origin = (self.origin - scene.origin()).as_vec3();
        let direction = self.direction.as_vec3();
        let reach = scene.tree().reach();
        self.check_numbers()?;
        for (what, vector) in [("origin", origin), ("direction", direction)] {
            let component = largest(vector);
            if component.abs() > reach {
                return Err(RayFault::TooLarge {
                    what,
                    component,
                    reach,
                });
            }
        }
        if largest(direction).abs() < LEAST_COMPONENT {
            return Err(RayFault::NoDirection);
        }
        let (tnear, tfar) = (self.tnear.max(0.0), self.tfar);
        if tnear > tfar {
            return Err(RayFault::Ends { tnear, tfar });
        }
        let vicinity = Vicinity::of(scene.bounds());
        let near = vicinity.localized(self.origin, self.direction, scene.origin());
        let [tnear, tfar] = [(tnear - near.shift).max(0.0), tfar - near.shift];
        Ok(NearRay {
            ray: near.ray.between(tnear as f32, tfar as f32),
            ..near
        })
    }

    fn check_numbers(&self) -> Result<(), RayFault> {
        let parts = [
            ("origin", self.origin.is_nan()),
            ("direction", self.direction.is_nan()),
            ("tnear", self.tnear.is_nan()),
            ("tfar", self.tfar.is_nan()),
        ];
        match parts.into_iter().find(|(_, is_nan)| *is_nan) {
            Some((part, _)) => Err(RayFault::NotANumber(part)),
            None => Ok(()),
        }
    }
}

/// The component of the greatest magnitude.
fn largest(vector: Vec3) -> f32 {
    let of = vector.to_array();
    of.into_iter()
        .fold(0.0, |a: f32, b| if a.abs() >= b.abs() { a } else { b })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::Mesh;
    use crate::render::Form;

    #[test]
    fn what_cannot_be_traced_is_told_and_why() {
        let device = crate::linked::device().unwrap();
        let mesh = Mesh::new(vec![DVec3::ZERO, DVec3::X, DVec3::Y], None, vec![[0, 1, 2]]);
        let scene = Scene::new(&device, vec![mesh.unwrap()], Form::Flat).unwrap();
        let ray = UserRay {
            origin: DVec3::Z,
            direction: DVec3::NEG_Z,
            tnear: 0.0,
            tfar: f64::INFINITY,
        };
        let (inf, nan) = (f64::INFINITY, f64::NAN);
        let cases = [
            (ray, None),
            (
                UserRay {
                    tnear: -1e-6,
                    ..ray
                },
                None,
            ),
            (
                UserRay {
                    tnear: -inf,
                    tfar: 0.0,
                    ..ray
                },
                None,
            ),
            (
                UserRay {
                    tnear: 2.0,
                    tfar: 2.0,
                    ..ray
                },
                None,
            ),
            (
                UserRay {
                    origin: DVec3::splat(1e18),
                    ..ray
                },
                None,
            ),
            (
                UserRay {
                    origin: DVec3::new(0.0, nan, 0.0),
                    ..ray
                },
                Some("origin is not a number"),
            ),
            (
                UserRay {
                    direction: DVec3::new(nan, 0.0, 0.0),
                    ..ray
                },
                Some("direction is not a number"),
            ),
            (UserRay { tnear: nan, ..ray }, Some("tnear is not a number")),
            (UserRay { tfar: nan, ..ray }, Some("tfar is not a number")),
            (
                UserRay {
                    origin: DVec3::new(0.0, -1e19, 0.0),
                    ..ray
                },
                Some("origin has a component of -1e19"),
            ),
            (
                UserRay {
                    origin: DVec3::new(inf, 0.0, 0.0),
                    ..ray
                },
                Some("origin has a component of inf"),
            ),
            (
                UserRay {
                    direction: DVec3::new(0.0, 1.0, 1e300),
                    ..ray
                },
                Some("direction has a component of inf"),
            ),
            (
                UserRay {
                    direction: DVec3::ZERO,
                    ..ray
                },
                Some("direction is zero"),
            ),
            (
                UserRay {
                    direction: DVec3::splat(1e-19),
                    ..ray
                },
                Some("no component of 1e-18"),
            ),
            (
                UserRay {
                    tnear: 2.0,
                    tfar: 1.0,
                    ..ray
                },
                Some("tnear, 2, is greater than its tfar, 1"),
            ),
            (UserRay { tfar: -1.0, ..ray }, Some("tnear, 0, is greater")),
        ];
        for (ray, expected) in cases {
            let fault = ray.localized(&scene).err().map(|fault| fault.to_string());
            match (&fault, expected) {
                (None, None) => {}
                (Some(fault), Some(words)) => assert!(fault.contains(words), "{fault}: {words}"),
                _ => panic!("{fault:?}, not {expected:?}: {ray:?}"),
            }
        }
        let before = UserRay {
            tnear: -1e-6,
            ..ray
        };
        assert_eq!(before.localized(&scene), ray.localized(&scene));
    }
}
