//! What rays meet: the meshes, the ground below them, and the light beyond.

use glam::Vec4;

use super::estimator::{LANES, Lanes};
use super::ground_plane::GroundPlane;
use super::interaction::Interaction;
use crate::embree::{Hit, QueryOptions, Ray, RayPacket};
use crate::render::light::{Lamp, LocalPointLight};
use crate::render::picture::Picture;
use crate::render::scene::Scene;

/// A scene, and how a picture of it is to be lit.
pub(super) struct World<'a> {
    pub scene: &'a Scene,
    pub picture: &'a Picture,
    pub lamp: Option<Lamp>,
    pub points: Vec<LocalPointLight>,
    ground: Option<GroundPlane>,
}

impl<'a> World<'a> {
    pub fn new(scene: &'a Scene, picture: &'a Picture) -> Self {
        let lamp = picture.lighting.lamp.as_ref();
        Self {
            scene,
            picture,
            lamp: lamp.map(|lamp| Lamp::new(lamp, scene.origin())),
            points: (picture.lighting.points.iter())
                .map(|light| LocalPointLight::new(light, scene.origin()))
                .collect(),
            ground: GroundPlane::of(picture, scene),
        }
    }

    /// What a packet of alike rays sees.
    pub fn interactions(&self, packet: &mut RayPacket<LANES>) -> Lanes<Option<Interaction>> {
        let active = packet.active();
        self.scene.tree().intersect(packet, &QueryOptions::COHERENT);
        std::array::from_fn(|lane| {
            if active & 1 << lane == 0 {
                return None;
            }
            self.nearest(&packet.ray(lane), packet.hit(lane))
        })
    }

    /// What a single ray sees.
    pub fn interaction(&self, ray: &Ray) -> Option<Interaction> {
        let hit = self.scene.tree().intersect1(ray, &QueryOptions::INCOHERENT);
        self.nearest(ray, hit)
    }

    /// How much light comes along each ray from its end to its start, by meshes and ground; 0 where
    /// there is no ray.
    pub fn passing(&self, lanes: &Lanes<Option<Ray>>, coherent: bool) -> Lanes<f32> {
        let mut packet = RayPacket::<LANES>::new();
        let mut dark = 0;
        for (lane, ray) in lanes.iter().enumerate() {
            match ray {
                Some(ray) if coherent => packet.set_ray(lane, ray),
                Some(ray) => {
                    let tree = self.scene.tree();
                    let occluded = tree.occluded1(ray, &QueryOptions::INCOHERENT);
                    dark |= u32::from(occluded) << lane;
                }
                None => {}
            }
        }
        if coherent {
            dark = self
                .scene
                .tree()
                .occluded(&mut packet, &QueryOptions::COHERENT);
        }
        std::array::from_fn(|lane| match &lanes[lane] {
            Some(ray) if dark & 1 << lane == 0 => 1.0 - self.ground_coverage(ray),
            _ => 0.0,
        })
    }

    /// What camera rays bring that see nothing: the sky where the picture is to show it.
    pub fn behind(&self, ray: &Ray) -> Vec4 {
        if self.picture.show_sky {
            self.picture
                .lighting
                .sky
                .radiance(ray.direction)
                .extend(1.0)
        } else {
            Vec4::ZERO
        }
    }

    /// How much of a ray the ground takes.
    fn ground_coverage(&self, ray: &Ray) -> f32 {
        let ground = self.ground_interaction(ray, ray.tfar);
        ground.map_or(0.0, |ground| ground.coverage)
    }

    /// What a ray sees first: a mesh or the ground.
    fn nearest(&self, ray: &Ray, hit: Option<Hit>) -> Option<Interaction> {
        let Some(hit) = hit else {
            return self.ground_interaction(ray, ray.tfar);
        };
        if let Some(ground) = self.ground_interaction(ray, hit.t) {
            return Some(ground);
        }
        let unit = self.scene.normal(&hit);
        let back = unit.dot(ray.direction) > 0.0;
        let facing = if back { -unit } else { unit };
        Some(Interaction {
            t: hit.t,
            point: ray.at(hit.t),
            error: self.scene.error_bound(&hit, ray),
            facing,
            normal: self.picture.shading.normal(self.scene, &hit, facing),
            front: !back,
            hit: Some(hit),
            coverage: 1.0,
        })
    }

    fn ground_interaction(&self, ray: &Ray, tfar: f32) -> Option<Interaction> {
        self.ground.as_ref()?.interaction(ray, tfar)
    }
}
