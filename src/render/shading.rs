//! The normals that surfaces are lit by.

use glam::Vec3;

use super::scene::Scene;
use crate::embree::Hit;

/// Which normals surfaces are lit by. Outlines and shadows are those of the geometry either way, and so is where
/// rays leave it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Shading {
    /// The geometry's own normals. Every flat triangle is a facet.
    #[default]
    Geometric,
    /// The vertices' normals, interpolated linearly between them by u and v (Phong shading): what a renderer
    /// does with flat triangles to make them look smooth. On a curved surface they are the normals that the
    /// mesh's author stored.
    Interpolated,
}

impl Shading {
    /// The unit normal that a hit is lit by, on the same side of the surface as `facing`, one of the
    /// two unit normals of the geometry there.
    pub(crate) fn normal(self, scene: &Scene, hit: &Hit, facing: Vec3) -> Vec3 {
        match self {
            Self::Geometric => facing,
            Self::Interpolated => {
                interpolated(scene, hit).map_or(facing, |unit| unit * unit.dot(facing).signum())
            }
        }
    }
}

/// The unit normal between those of the triangle's vertices; none where they cancel out.
fn interpolated(scene: &Scene, hit: &Hit) -> Option<Vec3> {
    let place = scene.placed_shape(hit);
    let normals = (scene.shapes()[place.shape].mesh()).triangle_normals(hit.prim_id as usize);
    // As if the vertices were the scene's own.
    let [a, b, c] = match place.instance {
        None => normals,
        Some(_) => normals.map(|normal| place.normal(normal)),
    };
    ((1.0 - hit.u - hit.v) * a + hit.u * b + hit.v * c).try_normalize()
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::curved::CurvedOptions;
    use crate::embree::{QueryOptions, Ray};
    use crate::mesh::Mesh;
    use crate::render::Form;

    #[test]
    fn interpolated_normals_are_the_vertices_own() {
        let corners = [DVec3::ZERO, DVec3::X, DVec3::Y];
        let normals = [DVec3::Z, DVec3::new(0.6, 0.0, 0.8), DVec3::Z];
        let device = crate::linked::device().unwrap();
        let scene = |form| {
            let mesh = Mesh::new(corners.to_vec(), Some(normals.to_vec()), vec![[0, 1, 2]]);
            Scene::new(&device, vec![mesh.unwrap()], form).unwrap()
        };
        let at = |scene: &Scene, from: Vec3, shading: Shading| {
            let ray = Ray::new(from, -from.z.signum() * Vec3::Z);
            let hit = scene.tree().intersect1(&ray, &QueryOptions::INCOHERENT);
            let hit = hit.expect("the triangle is there");
            let unit = hit.ng.normalize() * from.z.signum();
            (shading.normal(scene, &hit, unit), unit)
        };
        let flat = scene(Form::Flat);
        let near = |a: Vec3, b: Vec3| (a - b).length() < 1e-6;
        let middle = Vec3::new(0.5, 0.0001, 3.0);
        let (normal, unit) = at(&flat, middle, Shading::Interpolated);
        let expected = Vec3::new(0.3, 0.0, 0.9).normalize();
        assert!((normal - expected).length() < 1e-3 && near(unit, Vec3::Z));
        let (below, _) = at(
            &flat,
            middle * Vec3::new(1.0, 1.0, -1.0),
            Shading::Interpolated,
        );
        assert!(near(below, -normal), "seen from below: {below}");
        let (normal, unit) = at(&flat, middle, Shading::Geometric);
        assert_eq!(normal, unit);
        let curved = scene(Form::Curved(CurvedOptions::default()));
        let (own, unit) = at(&curved, middle, Shading::Geometric);
        assert_eq!(own, unit);
        let (normal, unit) = at(&curved, middle, Shading::Interpolated);
        assert!((normal - expected).length() < 0.02, "{normal}");
        assert!(!near(normal, unit), "the surface's own differs: {unit}");
    }
}
