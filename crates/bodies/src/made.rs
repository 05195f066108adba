//! Meshes made by formula.

use std::f64::consts::TAU;

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::revolution::Revolution;
use curvetri_mesh::Mesh;

/// A torus with bumps all over, of ring radius 1, with its true normals: closed, and of about as
/// many triangles as wanted, from 18 to tens of millions.
///
/// # Panics
///
/// If there are more than 2^31 index values.
#[must_use]
pub fn bumpy_torus(triangles: usize) -> Mesh {
    // Pieces around the ring to those around the tube as 4 to 3: about square ones.
    let tube = ((triangles as f64 * 3.0 / 8.0).sqrt().round() as usize).max(3);
    let ring = triangles.div_ceil(2 * tube).max(3);
    let (positions, normals) = (0..ring * tube)
        .into_par_iter()
        .map(|i| {
            let a = TAU * (i / tube) as f64 / ring as f64;
            let b = TAU * (i % tube) as f64 / tube as f64;
            bumpy_torus_point(a, b)
        })
        .unzip();
    let vertex = |i: usize, j: usize| ((i % ring) * tube + j % tube) as u32;
    let corners = (0..ring * tube)
        .into_par_iter()
        .flat_map_iter(|i| {
            let (i, j) = (i / tube, i % tube);
            let q = [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)].map(|(i, j)| vertex(i, j));
            [[q[0], q[1], q[2]], [q[0], q[2], q[3]]]
        })
        .collect();
    Mesh::new(positions, Some(normals), corners).expect("a torus is a mesh")
}

/// The distance of a point from the true surface of [`bumpy_torus`] to first order, negative inside:
/// good near the surface only.
#[must_use]
pub fn bumpy_torus_distance(point: DVec3) -> f64 {
    let ring = point.truncate();
    let (radius, a) = (ring.length(), ring.y.atan2(ring.x));
    let across = DVec2::new(radius - 1.0, point.z);
    let (out, b) = (across.length(), across.y.atan2(across.x));
    let [tube, by_a, by_b] = tube_radius(a, b);
    let slope = DVec2::new(by_a / radius, by_b / out);
    (out - tube) / (1.0 + slope.length_squared()).sqrt()
}

/// The tube's radius at the angles `a` around the ring and `b` around the tube, with its derivatives.
fn tube_radius(a: f64, b: f64) -> [f64; 3] {
    const BUMP: f64 = 0.04;
    let (bumps_a, bumps_b) = (12.0, 5.0);
    [
        0.4 + BUMP * (bumps_a * a).cos() * (bumps_b * b).cos(),
        -BUMP * bumps_a * (bumps_a * a).sin() * (bumps_b * b).cos(),
        -BUMP * bumps_b * (bumps_a * a).cos() * (bumps_b * b).sin(),
    ]
}

/// The point at the angles `a` around the ring and `b` around the tube, and the normal.
fn bumpy_torus_point(a: f64, b: f64) -> (DVec3, DVec3) {
    let [tube, tube_a, tube_b] = tube_radius(a, b);
    let around = DVec2::from_angle(a).extend(0.0);
    let along = DVec2::from_angle(a).perp().extend(0.0);
    let out = b.cos() * around + b.sin() * DVec3::Z;
    let across = -b.sin() * around + b.cos() * DVec3::Z;
    let by_a = tube_a * out + (1.0 + tube * b.cos()) * along;
    let by_b = tube_b * out + tube * across;
    (around + tube * out, by_a.cross(by_b))
}

/// A closed cylinder of radius 1 from z = 0 to `height` with hard rims, cut into `segments`
/// around, with the true normals: `4 * segments` triangles.
///
/// # Panics
///
/// If there are fewer than 3 segments.
#[must_use]
pub fn capped_cylinder(segments: usize, height: f64) -> Mesh {
    let mut body = Revolution::new(circle(segments));
    let (bottom, top) = (DVec2::new(1.0, 0.0), DVec2::new(1.0, height));
    body.disc(bottom, -1.0);
    body.band([(bottom, DVec2::X), (top, DVec2::X)]);
    body.disc(top, 1.0);
    body.mesh()
}

/// A closed cone of base radius 1 from z = 0 up to `height` with a hard rim, cut into `segments`
/// around: `2 * segments` triangles. The apex has each triangle's own normal.
///
/// # Panics
///
/// If there are fewer than 3 segments.
#[must_use]
pub fn capped_cone(segments: usize, height: f64) -> Mesh {
    let mut body = Revolution::new(circle(segments));
    let normal = DVec2::new(height, 1.0);
    body.disc(DVec2::X, -1.0);
    body.cone((DVec2::X, normal), (DVec2::new(0.0, height), normal));
    body.mesh()
}

/// The unit sphere cut along 16 meridians and 7 parallels, with the true normals: 224 triangles. Under
/// a sun from the side it shows the shadow terminator: flat triangles that are lit by interpolated
/// normals shadow themselves before the light ends.
#[must_use]
pub fn terminator() -> Mesh {
    let mut body = Revolution::new(circle(16));
    let profile = |n: u32| {
        let point = match n {
            0 => DVec2::NEG_Y,
            8 => DVec2::Y,
            _ => DVec2::from_angle(TAU / 16.0 * (f64::from(n) - 4.0)),
        };
        (point, point)
    };
    for n in 0..8 {
        body.band([profile(n), profile(n + 1)]);
    }
    body.mesh()
}

/// The unit circle's points and, as its normals, the same.
fn circle(segments: usize) -> Vec<(DVec2, DVec2)> {
    assert!(segments >= 3, "a circle is cut into 3 segments or more");
    (0..segments)
        .map(|i| DVec2::from_angle(TAU * i as f64 / segments as f64))
        .map(|p| (p, p))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::revolution::tests::check_closed;

    #[test]
    fn a_bumpy_torus_is_closed_and_smooth_at_any_size() {
        for wanted in [1, 18, 1000, 100_000] {
            let mesh = bumpy_torus(wanted);
            let made = mesh.triangles().len();
            assert!(made >= wanted && made < wanted + wanted / 10 + 20, "{made}");
            let counts = check_closed(&mesh, if wanted < 1000 { -1.0 } else { 0.5 });
            assert_eq!(counts.hard, 0);
        }
    }

    #[test]
    fn vertices_of_the_bumpy_torus_lie_on_it_and_moved_ones_do_not() {
        let mesh = bumpy_torus(3000);
        for vertex in 0..mesh.positions().len() {
            let (at, normal) = (
                mesh.world_position(vertex),
                mesh.normals()[vertex].as_dvec3(),
            );
            assert!(bumpy_torus_distance(at).abs() < 1e-6);
            let moved = bumpy_torus_distance(at - 1e-3 * normal);
            assert!((moved + 1e-3).abs() < 3e-5, "{moved}");
        }
    }

    #[test]
    fn a_capped_cylinder_has_two_hard_rims() {
        let mesh = capped_cylinder(12, 1.5);
        assert_eq!(mesh.triangles().len(), 48);
        let counts = check_closed(&mesh, 0.9);
        assert_eq!(counts.hard, 24);
        assert!(
            mesh.normals()
                .iter()
                .all(|n| n.z == 0.0 || n.z.abs() == 1.0)
        );
    }

    #[test]
    fn the_terminator_s_sphere_is_closed_and_smooth() {
        let mesh = terminator();
        assert_eq!(mesh.triangles().len(), 224);
        assert_eq!(check_closed(&mesh, 0.9).hard, 0);
        for (p, n) in mesh.positions().iter().zip(mesh.normals()) {
            assert!((p.length() - 1.0).abs() < 1e-6 && p.distance(*n) < 1e-6);
        }
    }

    #[test]
    fn a_capped_cone_has_a_hard_rim_and_hard_edges_to_its_apex() {
        let mesh = capped_cone(8, 1.25);
        assert_eq!(mesh.triangles().len(), 16);
        assert_eq!(check_closed(&mesh, 0.8).hard, 16);
    }
}
