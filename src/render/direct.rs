//! Shading by the sun, with shadows, and the sky.

use glam::{Vec3, Vec4};

use super::light::Lighting;
use super::scene::{Scene, reach, rounding};
use super::shading::Shading;
use super::stats::Rays;
use crate::embree::{QueryOptions, Ray, RayPacket};

/// Rays traced together.
pub(super) const LANES: usize = 16;

/// An endless plane that fades away from the scene.
#[derive(Clone, Copy, Debug)]
pub(super) struct GroundPlane {
    /// Upwards; unit length.
    pub up: Vec3,
    /// Its height along `up`.
    pub height: f32,
    /// Where the scene is.
    pub centre: Vec3,
    /// Where it begins to fade, and where it ends, in distance from the centre.
    pub fade: [f32; 2],
}

/// What a ray sees, before it is lit.
#[derive(Clone, Copy)]
struct Seen {
    /// Where a secondary ray starts: off the surface by its error.
    start: Vec3,
    /// What it is lit by: unit, on the viewer's side of the surface.
    normal: Vec3,
    /// How much of the background it hides.
    coverage: f32,
}

/// Diffuse surfaces under a sun and a sky.
pub(super) struct Direct<'a> {
    pub scene: &'a Scene,
    pub lighting: &'a Lighting,
    /// Share of light that surfaces reflect.
    pub albedo: f32,
    pub shading: Shading,
    pub ground: Option<GroundPlane>,
}

impl Direct<'_> {
    /// Traces a packet of camera rays, whose directions are of unit length, and what lights them.
    /// Gives each lane's radiance, multiplied by its coverage, and the coverage; zeros where it
    /// sees nothing.
    pub fn trace(&self, packet: &mut RayPacket<LANES>, rays: &mut Rays) -> [Vec4; LANES] {
        let active = packet.active();
        self.scene.tree().intersect(packet, &QueryOptions::COHERENT);
        let seen: [Option<Seen>; LANES] = std::array::from_fn(|lane| {
            if active & 1 << lane != 0 {
                self.seen(packet, lane)
            } else {
                None
            }
        });
        let mut shadows = RayPacket::<LANES>::new();
        for (lane, seen) in seen.iter().enumerate() {
            if let Some(seen) = seen.filter(|seen| self.towards_sun(seen) > 0.0) {
                shadows.set_ray(lane, &Ray::new(seen.start, self.lighting.towards_sun));
            }
        }
        rays.primary += u64::from(active.count_ones());
        rays.shadow += u64::from(shadows.active().count_ones());
        let sunlit = shadows.active();
        let dark = self
            .scene
            .tree()
            .occluded(&mut shadows, &QueryOptions::COHERENT);
        let sunlit = sunlit & !dark;
        std::array::from_fn(|lane| match &seen[lane] {
            Some(seen) => self.lit(seen, sunlit & 1 << lane != 0),
            None => Vec4::ZERO,
        })
    }

    fn towards_sun(&self, seen: &Seen) -> f32 {
        seen.normal.dot(self.lighting.towards_sun)
    }

    fn lit(&self, seen: &Seen, sunlit: bool) -> Vec4 {
        let sky = self.lighting.sky.on(seen.normal);
        let sun = if sunlit {
            self.lighting.sun * self.towards_sun(seen)
        } else {
            Vec3::ZERO
        };
        (seen.coverage * self.albedo * (sky + sun)).extend(seen.coverage)
    }

    /// What a lane's ray sees first: a mesh or the ground.
    fn seen(&self, packet: &RayPacket<LANES>, lane: usize) -> Option<Seen> {
        let ray = packet.ray(lane);
        let Some(hit) = packet.hit(lane) else {
            return self.seen_ground(&ray, f32::INFINITY);
        };
        if let Some(ground) = self.seen_ground(&ray, hit.t) {
            return Some(ground);
        }
        let unit = hit.ng.normalize_or_zero();
        let facing = if unit.dot(ray.direction) > 0.0 {
            -unit
        } else {
            unit
        };
        Some(Seen {
            start: self.scene.leaving_point(&hit, &ray, facing),
            normal: self.shading.normal(self.scene, &hit, facing),
            coverage: 1.0,
        })
    }

    /// The ground, where it is before `tfar` and not faded away.
    fn seen_ground(&self, ray: &Ray, tfar: f32) -> Option<Seen> {
        let ground = self.ground.as_ref()?;
        let above = ray.origin.dot(ground.up) - ground.height;
        let t = -above / ray.direction.dot(ground.up);
        if !(t > 0.0 && t < tfar) {
            return None;
        }
        let [near, far] = ground.fade;
        let distance = ray.at(t).distance(ground.centre);
        let faded = ((distance - near) / (far - near)).clamp(0.0, 1.0);
        let coverage = 1.0 - faded * faded * (3.0 - 2.0 * faded);
        let normal = if above > 0.0 { ground.up } else { -ground.up };
        let off = rounding(reach(ray, t).max(ground.height.abs()));
        let seen = Seen {
            start: ray.at(t) + off * normal,
            normal,
            coverage,
        };
        (coverage > 0.0).then_some(seen)
    }
}
