//! What else is known of a picture's pixels than their light (arbitrary output variables).

use glam::{DVec3, Vec3};
use rayon::prelude::*;

use super::estimator::LANES;
use super::interaction::Interaction;
use super::world::World;
use crate::embree::{RayPacket, flush_denormals};
use crate::render::camera::{CameraError, Lens};
use crate::render::material::Material;
use crate::render::picture::{Picture, Window};
use crate::render::ray_batch::NO_PRIMITIVE;
use crate::render::scene::Scene;

/// What the rays through the middles of a picture's pixels see: one ray a pixel, so that nothing is a
/// mean over edges. Row by row from the top, of the picture's crop.
#[derive(Clone, Debug, PartialEq)]
pub struct Aovs {
    /// Share of light that the surface reflects; 1 for glass, 0 where nothing is seen.
    pub albedo: Vec<Vec3>,
    /// The normal that the surface is lit by: unit, on the viewer's side; zero where nothing is seen.
    pub normal: Vec<Vec3>,
    /// The point that is seen, in the user's space; zero where nothing is seen.
    pub position: Vec<DVec3>,
    /// How far in front of the camera it is, along the direction that the camera looks in; infinity
    /// where nothing is seen.
    pub depth: Vec<f32>,
    /// The triangle's number in its mesh; [`NO_PRIMITIVE`] for the ground and where nothing is seen.
    pub primitive: Vec<u32>,
    /// The placement's number in the scene, which is the mesh's where each is used once;
    /// [`NO_PRIMITIVE`] as for the triangle.
    pub mesh: Vec<u32>,
}

/// Looks through the middles of a picture's pixels, on the threads of the current rayon pool.
///
/// # Errors
/// If the camera sees nothing.
///
/// # Panics
/// If the picture has no pixel, or the crop is not within it.
pub fn aovs(scene: &Scene, picture: &Picture) -> Result<Aovs, CameraError> {
    let window = picture.window();
    let lens = picture.lens(scene)?;
    let world = World::new(scene, picture);
    let seen: Vec<Option<(Interaction, f32)>> = (0..window.size[1])
        .into_par_iter()
        .flat_map_iter(|row| seen_in_row(&world, &lens, &window, row))
        .collect();
    let hit = |seen: &Option<(Interaction, f32)>| seen.and_then(|(seen, _)| seen.hit);
    let vector = |of: &dyn Fn(&Interaction) -> Vec3| {
        let values = seen
            .iter()
            .map(|seen| seen.map_or(Vec3::ZERO, |(seen, _)| of(&seen)));
        values.collect()
    };
    let position = |seen: &Option<(Interaction, f32)>| match seen {
        Some((seen, _)) => scene.origin() + seen.point.as_dvec3(),
        None => DVec3::ZERO,
    };
    Ok(Aovs {
        albedo: vector(&|seen| world.albedo(seen)),
        normal: vector(&|seen| seen.normal),
        position: seen.iter().map(position).collect(),
        depth: seen
            .iter()
            .map(|seen| seen.map_or(f32::INFINITY, |(_, depth)| depth))
            .collect(),
        primitive: seen
            .iter()
            .map(|seen| hit(seen).map_or(NO_PRIMITIVE, |hit| hit.prim_id))
            .collect(),
        mesh: seen
            .iter()
            .map(|seen| hit(seen).map_or(NO_PRIMITIVE, |hit| scene.placement_of(&hit)))
            .collect(),
    })
}

/// What a row's pixels see, and at which depth.
fn seen_in_row(
    world: &World<'_>,
    lens: &Lens,
    window: &Window,
    row: usize,
) -> Vec<Option<(Interaction, f32)>> {
    let _flush = flush_denormals();
    let mut row_seen = Vec::with_capacity(window.size[0]);
    let columns = window.corner[0]..window.corner[0] + window.size[0];
    // On the whole picture's grid, so that a crop's packets are the same.
    for first in (columns.start / LANES * LANES..columns.end).step_by(LANES) {
        let mut packet = RayPacket::<LANES>::new();
        let packet_columns = first..(first + LANES).min(window.full[0]);
        for (lane, x) in packet_columns.clone().enumerate() {
            let y = window.corner[1] + row;
            packet.set_ray(lane, &lens.ray(x as f32 + 0.5, y as f32 + 0.5));
        }
        let seen = world.interactions(&mut packet);
        for (lane, _) in packet_columns
            .enumerate()
            .filter(|(_, x)| columns.contains(x))
        {
            row_seen.push(seen[lane].map(|seen| (seen, lens.depth(seen.point))));
        }
    }
    row_seen
}

impl World<'_> {
    fn albedo(&self, seen: &Interaction) -> Vec3 {
        match self.picture.material {
            Material::Glass { .. } if seen.hit.is_some() => Vec3::ONE,
            _ => Vec3::splat(self.picture.albedo),
        }
    }
}
