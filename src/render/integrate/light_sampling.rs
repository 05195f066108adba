//! The light of sun, lamp and lights at points on surfaces, by rays to them.

use glam::Vec3;

use super::estimator::{LANES, Lanes};
use super::interaction::Interaction;
use super::sampler::Sample;
use super::world::World;
use crate::embree::Ray;
use crate::render::light::{LightSample, draw_point_light};
use crate::render::stats::RayCounts;

/// Radiance, for white surfaces, of the sun.
pub(super) fn sunlight(
    world: &World<'_>,
    seen: &Lanes<Option<Interaction>>,
    coherent: bool,
    rays: &mut RayCounts,
) -> Lanes<Vec3> {
    let to_sun = seen.map(|seen| seen.and_then(|seen| to_sun(world, &seen)));
    let passing = unoccluded(world, &to_sun, coherent, rays);
    std::array::from_fn(|lane| match &seen[lane] {
        Some(seen) if passing[lane] > 0.0 => passing[lane] * sun_radiance(world, seen),
        _ => Vec3::ZERO,
    })
}

/// Radiance, for white surfaces, of the lamp, by a random direction to it each.
pub(super) fn lamplight(
    world: &World<'_>,
    seen: &Lanes<Option<Interaction>>,
    numbers: &Lanes<[f32; 4]>,
    coherent: bool,
    rays: &mut RayCounts,
) -> Lanes<Vec3> {
    if world.lamp.is_none() {
        return [Vec3::ZERO; LANES];
    }
    lit_by(world, seen, coherent, rays, |lane, seen| {
        let [u, v, ..] = numbers[lane];
        to_lamp(world, seen, [u, v])
    })
}

/// Radiance, for white surfaces, of the lights at points, by a ray to one of them each; `surface`
/// is the surfaces' number on their paths.
pub(super) fn pointlight(
    world: &World<'_>,
    seen: &Lanes<Option<Interaction>>,
    samples: &Lanes<Sample>,
    surface: u32,
    rays: &mut RayCounts,
) -> Lanes<Vec3> {
    if world.points.is_empty() {
        return [Vec3::ZERO; LANES];
    }
    lit_by(world, seen, surface == 0, rays, |lane, seen| {
        let choice = match world.points.len() {
            1 => 0.0,
            _ => samples[lane].numbers(2 * surface + 1)[1],
        };
        to_point_light(world, seen, choice)
    })
}

/// Radiance, for white surfaces, of what is at the ends of rays where nothing is between.
fn lit_by(
    world: &World<'_>,
    seen: &Lanes<Option<Interaction>>,
    coherent: bool,
    rays: &mut RayCounts,
    to_light: impl Fn(usize, &Interaction) -> Option<(Ray, LightSample)>,
) -> Lanes<Vec3> {
    let to_light: Lanes<_> = std::array::from_fn(|lane| to_light(lane, seen[lane].as_ref()?));
    let passing = unoccluded(
        world,
        &to_light.map(|to| to.map(|(ray, _)| ray)),
        coherent,
        rays,
    );
    std::array::from_fn(|lane| match (&seen[lane], &to_light[lane]) {
        (Some(seen), Some((_, sample))) => {
            passing[lane] * seen.normal.dot(sample.direction) * sample.weight
        }
        _ => Vec3::ZERO,
    })
}

/// How much light comes along each ray, as [`World::passing`]; counts the rays.
pub(super) fn unoccluded(
    world: &World<'_>,
    lanes: &Lanes<Option<Ray>>,
    coherent: bool,
    rays: &mut RayCounts,
) -> Lanes<f32> {
    rays.shadow += lanes.iter().flatten().count() as u64;
    world.passing(lanes, coherent)
}

/// The ray from a surface to the sun, if that is above it.
fn to_sun(world: &World<'_>, seen: &Interaction) -> Option<Ray> {
    let towards = world.picture.lighting.towards_sun;
    (seen.normal.dot(towards) > 0.0).then(|| Ray::new(seen.start(), towards))
}

/// A ray from a surface to the lamp, if there is one above it.
fn to_lamp(world: &World<'_>, seen: &Interaction, numbers: [f32; 2]) -> Option<(Ray, LightSample)> {
    let sample = world.lamp.as_ref()?.sample(seen.start(), numbers);
    let ray = Ray::new(seen.start(), sample.direction).between(0.0, sample.distance);
    (seen.normal.dot(sample.direction) > 0.0).then_some((ray, sample))
}

/// A ray from a surface to one of the lights at points, if one shines on it.
fn to_point_light(
    world: &World<'_>,
    seen: &Interaction,
    choice: f32,
) -> Option<(Ray, LightSample)> {
    let sample = draw_point_light(&world.points, seen.start(), seen.normal, choice)?;
    let ray = Ray::new(seen.start(), sample.direction).between(0.0, sample.distance);
    Some((ray, sample))
}

/// Radiance, for a white surface, of the sun that shines on it.
fn sun_radiance(world: &World<'_>, seen: &Interaction) -> Vec3 {
    world.picture.lighting.sun * seen.normal.dot(world.picture.lighting.towards_sun)
}
