//! Light that comes straight from sun, lamp, lights at points, and sky.

use glam::{Vec3, Vec4};

use super::bsdf::cosine_direction;
use super::light::LightSample;
use super::sampler::Sample;
use super::stats::Rays;
use super::world::{Estimator, LANES, Lanes, Seen, World};
use crate::embree::{Ray, RayPacket};

/// Diffuse surfaces under a sun, a lamp, lights at points and a sky, without light from other surfaces.
pub(super) struct Direct<'a> {
    pub world: World<'a>,
    /// Whether surfaces hide the sky from each other.
    pub sky_shadows: bool,
}

impl Estimator for Direct<'_> {
    fn trace(
        &self,
        packet: &mut RayPacket<LANES>,
        samples: &Lanes<Sample>,
        rays: &mut Rays,
    ) -> Lanes<Vec4> {
        rays.primary += u64::from(packet.active().count_ones());
        let active = packet.active();
        let seen = self.world.seen_by_packet(packet);
        let numbers: Lanes<[f32; 4]> = samples.map(|sample| {
            if self.world.lamp.is_some() || self.sky_shadows {
                sample.numbers(0)
            } else {
                [0.0; 4]
            }
        });
        let sun = self.world.sunlight(&seen, true, rays);
        let lamp = self.world.lamplight(&seen, &numbers, true, rays);
        let points = self.world.pointlight(&seen, samples, 0, rays);
        let sky = self.skylight(&seen, &numbers, rays);
        std::array::from_fn(|lane| match &seen[lane] {
            Some(seen) => {
                let light = sky[lane] + sun[lane] + lamp[lane] + points[lane];
                (seen.coverage * self.world.picture.albedo * light).extend(seen.coverage)
            }
            None if active & 1 << lane != 0 => self.world.behind(&packet.ray(lane)),
            None => Vec4::ZERO,
        })
    }
}

impl Direct<'_> {
    fn skylight(
        &self,
        seen: &Lanes<Option<Seen>>,
        numbers: &Lanes<[f32; 4]>,
        rays: &mut Rays,
    ) -> Lanes<Vec3> {
        let sky = &self.world.picture.lighting.sky;
        if !self.sky_shadows {
            return seen.map(|seen| seen.map_or(Vec3::ZERO, |seen| sky.on(seen.normal)));
        }
        let outwards: Lanes<Option<Ray>> = std::array::from_fn(|lane| {
            let (seen, [.., u, v]) = (seen[lane].as_ref()?, numbers[lane]);
            let ray = seen.leaving(cosine_direction(seen.normal, [u, v]));
            (ray.direction.dot(seen.facing) > 0.0).then_some(ray)
        });
        let passing = self.world.counted(&outwards, false, rays);
        std::array::from_fn(|lane| match &outwards[lane] {
            Some(ray) => passing[lane] * sky.radiance(ray.direction),
            None => Vec3::ZERO,
        })
    }
}

impl World<'_> {
    /// Radiance, for white surfaces, of the sun.
    pub(super) fn sunlight(
        &self,
        seen: &Lanes<Option<Seen>>,
        coherent: bool,
        rays: &mut Rays,
    ) -> Lanes<Vec3> {
        let to_sun = seen.map(|seen| seen.and_then(|seen| self.to_sun(&seen)));
        let passing = self.counted(&to_sun, coherent, rays);
        std::array::from_fn(|lane| match &seen[lane] {
            Some(seen) if passing[lane] > 0.0 => passing[lane] * self.sun_radiance(seen),
            _ => Vec3::ZERO,
        })
    }

    /// Radiance, for white surfaces, of the lamp, by a random direction to it each.
    pub(super) fn lamplight(
        &self,
        seen: &Lanes<Option<Seen>>,
        numbers: &Lanes<[f32; 4]>,
        coherent: bool,
        rays: &mut Rays,
    ) -> Lanes<Vec3> {
        if self.lamp.is_none() {
            return [Vec3::ZERO; LANES];
        }
        self.lit_by(seen, coherent, rays, |lane, seen| {
            let [u, v, ..] = numbers[lane];
            self.to_lamp(seen, [u, v])
        })
    }

    /// Radiance, for white surfaces, of the lights at points, by a ray to one of them each; `surface`
    /// is the surfaces' number on their paths.
    pub(super) fn pointlight(
        &self,
        seen: &Lanes<Option<Seen>>,
        samples: &Lanes<Sample>,
        surface: u32,
        rays: &mut Rays,
    ) -> Lanes<Vec3> {
        if self.points.is_empty() {
            return [Vec3::ZERO; LANES];
        }
        self.lit_by(seen, surface == 0, rays, |lane, seen| {
            let choice = match self.points.len() {
                1 => 0.0,
                _ => samples[lane].numbers(2 * surface + 1)[1],
            };
            self.to_point(seen, choice)
        })
    }

    /// Radiance, for white surfaces, of what is at the ends of rays where nothing is between.
    fn lit_by(
        &self,
        seen: &Lanes<Option<Seen>>,
        coherent: bool,
        rays: &mut Rays,
        to_light: impl Fn(usize, &Seen) -> Option<(Ray, LightSample)>,
    ) -> Lanes<Vec3> {
        let to_light: Lanes<_> = std::array::from_fn(|lane| to_light(lane, seen[lane].as_ref()?));
        let passing = self.counted(&to_light.map(|to| to.map(|(ray, _)| ray)), coherent, rays);
        std::array::from_fn(|lane| match (&seen[lane], &to_light[lane]) {
            (Some(seen), Some((_, sample))) => {
                passing[lane] * seen.normal.dot(sample.direction) * sample.weight
            }
            _ => Vec3::ZERO,
        })
    }

    /// As [`passing`](Self::passing), and counts the rays.
    pub(super) fn counted(
        &self,
        lanes: &Lanes<Option<Ray>>,
        coherent: bool,
        rays: &mut Rays,
    ) -> Lanes<f32> {
        rays.shadow += lanes.iter().flatten().count() as u64;
        self.passing(lanes, coherent)
    }
}
