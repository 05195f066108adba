//! A use of a shape in a scene, and the transform to it.

use glam::{Affine3A, DAffine3, DVec3, Vec3};

use crate::embree::Ray;
use crate::mesh::Placement;

/// Rounding of a point on its way through a transform and back along a ray, in units of the last
/// place of the sums' terms: the ray's own way to the mesh's space and that of the ray that leaves,
/// two each with the products' and the point's own.
const TRANSFORM_ULPS: f32 = 8.0;

/// A use of a shape in a scene.
#[derive(Debug)]
pub(super) struct PlacedShape {
    /// The shape's number.
    pub shape: usize,
    /// `None` for a shape that is in the scene's space itself.
    pub instance: Option<Instance>,
}

/// An instance's way between the spaces of its shape and of the scene, both local.
#[derive(Debug)]
pub(super) struct Instance {
    pub to_scene: Affine3A,
    to_shape: Affine3A,
}

impl PlacedShape {
    /// A normal of the shape as a unit normal in the scene, on the same side of the surface; zero
    /// where it has no direction.
    pub fn normal(&self, normal: Vec3) -> Vec3 {
        let unit = normal.normalize_or_zero();
        match &self.instance {
            None => unit,
            Some(instance) => instance.covector(unit).normalize_or_zero(),
        }
    }
}

impl Instance {
    /// For a shape relative to `shape_origin` and a scene relative to `scene_origin`.
    pub fn new(placement: &Placement, shape_origin: DVec3, scene_origin: DVec3) -> Self {
        let DAffine3 { matrix3, .. } = placement.to_user;
        // What is large cancels before it is rounded.
        let translation = placement.to_user.transform_point3(shape_origin) - scene_origin;
        let to_scene = Affine3A::from_mat3_translation(matrix3.as_mat3(), translation.as_vec3());
        // Of the rounded transform, as Embree's own.
        let rounded = DAffine3::from_mat3_translation(
            to_scene.matrix3.as_dmat3(),
            to_scene.translation.as_dvec3(),
        );
        let inverse = rounded.inverse();
        Self {
            to_scene,
            to_shape: Affine3A::from_mat3_translation(
                inverse.matrix3.as_mat3(),
                inverse.translation.as_vec3(),
            ),
        }
    }

    /// What the transform makes longer than all else, by how much: no less than that.
    pub fn greatest_scale(&self) -> f32 {
        let [x, y, z] = [glam::Vec3A::X, glam::Vec3A::Y, glam::Vec3A::Z];
        let axes = [x, y, z].map(|axis| self.to_scene.transform_vector3a(axis).length_squared());
        axes.iter().sum::<f32>().sqrt()
    }

    /// The transform's inverse, transposed, on a normal: it stays on its side of the surface, also
    /// where the transform mirrors.
    fn covector(&self, normal: Vec3) -> Vec3 {
        self.to_shape.matrix3.transpose() * normal
    }

    /// A direction of the scene as one whose products with points of the shape are, up to a constant,
    /// its own with their places in the scene.
    pub fn direction(&self, direction: Vec3) -> Vec3 {
        self.to_scene.matrix3.transpose() * direction
    }

    /// A ray of the scene in the shape's space; t stays.
    pub fn localized(&self, ray: &Ray) -> Ray {
        Ray {
            origin: self.to_shape.transform_point3(ray.origin),
            direction: self.to_shape.transform_vector3(ray.direction),
            ..*ray
        }
    }

    /// How far the surface may be from a ray's point at t, along the scene's normal there, where it
    /// may be `bound` off in the shape's space along the shape's `normal`.
    pub fn error_bound(&self, bound: f32, normal: Vec3, ray: &Ray, t: f32) -> f32 {
        let unit = normal.normalize_or_zero();
        let far = ray.origin.abs() + t.abs() * ray.direction.abs();
        let moved = self.to_shape.matrix3.abs() * far + Vec3::from(self.to_shape.translation).abs();
        let transformed = TRANSFORM_ULPS * f32::EPSILON * unit.abs().dot(moved);
        // Planes that are 1 apart in the shape's space are 1 over this apart in the scene's.
        (bound + transformed) / self.covector(unit).length()
    }

    /// By how much lengths grow at the most (at least that, and no more where the transform is a
    /// rotation after a scaling).
    pub fn stretch(&self) -> f32 {
        let m = self.to_scene.matrix3;
        let square = (m.transpose() * m).abs();
        (square * Vec3::ONE).max_element().sqrt()
    }
}

#[cfg(test)]
mod tests {
    use glam::{DMat3, Quat};

    use super::*;

    /// Mirrored, stretched, turned and moved, far out.
    fn instance() -> Instance {
        let turn = DMat3::from_quat(glam::DQuat::from_xyzw(0.1, 0.7, -0.5, 0.3).normalize());
        let stretch = DMat3::from_diagonal(DVec3::new(2.0, -0.25, 1.0));
        let placement = Placement {
            part: 0,
            to_user: DAffine3::from_mat3_translation(turn * stretch, DVec3::new(3e6, 2.0, -7e5)),
        };
        Instance::new(
            &placement,
            DVec3::new(0.0, 5e5, 0.0),
            DVec3::new(3e6, 0.0, -7e5),
        )
    }

    #[test]
    fn normals_stay_perpendicular_and_on_their_side() {
        let place = PlacedShape {
            shape: 0,
            instance: Some(instance()),
        };
        let m = place.instance.as_ref().unwrap().to_scene.matrix3;
        for turn in 0..50 {
            let turn = Quat::from_euler(glam::EulerRot::XYZ, 0.7 * turn as f32, turn as f32, 0.4);
            let [along, across, normal] = [Vec3::X, Vec3::Y, Vec3::Z].map(|v| turn * v);
            let turned = place.normal(3.0 * normal);
            assert!((turned.length() - 1.0).abs() < 1e-5);
            for v in [along, across] {
                assert!(turned.dot(m * v).abs() < 1e-5);
            }
            assert!(turned.dot(m * normal) > 0.0);
        }
        assert_eq!(place.normal(Vec3::ZERO), Vec3::ZERO);
    }

    #[test]
    fn what_is_large_cancels_in_double_precision() {
        let instance = instance();
        let exact = DVec3::new(0.0, 2.0, 0.0) + instance_matrix() * DVec3::new(0.0, 5e5, 0.0);
        let off = instance.to_scene.translation.as_dvec3() - exact;
        assert!(
            off.abs().max_element() <= 0.5 * f64::from(f32::EPSILON) * 1.25e5,
            "{off}"
        );
    }

    fn instance_matrix() -> DMat3 {
        let turn = DMat3::from_quat(glam::DQuat::from_xyzw(0.1, 0.7, -0.5, 0.3).normalize());
        turn * DMat3::from_diagonal(DVec3::new(2.0, -0.25, 1.0))
    }

    #[test]
    fn rays_have_the_same_t_in_both_spaces_and_lengths_grow_by_no_more_than_the_stretch() {
        let instance = instance();
        let ray = Ray::new(Vec3::new(1.0, 2.0, 3.0), Vec3::new(0.3, -0.5, 0.1));
        let back = instance
            .to_scene
            .transform_point3(instance.localized(&ray).at(2.5));
        // The shape's space is some 5e5 across.
        assert!(back.distance(ray.at(2.5)) < 0.5, "{back}");
        assert!((instance.stretch() - 2.0).abs() < 1e-5);
    }
}
