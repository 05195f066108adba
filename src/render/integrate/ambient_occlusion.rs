//! Ambient occlusion: how much of what is around a surface is open.

use glam::{Vec3, Vec4};

use super::estimator::{Estimator, LANES, Lanes};
use super::light_sampling::unoccluded;
use super::sampler::Sample;
use super::scattering::cosine_direction;
use super::world::World;
use crate::embree::{Ray, RayPacket};
use crate::render::stats::RayCounts;

/// White where nothing is near, by the cosine-weighted share of directions that are open.
pub(super) struct AmbientOcclusion<'a> {
    pub world: World<'a>,
    /// How far away what hides counts.
    pub distance: f32,
}

impl Estimator for AmbientOcclusion<'_> {
    fn trace(
        &self,
        packet: &mut RayPacket<LANES>,
        samples: &Lanes<Sample>,
        rays: &mut RayCounts,
    ) -> Lanes<Vec4> {
        rays.primary += u64::from(packet.active().count_ones());
        let seen = self.world.interactions(packet);
        let outwards: Lanes<Option<Ray>> = std::array::from_fn(|lane| {
            let (seen, [.., u, v]) = (seen[lane].as_ref()?, samples[lane].numbers(0));
            let ray = seen.leaving(cosine_direction(seen.normal, [u, v]));
            let ray = ray.between(0.0, self.distance);
            (ray.direction.dot(seen.facing) > 0.0).then_some(ray)
        });
        let open = unoccluded(&self.world, &outwards, false, rays);
        std::array::from_fn(|lane| {
            let coverage = seen[lane].map_or(0.0, |seen| seen.coverage);
            Vec3::splat(coverage * open[lane]).extend(coverage)
        })
    }
}
