//! The angles between normals.

use glam::Vec3;

use super::probe::Probe;
use super::summary::Summary;

/// The angles between the normals that the surfaces are lit by, in degrees, over the pixels that see
/// both; `None` if there are none.
///
/// # Panics
/// If the probes' sizes differ.
pub(super) fn shading_angles(a: &Probe, b: &Probe) -> Option<Summary> {
    summary(a.both(b).map(|(a, b)| angle(a.shading, b.shading)))
}

/// The angles of a geometry's own normals to the normals that the true surface is lit by, in degrees,
/// over the pixels that see both; `None` if there are none.
///
/// # Panics
/// If the probes' sizes differ.
pub(super) fn geometric_angles(form: &Probe, truth: &Probe) -> Option<Summary> {
    let pairs = form.both(truth);
    summary(pairs.map(|(form, truth)| angle(form.geometric, truth.shading)))
}

fn summary(degrees: impl Iterator<Item = f64>) -> Option<Summary> {
    Summary::of(degrees.map(|angle| [angle, 1.0]).collect())
}

/// The angle between unit vectors in degrees, exact for small ones as well.
fn angle(a: Vec3, b: Vec3) -> f64 {
    let [a, b] = [a, b].map(Vec3::as_dvec3);
    a.cross(b).length().atan2(a.dot(b)).to_degrees()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn small_angles_are_exact() {
        let turned = |degrees: f64| {
            let (y, x) = degrees.to_radians().sin_cos();
            Vec3::new(x as f32, y as f32, 0.0)
        };
        for degrees in [0.0, 1e-3, 5.0, 90.0, 179.0] {
            let found = angle(Vec3::X, turned(degrees));
            assert!((found - degrees).abs() < 1e-5, "{found} for {degrees}");
        }
    }
}
