//! All lights of a scene.

use glam::{DVec3, Vec3};

use super::point_light::PointLight;
use super::sky::Sky;
use super::sphere_light::SphereLight;
use crate::render::camera::UpAxis;

/// What lights a scene.
///
/// ```
/// use curvetri::render::{Cone, Lighting, PointLight, Sky, SphereLight, UpAxis};
/// use glam::{DVec3, Vec3};
///
/// let lighting = Lighting {
///     sun: Vec3::ZERO, // none
///     sky: Sky::uniform(Vec3::splat(0.1)),
///     lamp: Some(SphereLight {
///         centre: DVec3::new(0.0, 5.0, 0.0),
///         radius: 0.5,
///         radiance: Vec3::splat(20.0),
///     }),
///     points: vec![PointLight {
///         position: DVec3::new(2.0, 3.0, 0.0),
///         intensity: Vec3::ONE,
///         range: f64::INFINITY,
///         cone: Some(Cone { axis: Vec3::NEG_Y, cosines: [0.9, 0.8] }),
///     }],
///     ..Lighting::daylight(UpAxis::Y)
/// };
/// assert_eq!(lighting.sky.radiance(Vec3::X), lighting.sky.on(Vec3::Y));
/// ```
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
