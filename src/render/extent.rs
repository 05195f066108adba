//! How far scenes reach: over all uses of their meshes, with a look at those only that may decide.

use std::collections::HashMap;

use glam::{DVec3, Vec3};
use rayon::prelude::*;

use super::placed_shape::{Instance, PlacedShape};
use super::scene::Scene;
use super::shape::Shape;
use crate::curved::CurvedMesh;
use crate::mesh::Bounds;
use curvetri_method::PatchKind;

/// The corners of a box of an instance's shape, in the scene's space.
pub(super) fn placed_corners(instance: &Instance, [lower, upper]: [Vec3; 2]) -> [Vec3; 8] {
    let bounds = Bounds {
        min: lower.as_dvec3(),
        max: upper.as_dvec3(),
    };
    let place = |p: DVec3| instance.to_scene.transform_point3(p.as_vec3());
    bounds.corners().map(place)
}

impl Scene {
    /// The height of the lowest point of the surface along `up` (a unit vector), in the local space.
    ///
    /// Of a curved triangle only the vertices and a grid of points are looked at.
    pub fn lowest(&self, up: Vec3) -> f32 {
        let mut known = HashMap::new();
        let places = self.outermost_first();
        places.fold(f32::INFINITY, |least, (number, place)| {
            self.lowest_at(number, place, up, least, &mut known)
        })
    }

    /// The least of `least` and the lowest point of a place. `known` has the lowest points of shapes
    /// by direction: many instances differ by what does not matter to it.
    fn lowest_at(
        &self,
        number: u32,
        PlacedShape { shape, instance }: &PlacedShape,
        up: Vec3,
        least: f32,
        known: &mut HashMap<(usize, [i32; 3]), f32>,
    ) -> f32 {
        let Some(instance) = instance else {
            return least.min(self.shapes()[*shape].lowest(up));
        };
        let inner = self
            .tree()
            .geometry(number)
            .and_then(|g| g.instanced_scene());
        let bounds = inner.expect("an instance has a scene").bounds();
        let bottoms = placed_corners(instance, [bounds.lower, bounds.upper]).map(|p| p.dot(up));
        if bottoms.into_iter().fold(f32::INFINITY, f32::min) >= least {
            return least;
        }
        let direction = instance.direction(up);
        let length = direction.length();
        let steps = (direction / length * DIRECTION_STEPS).round();
        let lowest = *known
            .entry((*shape, steps.as_ivec3().to_array()))
            .or_insert_with(|| self.shapes()[*shape].lowest(steps.normalize_or_zero()));
        least.min(length * lowest + up.dot(instance.to_scene.translation.into()))
    }
}

/// Steps of a unit vector's coordinates within which directions are the same.
const DIRECTION_STEPS: f32 = (1 << 22) as f32;

impl Shape {
    fn lowest(&self, up: Vec3) -> f32 {
        let height = |p: &Vec3| p.dot(up);
        let vertices = self.mesh().positions().iter().map(height);
        let lowest = vertices.fold(f32::INFINITY, f32::min);
        match self {
            Self::Flat(_) => lowest,
            Self::Curved(mesh) => (0..mesh.mesh().triangles().len() as u32)
                .into_par_iter()
                .map(|triangle| lowest_of_patch(mesh, triangle, up, lowest))
                .reduce(|| lowest, f32::min),
        }
    }
}

/// Points a side of the grid that [`Scene::lowest`] looks at.
const GRID: u32 = 12;

/// The least height on a patch where it is below `least` at all.
fn lowest_of_patch(mesh: &CurvedMesh, triangle: u32, up: Vec3, least: f32) -> f32 {
    let patch = mesh.patch(triangle);
    let [lower, upper] = patch.bounds().map(Vec3::from);
    let bottom = Vec3::select(up.cmpgt(Vec3::ZERO), lower, upper).dot(up);
    if patch.kind() == PatchKind::Degenerate || bottom >= least {
        return least;
    }
    let share = |n: u32| n as f32 / GRID as f32;
    (0..=GRID)
        .flat_map(|i| (0..=GRID - i).map(move |j| (share(i), share(j))))
        .map(|(u, v)| Vec3::from(patch.point(u, v).position).dot(up))
        .fold(least, f32::min)
}
