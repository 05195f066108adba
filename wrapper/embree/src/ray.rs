//! One ray and one hit, as values.

use glam::Vec3;

use super::sys::{INVALID_ID, LEVELS};

/// The largest magnitude of a component of a ray's origin or direction that Embree computes with.
/// Debian 12's library aborts the process beyond it.
pub const LARGEST_COMPONENT: f32 = 1.844e18;

/// What Embree divides by in place of a direction's component that is nearer to zero. A direction of nothing
/// but such components is none; one whose largest is below 1e-11 is that much turned by it that rounding is
/// not what decides at edges any more.
pub const LEAST_COMPONENT: f32 = 1e-18;

/// A ray: the points `origin + t direction` with `tnear <= t <= tfar`.
///
/// ```
/// use curvetri_embree::Ray;
/// use glam::Vec3;
///
/// let ray = Ray::new(Vec3::ZERO, 2.0 * Vec3::X).between(0.0, 10.0);
/// assert_eq!(ray.at(1.5), Vec3::new(3.0, 0.0, 0.0));
/// assert!(ray.is_traceable());
/// assert!(!ray.between(0.0, f32::NAN).is_traceable());
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ray {
    /// Where t = 0.
    pub origin: Vec3,
    /// Need not be of unit length: t counts in its length.
    pub direction: Vec3,
    /// Where the ray begins; 0 or more, see [`is_traceable`](Self::is_traceable).
    pub tnear: f32,
    /// Where the ray ends; may be infinite.
    pub tfar: f32,
    /// When, in [0, 1], for geometries with several time steps.
    pub time: f32,
    /// The ray sees the geometries whose mask has a bit in common with it.
    pub mask: u32,
    /// For the caller's own use.
    pub id: u32,
    /// For Embree's use; 0.
    pub flags: u32,
}

impl Ray {
    /// A ray from t = 0 to infinity at time 0 that sees every geometry.
    pub const fn new(origin: Vec3, direction: Vec3) -> Self {
        let (tnear, tfar) = (0.0, f32::INFINITY);
        Self {
            origin,
            direction,
            tnear,
            tfar,
            time: 0.0,
            mask: !0,
            id: 0,
            flags: 0,
        }
    }

    /// The same ray from `tnear` to `tfar`.
    pub const fn between(self, tnear: f32, tfar: f32) -> Self {
        Self {
            tnear,
            tfar,
            ..self
        }
    }

    /// The point at t.
    pub fn at(&self, t: f32) -> Vec3 {
        self.origin + t * self.direction
    }

    /// Whether the ray is one that Embree traces: numbers within [`LARGEST_COMPONENT`] in origin and
    /// direction, a direction that has a component of [`LEAST_COMPONENT`] or more, `0 <= tnear <= tfar`, a
    /// time in [0, 1], no NaN. Any other ray hits nothing, whatever the version of Embree (Debian 12's would
    /// abort the process, or tell one thing of a ray alone and another of it in a packet).
    pub fn is_traceable(&self) -> bool {
        let small = |v: Vec3| v.abs().cmple(Vec3::splat(LARGEST_COMPONENT)).all();
        small(self.origin)
            && small(self.direction)
            && self.direction.abs().max_element() >= LEAST_COMPONENT
            && self.tnear >= 0.0
            && self.tnear <= self.tfar
            && (0.0..=1.0).contains(&self.time)
    }
}

/// Where a ray hit.
///
/// ```
/// use curvetri_embree::{Geometry, Hit, QueryOptions, Ray, SceneBuilder};
/// use glam::Vec3;
///
/// let device = curvetri_embree_linked::device()?;
/// let corners = [Vec3::ZERO, Vec3::X, Vec3::Y];
/// let mut builder = SceneBuilder::new(&device)?;
/// builder.attach(&Geometry::triangles(&device, &corners, &[[0, 1, 2]])?.commit()?);
/// let scene = builder.commit()?;
///
/// let ray = Ray::new(Vec3::new(0.2, 0.3, -1.0), Vec3::Z);
/// let hit = scene.intersect1(&ray, &QueryOptions::default()).expect("it hits the triangle");
/// let [a, b, c] = corners;
/// let point = a + hit.u * (b - a) + hit.v * (c - a);
/// assert!(point.distance(ray.at(hit.t)) < 1e-6);
/// assert_eq!(hit.inst_id, [Hit::NONE]);
/// # Ok::<(), curvetri_embree::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hit {
    /// The ray's parameter, in units of its direction's length.
    pub t: f32,
    /// The first parameter of the point on the primitive; of a triangle its second vertex's
    /// barycentric coordinate.
    pub u: f32,
    /// The second parameter; of a triangle its third vertex's barycentric coordinate.
    pub v: f32,
    /// A normal of the surface, not of unit length, in the space of the geometry: of an instance's
    /// hit before its transform.
    pub ng: Vec3,
    /// The primitive's number in its geometry.
    pub prim_id: u32,
    /// The geometry's number in its scene.
    pub geom_id: u32,
    /// The instance's number in its scene by level, the outermost first; [`Hit::NONE`] where there is
    /// none.
    pub inst_id: [u32; LEVELS],
    /// The number in its instance array by level; [`Hit::NONE`] where there is none, and always with
    /// Embree 3.13.
    pub inst_prim_id: [u32; LEVELS],
}

impl Hit {
    /// The number that stands for "none" where a geometry or an instance has its number.
    pub const NONE: u32 = INVALID_ID;

    /// Levels of nested instances that a hit tells: as many as distributions build Embree with.
    pub const LEVELS: usize = LEVELS;
}

/// A point of a user geometry's surface that a ray meets: what a callback reports.
///
/// ```
/// use curvetri_embree::{Ray, SurfaceHit};
/// use glam::Vec3;
///
/// /// Where a ray meets the plane z = 0.
/// fn plane(ray: &Ray) -> SurfaceHit {
///     let t = -ray.origin.z / ray.direction.z;
///     let point = ray.at(t);
///     SurfaceHit { t, u: point.x, v: point.y, ng: Vec3::Z }
/// }
/// # assert_eq!(plane(&Ray::new(Vec3::new(1.0, 2.0, 3.0), -Vec3::Z)).t, 3.0);
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SurfaceHit {
    /// The ray's parameter, in units of its direction's length.
    pub t: f32,
    /// The point's first parameter on the primitive.
    pub u: f32,
    /// The point's second parameter on the primitive.
    pub v: f32,
    /// A normal of the surface, of any length, in the geometry's space.
    pub ng: Vec3,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn traceable_rays_are_those_embree_computes_with() {
        let ray = Ray::new(Vec3::ZERO, Vec3::Z);
        assert!(ray.is_traceable());
        assert!(ray.between(-0.0, 0.0).is_traceable());
        assert!(!ray.between(-1e-30, 1.0).is_traceable());
        assert!(!ray.between(2.0, 1.0).is_traceable());
        assert!(!ray.between(f32::NAN, 1.0).is_traceable());
        assert!(!ray.between(0.0, f32::NAN).is_traceable());
        for (time, good) in [
            (0.0, true),
            (1.0, true),
            (-0.1, false),
            (1.1, false),
            (f32::NAN, false),
        ] {
            assert_eq!(Ray { time, ..ray }.is_traceable(), good);
        }
        for bad in [
            f32::NAN,
            f32::INFINITY,
            f32::NEG_INFINITY,
            1.85e18,
            -1.85e18,
        ] {
            assert!(!Ray::new(Vec3::new(0.0, bad, 0.0), Vec3::Z).is_traceable());
            assert!(!Ray::new(Vec3::ZERO, Vec3::new(0.0, 1.0, bad)).is_traceable());
        }
        assert!(Ray::new(Vec3::splat(1.844e18), Vec3::splat(-1.844e18)).is_traceable());
        assert!(Ray::new(Vec3::ZERO, Vec3::new(0.0, -1e-18, 1e-30)).is_traceable());
        assert!(!Ray::new(Vec3::ZERO, Vec3::splat(-0.9e-18)).is_traceable());
        assert!(!Ray::new(Vec3::ZERO, Vec3::ZERO).is_traceable());
    }
}
