//! Where light goes on from a surface: diffusely, or through glass.

use std::f32::consts::TAU;

use glam::Vec3;

/// A direction above a surface of unit `normal`, drawn in proportion to its cosine. `u` and `v` are in
/// [0, 1). Light that comes this way is weighted by the albedo of a diffuse surface and nothing else.
pub(in crate::render) fn cosine_direction(normal: Vec3, [u, v]: [f32; 2]) -> Vec3 {
    let (right, front) = normal.any_orthonormal_pair();
    let (sin, cos) = (TAU * v).sin_cos();
    let aside = u.sqrt();
    (aside * cos * right + aside * sin * front + (1.0 - u).sqrt() * normal).normalize()
}

/// Where light that meets glass goes on: mirrored, or through the surface.
///
/// `direction` is unit, `normal` unit and on the side that the light comes from, `ratio` the
/// refractive index on that side to the one behind. `choice` in [0, 1) decides between the two in
/// proportion to what goes each way, so that the way taken has weight 1. (Radiance in glass is not
/// scaled by its index squared: light that is seen entered and left.)
pub(super) fn dielectric(direction: Vec3, normal: Vec3, ratio: f32, choice: f32) -> Vec3 {
    let cosine = -direction.dot(normal);
    match transmitted_cosine(cosine, ratio) {
        Some(behind) if choice >= reflectance(cosine, behind, ratio) => {
            (ratio * direction + (ratio * cosine - behind) * normal).normalize()
        }
        _ => (direction + 2.0 * cosine * normal).normalize(),
    }
}

/// The cosine behind the surface by Snell's law; `None` where all light is reflected.
fn transmitted_cosine(cosine: f32, ratio: f32) -> Option<f32> {
    let rest = 1.0 - ratio * ratio * (1.0 - cosine * cosine);
    (rest > 0.0).then(|| rest.sqrt())
}

/// The share of unpolarised light that is reflected, by Fresnel's equations.
fn reflectance(cosine: f32, behind: f32, ratio: f32) -> f32 {
    let perpendicular = (ratio * cosine - behind) / (ratio * cosine + behind);
    let parallel = (cosine - ratio * behind) / (cosine + ratio * behind);
    0.5 * (perpendicular * perpendicular + parallel * parallel)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn glass_reflects_as_fresnel_s_equations_say() {
        let glass = |degrees: f32, ratio: f32| {
            let cosine = degrees.to_radians().cos();
            transmitted_cosine(cosine, ratio).map(|behind| reflectance(cosine, behind, ratio))
        };
        assert!((glass(0.0, 1.0 / 1.5).unwrap() - 0.04).abs() < 1e-6);
        assert!((glass(0.0, 1.5).unwrap() - 0.04).abs() < 1e-6);
        // At Brewster's angle only the perpendicular half: ((n^2 - 1) / (n^2 + 1))^2 of it.
        let brewster = glass(1.5_f32.atan().to_degrees(), 1.0 / 1.5).unwrap();
        assert!((brewster - 0.5 * (1.25_f32 / 3.25).powi(2)).abs() < 1e-5);
        // Beyond the critical angle, asin(1 / 1.5) = 41.8 degrees, everything.
        assert!(glass(41.5, 1.5).is_some() && glass(42.0, 1.5).is_none());
    }

    #[test]
    fn light_bends_by_snell_s_law_and_mirrors_at_the_same_angle() {
        let direction = Vec3::new(0.6, 0.0, -0.8);
        let through = dielectric(direction, Vec3::Z, 1.0 / 1.5, 0.99);
        assert!((through.x - 0.4).abs() < 1e-6 && through.z < 0.0);
        let mirrored = dielectric(direction, Vec3::Z, 1.0 / 1.5, 0.0);
        assert!((mirrored - Vec3::new(0.6, 0.0, 0.8)).length() < 1e-6);
        let inside = dielectric(direction, Vec3::Z, 2.0, 0.99);
        assert!(inside.z > 0.0, "all light is reflected: {inside}");
        let same = dielectric(direction, Vec3::Z, 1.0, 0.0);
        assert!(
            (same - direction).length() < 1e-6,
            "no glass at all: {same}"
        );
    }

    #[test]
    fn directions_lie_above_the_surface_by_their_cosine() {
        let normal = Vec3::new(0.48, -0.6, 0.64);
        let count = 64;
        let mut mean = Vec3::ZERO;
        for i in 0..count * count {
            let [u, v] = [i / count, i % count].map(|n| (n as f32 + 0.5) / count as f32);
            let direction = cosine_direction(normal, [u, v]);
            assert!((direction.length() - 1.0).abs() < 1e-5 && direction.dot(normal) > 0.0);
            mean += direction / (count * count) as f32;
        }
        // The mean of the cosine itself is 2/3.
        assert!((mean - 2.0 / 3.0 * normal).length() < 1e-3, "{mean}");
    }
}
