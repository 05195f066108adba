//! All light, also by way of other surfaces: path tracing.

use glam::{Vec3, Vec4};

use super::estimator::{Estimator, LANES, Lanes};
use super::interaction::Interaction;
use super::light_sampling::{lamplight, pointlight, sunlight};
use super::sampler::Sample;
use super::scattering::{cosine_direction, dielectric};
use super::world::World;
use crate::embree::{Ray, RayPacket};
use crate::render::material::Material;
use crate::render::stats::RayCounts;

/// Follows light back from the camera over at most so many surfaces. Diffuse surfaces send rays to the
/// sun, the lamp and lights at points; rays that hit nothing find the sky. Light of the sun and of points
/// through glass is not found: no ray hits by chance what has no size.
pub(super) struct PathTracer<'a> {
    pub world: World<'a>,
    /// How many surfaces a path has at most, 1 or more.
    pub depth: u32,
}

/// The paths of a packet's lanes, all of as many surfaces.
struct Paths {
    /// The surfaces they are at; `None` where they have ended.
    seen: Lanes<Option<Interaction>>,
    /// The directions from which they came there.
    directions: Lanes<Vec3>,
    /// What a path's light counts at the camera.
    weights: Lanes<Vec3>,
    /// What was found.
    light: Lanes<Vec3>,
}

/// Where a path goes on.
#[derive(Clone, Copy)]
struct Next {
    ray: Ray,
    weight: Vec3,
    /// Whether the lamp counts if this ray hits it: no shadow ray was sent to it before.
    sees_lamp: bool,
}

impl Estimator for PathTracer<'_> {
    fn trace(
        &self,
        packet: &mut RayPacket<LANES>,
        samples: &Lanes<Sample>,
        rays: &mut RayCounts,
    ) -> Lanes<Vec4> {
        rays.primary += u64::from(packet.active().count_ones());
        let active = packet.active();
        let seen = self.world.interactions(packet);
        let mut paths = Paths {
            seen,
            directions: std::array::from_fn(|lane| packet.ray(lane).direction),
            weights: [Vec3::ONE; LANES],
            light: [Vec3::ZERO; LANES],
        };
        for surface in 0..self.depth {
            if paths.seen.iter().all(Option::is_none) {
                break;
            }
            self.light(&mut paths, samples, surface, rays);
            self.go_on(&mut paths, samples, surface, rays);
        }
        std::array::from_fn(|lane| match &seen[lane] {
            Some(seen) => (seen.coverage * paths.light[lane]).extend(seen.coverage),
            None if active & 1 << lane != 0 => self.world.behind(&packet.ray(lane)),
            None => Vec4::ZERO,
        })
    }
}

/// The random numbers at a surface: two for the lamp and two for the way on.
fn surface_numbers(samples: &Lanes<Sample>, surface: u32) -> Lanes<[f32; 4]> {
    samples.map(|sample| sample.numbers(2 * surface))
}

impl PathTracer<'_> {
    /// Adds the light that sun, lamp and lights at points throw on the surfaces that the paths are at.
    fn light(
        &self,
        paths: &mut Paths,
        samples: &Lanes<Sample>,
        surface: u32,
        rays: &mut RayCounts,
    ) {
        let diffuse = paths
            .seen
            .map(|seen| seen.filter(|seen| !self.is_glass(seen)));
        if diffuse.iter().all(Option::is_none) {
            return;
        }
        let coherent = surface == 0;
        let numbers = surface_numbers(samples, surface);
        let sun = sunlight(&self.world, &diffuse, coherent, rays);
        let lamp = lamplight(&self.world, &diffuse, &numbers, coherent, rays);
        let points = pointlight(&self.world, &diffuse, samples, surface, rays);
        for lane in 0..LANES {
            let light = sun[lane] + lamp[lane] + points[lane];
            paths.light[lane] += paths.weights[lane] * self.world.picture.albedo * light;
        }
    }

    /// Follows the paths to their next surfaces, and adds the light of those that have none.
    fn go_on(
        &self,
        paths: &mut Paths,
        samples: &Lanes<Sample>,
        surface: u32,
        rays: &mut RayCounts,
    ) {
        let numbers = surface_numbers(samples, surface);
        for lane in 0..LANES {
            let Some(seen) = paths.seen[lane].take() else {
                continue;
            };
            let [.., u, v] = numbers[lane];
            let Some(next) = self.scattered(&seen, paths.directions[lane], [u, v]) else {
                continue;
            };
            paths.weights[lane] *= next.weight;
            paths.directions[lane] = next.ray.direction;
            rays.bounce += 1;
            let choice = || samples[lane].numbers(2 * surface + 1)[0];
            let found = self.found(&next.ray, choice);
            if next.sees_lamp
                && let Some(lamp) = &self.world.lamp
            {
                let tfar = found.map_or(f32::INFINITY, |seen| seen.t);
                paths.light[lane] += paths.weights[lane] * lamp.emitted(&next.ray, tfar);
            }
            if found.is_none() {
                let sky = self.world.picture.lighting.sky.radiance(next.ray.direction);
                paths.light[lane] += paths.weights[lane] * sky;
            }
            paths.seen[lane] = found;
        }
    }

    /// What a ray hits; where the ground fades it is there by chance.
    fn found(&self, ray: &Ray, choice: impl FnOnce() -> f32) -> Option<Interaction> {
        let seen = self.world.interaction(ray)?;
        if seen.coverage < 1.0 && choice() >= seen.coverage {
            return None;
        }
        Some(seen)
    }

    fn is_glass(&self, seen: &Interaction) -> bool {
        seen.hit.is_some() && self.world.picture.material != Material::Lambert
    }

    /// Where light that comes along `direction` goes on; `None` where it is lost.
    fn scattered(&self, seen: &Interaction, direction: Vec3, [u, v]: [f32; 2]) -> Option<Next> {
        match self.world.picture.material {
            Material::Glass { index } if seen.hit.is_some() => {
                let ratio = if seen.front { 1.0 / index } else { index };
                // An interpolated normal can point away from the ray that sees the triangle.
                let [normal, facing] = [seen.normal, seen.facing];
                let normal = if normal.dot(direction) < 0.0 {
                    normal
                } else {
                    facing
                };
                let onwards = dielectric(direction, normal, ratio, u);
                let [shading, geometric] = [normal, facing].map(|normal| onwards.dot(normal) > 0.0);
                (shading == geometric).then(|| Next {
                    ray: seen.leaving(onwards),
                    weight: Vec3::ONE,
                    sees_lamp: true,
                })
            }
            _ => {
                let onwards = cosine_direction(seen.normal, [u, v]);
                (onwards.dot(seen.facing) > 0.0).then(|| Next {
                    ray: seen.leaving(onwards),
                    weight: Vec3::splat(self.world.picture.albedo),
                    sees_lamp: false,
                })
            }
        }
    }
}
