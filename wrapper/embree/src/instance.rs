//! Instances: a scene placed in another one by a transform.

use glam::{Affine3A, DMat3, DVec3};

use super::device::Device;
use super::error::{Error, attempt};
use super::geometry::{Geometry, GeometryBuilder};
use super::scene::Scene;
use super::sys::{LEVELS, RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR, RTC_GEOMETRY_TYPE_INSTANCE};
use super::table::embree;

/// Embree inverts transforms and transforms rays in f32: what it computes may be larger than what is
/// computed here by some rounding, never by this factor.
const ROUNDING: f64 = 1.01;

impl Geometry {
    /// A scene placed in another one: `transform` takes points of the instanced scene to the scene the
    /// instance is attached to. It may scale, shear and mirror.
    ///
    /// A hit's normal stays in the instanced scene's space, as do the rays that callbacks and filters
    /// see. Filters belong to the instanced scene's geometries: Embree refuses one that is set here.
    ///
    /// # Errors
    /// If the scene is of another device, instances would be nested deeper than the library allows
    /// (Debian's and Ubuntu's allow one level), or the transform is not finite, cannot be inverted or
    /// is so extreme that hardly any ray could be transformed by it.
    pub fn instance(
        device: &Device,
        scene: &Scene,
        transform: Affine3A,
    ) -> Result<GeometryBuilder, Error> {
        if !scene.device().is(device) {
            return Err(Error::OtherDevice("scene"));
        }
        let depth = scene.depth() + 1;
        if depth > LEVELS {
            return Err(Error::Nesting { depth });
        }
        let reach = reach(&transform, scene.reach())
            .ok_or_else(|| Error::Transform(format!("{transform}")))?;
        let kind = RTC_GEOMETRY_TYPE_INSTANCE;
        let builder = GeometryBuilder::of_instance(device, kind, scene.clone(), reach)?;
        let embree = device.embree();
        let (geometry, instanced) = (builder.handle(), scene.handle());
        let matrix: [f32; 12] = transform.to_cols_array();
        let format = RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR;
        // SAFETY: both handles are live; the geometry holds a clone of the scene; Embree copies the
        // matrix of twelve numbers.
        attempt("make an instance", || unsafe {
            embree!(embree, set_geometry_instanced_scene(geometry, instanced));
            embree!(embree, set_geometry_time_step_count(geometry, 1));
            embree!(
                embree,
                set_geometry_transform(geometry, 0, format, matrix.as_ptr().cast())
            );
        })?;
        Ok(builder)
    }
}

/// The largest component a ray may have so that after the transform's inverse none is larger than
/// `inner`; `None` if the transform cannot be used.
fn reach(transform: &Affine3A, inner: f32) -> Option<f32> {
    let matrix = transform.matrix3.as_dmat3();
    let inverse: DMat3 = matrix.try_inverse().filter(|_| transform.is_finite())?;
    let largest = |row: DVec3| row.abs().max_element();
    let rows = inverse.transpose();
    let rows = [rows.x_axis, rows.y_axis, rows.z_axis];
    // Embree divides the adjugate by the determinant, in f32 without denormals
    let determinant = matrix.determinant();
    let adjugate = rows.map(|row| largest(row * determinant));
    let in_range = |number: f64| (1e-37..=1e37).contains(&number.abs());
    if !in_range(determinant) || !adjugate.into_iter().all(in_range) {
        return None;
    }
    let offset = largest(inverse * transform.translation.as_dvec3());
    let growth = rows
        .map(|row| row.abs().element_sum())
        .into_iter()
        .fold(0.0, f64::max);
    let reach = (f64::from(inner) / ROUNDING - offset) / growth;
    // NaN is not above 1
    (reach > 1.0).then(|| reach.min(f64::from(inner)) as f32)
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;
    use crate::LARGEST_COMPONENT;

    #[test]
    fn reach_shrinks_by_what_the_inverse_grows() {
        let inner = LARGEST_COMPONENT;
        assert_eq!(
            reach(&Affine3A::IDENTITY, inner),
            Some(inner / ROUNDING as f32)
        );
        let tenth = reach(&Affine3A::from_scale(Vec3::splat(0.1)), inner).unwrap();
        assert!((tenth / (inner * 0.1 / ROUNDING as f32) - 1.0).abs() < 1e-5);
        assert!(reach(&Affine3A::from_scale(Vec3::splat(10.0)), inner).unwrap() <= inner);
    }

    #[test]
    fn transforms_without_an_inverse_are_refused() {
        let refused = [
            Affine3A::from_scale(Vec3::new(1.0, 0.0, 1.0)),
            Affine3A::from_scale(Vec3::splat(f32::NAN)),
            Affine3A::from_translation(Vec3::splat(f32::INFINITY)),
            Affine3A::from_translation(Vec3::splat(1e30)),
            Affine3A::from_scale(Vec3::splat(1e-15)),
            Affine3A::from_scale(Vec3::splat(1e15)),
            Affine3A::from_scale(Vec3::new(1e-20, 1e-20, 1e3)),
        ];
        for transform in refused {
            assert_eq!(reach(&transform, LARGEST_COMPONENT), None, "{transform}");
        }
    }
}
