//! What rays meet: the meshes, the ground below them, and the light beyond.

use glam::{Vec3, Vec4};

use super::light::{Lamp, LightSample};
use super::picture::{FixedGround, Ground, Picture};
use super::point_light::{self, Point};
use super::sampler::Sample;
use super::scene::{Scene, reach, rounding};
use super::stats::Rays;
use crate::embree::{Hit, QueryOptions, Ray, RayPacket};

/// Rays traced together.
pub(super) const LANES: usize = 16;
/// Something for each lane of a packet.
pub(super) type Lanes<T> = [T; LANES];

/// A way to find the light that camera rays bring.
pub(super) trait Estimator: Sync {
    /// Traces a packet of camera rays, whose directions are of unit length, and what lights them.
    /// Gives each lane's radiance, multiplied by its coverage, and the coverage; zeros where it
    /// sees nothing. `samples` are the lanes' random numbers.
    fn trace(
        &self,
        packet: &mut RayPacket<LANES>,
        samples: &Lanes<Sample>,
        rays: &mut Rays,
    ) -> Lanes<Vec4>;
}

/// A scene, and how a picture of it is to be lit.
pub(super) struct World<'a> {
    pub scene: &'a Scene,
    pub picture: &'a Picture,
    pub lamp: Option<Lamp>,
    pub points: Vec<Point>,
    ground: Option<GroundPlane>,
}

/// An endless plane that fades away from the scene.
#[derive(Clone, Copy, Debug)]
struct GroundPlane {
    /// Upwards; unit length.
    up: Vec3,
    /// Its height along `up`.
    height: f32,
    /// Where the scene is.
    centre: Vec3,
    /// Where it begins to fade, and where it ends, in distance from the centre.
    fade: [f32; 2],
}

/// What a ray sees.
#[derive(Clone, Copy, Debug)]
pub(super) struct Seen {
    /// Where on the ray.
    pub t: f32,
    /// Its point.
    pub point: Vec3,
    /// How far off the surface a secondary ray starts: by how much the point may be wrong.
    pub off: f32,
    /// The geometry's unit normal, on the side that the ray comes from.
    pub facing: Vec3,
    /// What it is lit by: unit, on the same side.
    pub normal: Vec3,
    /// Whether the ray comes from the front, by the triangle's winding.
    pub front: bool,
    /// Its hit; the ground has none.
    pub hit: Option<Hit>,
    /// How much of what is behind it hides.
    pub coverage: f32,
}

impl Seen {
    /// The ray from here along a unit direction, to either side of the surface.
    pub fn leaving(&self, direction: Vec3) -> Ray {
        let side = if direction.dot(self.facing) < 0.0 {
            -self.facing
        } else {
            self.facing
        };
        Ray::new(self.point + self.off * side, direction)
    }

    /// Where a ray to a light starts: on the side that is seen.
    pub fn start(&self) -> Vec3 {
        self.point + self.off * self.facing
    }
}

impl<'a> World<'a> {
    pub fn new(scene: &'a Scene, picture: &'a Picture) -> Self {
        let lamp = picture.lighting.lamp.as_ref();
        Self {
            scene,
            picture,
            lamp: lamp.map(|lamp| Lamp::new(lamp, scene.origin())),
            points: (picture.lighting.points.iter())
                .map(|light| Point::new(light, scene.origin()))
                .collect(),
            ground: GroundPlane::of(picture, scene),
        }
    }

    /// What a packet of alike rays sees.
    pub fn seen_by_packet(&self, packet: &mut RayPacket<LANES>) -> Lanes<Option<Seen>> {
        let active = packet.active();
        self.scene.tree().intersect(packet, &QueryOptions::COHERENT);
        std::array::from_fn(|lane| {
            if active & 1 << lane == 0 {
                return None;
            }
            self.seen(&packet.ray(lane), packet.hit(lane))
        })
    }

    /// What a single ray sees.
    pub fn seen_by(&self, ray: &Ray) -> Option<Seen> {
        let hit = self.scene.tree().intersect1(ray, &QueryOptions::INCOHERENT);
        self.seen(ray, hit)
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

    /// The ray from a surface to the sun, if that is above it.
    pub fn to_sun(&self, seen: &Seen) -> Option<Ray> {
        let towards = self.picture.lighting.towards_sun;
        (seen.normal.dot(towards) > 0.0).then(|| Ray::new(seen.start(), towards))
    }

    /// A ray from a surface to the lamp, if there is one above it.
    pub fn to_lamp(&self, seen: &Seen, numbers: [f32; 2]) -> Option<(Ray, LightSample)> {
        let sample = self.lamp.as_ref()?.sample(seen.start(), numbers);
        let ray = Ray::new(seen.start(), sample.direction).between(0.0, sample.distance);
        (seen.normal.dot(sample.direction) > 0.0).then_some((ray, sample))
    }

    /// A ray from a surface to one of the lights at points, if one shines on it.
    pub fn to_point(&self, seen: &Seen, choice: f32) -> Option<(Ray, LightSample)> {
        let sample = point_light::drawn(&self.points, seen.start(), seen.normal, choice)?;
        let ray = Ray::new(seen.start(), sample.direction).between(0.0, sample.distance);
        Some((ray, sample))
    }

    /// Radiance, for a white surface, of the sun that shines on it.
    pub fn sun_radiance(&self, seen: &Seen) -> Vec3 {
        self.picture.lighting.sun * seen.normal.dot(self.picture.lighting.towards_sun)
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
        let seen = self.seen_ground(ray, ray.tfar);
        seen.map_or(0.0, |seen| seen.coverage)
    }

    /// What a ray sees first: a mesh or the ground.
    fn seen(&self, ray: &Ray, hit: Option<Hit>) -> Option<Seen> {
        let Some(hit) = hit else {
            return self.seen_ground(ray, ray.tfar);
        };
        if let Some(ground) = self.seen_ground(ray, hit.t) {
            return Some(ground);
        }
        let unit = self.scene.normal(&hit);
        let back = unit.dot(ray.direction) > 0.0;
        let facing = if back { -unit } else { unit };
        Some(Seen {
            t: hit.t,
            point: ray.at(hit.t),
            off: self.scene.error_bound(&hit, ray),
            facing,
            normal: self.picture.shading.normal(self.scene, &hit, facing),
            front: !back,
            hit: Some(hit),
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
        let coverage = ground.coverage(ray.at(t));
        let facing = if above > 0.0 { ground.up } else { -ground.up };
        let seen = Seen {
            t,
            point: ray.at(t),
            off: rounding(reach(ray, t).max(ground.height.abs())),
            facing,
            normal: facing,
            front: above > 0.0,
            hit: None,
            coverage,
        };
        (coverage > 0.0).then_some(seen)
    }
}

impl GroundPlane {
    fn of(picture: &Picture, scene: &Scene) -> Option<Self> {
        let (up, origin) = (picture.lighting.sky.up, scene.origin());
        let ground = match picture.ground {
            Ground::None => return None,
            Ground::Plane => FixedGround::under(scene, up),
            Ground::Fixed(ground) => ground,
        };
        let radius = ground.radius as f32;
        Some(Self {
            up,
            height: (ground.height - origin.dot(up.as_dvec3())) as f32,
            centre: (ground.centre - origin).as_vec3(),
            fade: [2.0 * radius, 12.0 * radius],
        })
    }

    fn coverage(&self, point: Vec3) -> f32 {
        let [near, far] = self.fade;
        let distance = point.distance(self.centre);
        let faded = ((distance - near) / (far - near)).clamp(0.0, 1.0);
        1.0 - faded * faded * (3.0 - 2.0 * faded)
    }
}
