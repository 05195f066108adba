//! Light that comes straight from sun, lamp, lights at points, and sky.

use glam::{Vec3, Vec4};

use super::estimator::{Estimator, LANES, Lanes};
use super::interaction::Interaction;
use super::light_sampling::{lamplight, pointlight, sunlight, unoccluded};
use super::sampler::Sample;
use super::scattering::cosine_direction;
use super::world::World;
use crate::embree::{Ray, RayPacket};
use crate::render::stats::RayCounts;

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
        rays: &mut RayCounts,
    ) -> Lanes<Vec4> {
        rays.primary += u64::from(packet.active().count_ones());
        let active = packet.active();
        let seen = self.world.interactions(packet);
        let numbers: Lanes<[f32; 4]> = samples.map(|sample| {
            if self.world.lamp.is_some() || self.sky_shadows {
                sample.numbers(0)
            } else {
                [0.0; 4]
            }
        });
        let sun = sunlight(&self.world, &seen, true, rays);
        let lamp = lamplight(&self.world, &seen, &numbers, true, rays);
        let points = pointlight(&self.world, &seen, samples, 0, rays);
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
        seen: &Lanes<Option<Interaction>>,
        numbers: &Lanes<[f32; 4]>,
        rays: &mut RayCounts,
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
        let passing = unoccluded(&self.world, &outwards, false, rays);
        std::array::from_fn(|lane| match &outwards[lane] {
            Some(ray) => passing[lane] * sky.radiance(ray.direction),
            None => Vec3::ZERO,
        })
    }
}
