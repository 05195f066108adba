//! The ground.

use glam::Vec3;

use super::interaction::Interaction;
use crate::embree::Ray;
use crate::render::picture::{FixedGround, GROUND_FADES, Ground, Picture};
use crate::render::rounding::{reach, rounding};
use crate::render::scene::Scene;

/// An endless plane that fades away from the scene.
#[derive(Clone, Copy, Debug)]
pub(super) struct GroundPlane {
    /// Upwards; unit length.
    up: Vec3,
    /// Its height along `up`.
    height: f32,
    /// Where the scene is.
    centre: Vec3,
    /// Where it begins to fade, and where it ends, in distance from the centre.
    fade: [f32; 2],
}

impl GroundPlane {
    pub fn of(picture: &Picture, scene: &Scene) -> Option<Self> {
        let (up, origin) = (picture.lighting.sky.up, scene.origin());
        let ground = match picture.ground {
            Ground::None => return None,
            Ground::Plane => FixedGround::under(scene, up),
            Ground::Fixed(ground) => ground,
        };
        Some(Self {
            up,
            height: (ground.height - origin.dot(up.as_dvec3())) as f32,
            centre: (ground.centre - origin).as_vec3(),
            fade: GROUND_FADES.map(|fade| (fade * ground.radius) as f32),
        })
    }

    /// The ray's point on the plane, where that is before `tfar` and not faded away.
    pub fn interaction(&self, ray: &Ray, tfar: f32) -> Option<Interaction> {
        let above = ray.origin.dot(self.up) - self.height;
        let t = -above / ray.direction.dot(self.up);
        if !(t > 0.0 && t < tfar) {
            return None;
        }
        let coverage = self.coverage(ray.at(t));
        let facing = if above > 0.0 { self.up } else { -self.up };
        let interaction = Interaction {
            t,
            point: ray.at(t),
            error: rounding(reach(ray, t).max(self.height.abs())),
            facing,
            normal: facing,
            front: above > 0.0,
            hit: None,
            coverage,
        };
        (coverage > 0.0).then_some(interaction)
    }

    /// How much of what is behind a point of the plane it hides, 0 to 1.
    fn coverage(&self, point: Vec3) -> f32 {
        let [near, far] = self.fade;
        let distance = point.distance(self.centre);
        let faded = ((distance - near) / (far - near)).clamp(0.0, 1.0);
        1.0 - faded * faded * (3.0 - 2.0 * faded)
    }
}
