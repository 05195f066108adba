//! The paper's bodies (its Table 1): coarse cuts with true normals, and the true surfaces.

use std::f64::consts::TAU;

use glam::{DVec2, DVec3};

use curvetri_mesh::Mesh;

/// The cylinder's height in radii.
const CYLINDER_HEIGHT: f64 = 1.5;
/// The cone's height in base radii.
const CONE_HEIGHT: f64 = 1.25;
/// The radius of the torus's tube in radii of its ring.
const TUBE: f64 = 0.25;
/// How many flat pieces the cylinder's and the cone's walls are cut into.
const WALL_PIECES: usize = 8;

/// One triangle of a body's cut, counter-clockwise seen from outside.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BodyTriangle {
    /// The corners; all lie on the true surface.
    pub positions: [DVec3; 3],
    /// The true surface's unit normals at the corners, outward.
    pub normals: [DVec3; 3],
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Shape {
    /// Radius 1 around the origin.
    Sphere,
    /// Radius 1 around the z axis.
    Cylinder,
    /// Radius 1 at z = 0, apex up the z axis.
    Cone,
    /// Ring radius 1 around the z axis.
    Torus,
}

/// A body with a known true surface and a coarse cut of it.
///
/// All bodies have radius 1 (the torus's ring) and stand around the z axis.
#[derive(Debug, Clone, PartialEq)]
pub struct Body {
    name: String,
    shape: Shape,
    triangles: Vec<BodyTriangle>,
}

impl Body {
    /// `sphere-tetrahedron`: the unit sphere cut into a regular tetrahedron's 4 triangles.
    #[must_use]
    pub fn sphere_tetrahedron() -> Body {
        let corner = |x, y, z| DVec3::new(x, y, z).normalize();
        let v = [
            corner(1.0, 1.0, 1.0),
            corner(1.0, -1.0, -1.0),
            corner(-1.0, 1.0, -1.0),
            corner(-1.0, -1.0, 1.0),
        ];
        let faces = [[0, 1, 2], [0, 3, 1], [0, 2, 3], [1, 3, 2]];
        Body::sphere("sphere-tetrahedron", faces.map(|t| t.map(|i| v[i])).into())
    }

    /// `sphere-cube`: the unit sphere cut into a cube's 6 squares of 2 triangles each.
    #[must_use]
    pub fn sphere_cube() -> Body {
        let mut triangles = Vec::new();
        for axis in 0..3 {
            for sign in [-1.0, 1.0] {
                let corner = |u: f64, v: f64| {
                    let mut p = [u, v * sign, sign];
                    p.rotate_right(axis);
                    DVec3::from(p).normalize()
                };
                let q = [
                    corner(-1.0, -1.0),
                    corner(1.0, -1.0),
                    corner(1.0, 1.0),
                    corner(-1.0, 1.0),
                ];
                triangles.extend([[q[0], q[1], q[2]], [q[0], q[2], q[3]]]);
            }
        }
        Body::sphere("sphere-cube", triangles)
    }

    fn sphere(name: &str, triangles: Vec<[DVec3; 3]>) -> Body {
        let triangles = triangles.into_iter().map(|t| BodyTriangle {
            positions: t,
            normals: t,
        });
        Body {
            name: name.into(),
            shape: Shape::Sphere,
            triangles: triangles.collect(),
        }
    }

    /// `cylinder`: the wall of a cylinder of height 1.5, cut into 8 rectangles of 2 triangles each.
    #[must_use]
    pub fn cylinder() -> Body {
        let around = circle(WALL_PIECES);
        let corner = |i: usize, z: f64| {
            let normal = around[i % WALL_PIECES].extend(0.0);
            (normal + z * DVec3::Z, normal)
        };
        let top = CYLINDER_HEIGHT;
        Body {
            name: "cylinder".into(),
            shape: Shape::Cylinder,
            triangles: (0..WALL_PIECES)
                .flat_map(|i| {
                    let q = [(i, 0.0), (i + 1, 0.0), (i + 1, top), (i, top)];
                    cut_quad(q.map(|(i, z)| corner(i, z)))
                })
                .collect(),
        }
    }

    /// `cone`: the wall of a cone of height 1.25, cut into 8 triangles. The apex has each
    /// triangle's own normal, the cone's at the triangle's middle.
    #[must_use]
    pub fn cone() -> Body {
        let around = circle(2 * WALL_PIECES);
        let normal = |i: usize| cone_normal(around[i % (2 * WALL_PIECES)]);
        let base = |i: usize| (around[i % (2 * WALL_PIECES)].extend(0.0), normal(i));
        Body {
            name: "cone".into(),
            shape: Shape::Cone,
            triangles: (0..2 * WALL_PIECES)
                .step_by(2)
                .map(|i| {
                    triangle([
                        base(i),
                        base(i + 2),
                        (CONE_HEIGHT * DVec3::Z, normal(i + 1)),
                    ])
                })
                .collect(),
        }
    }

    /// `torus-RxT`: a torus of ring radius 1 and tube radius 1/4, cut into `ring` pieces around
    /// the axis by `tube` pieces around the tube, of 2 triangles each.
    ///
    /// # Panics
    ///
    /// If a number of pieces is less than 3.
    #[must_use]
    pub fn torus(ring: usize, tube: usize) -> Body {
        assert!(ring >= 3 && tube >= 3, "a torus has 3 by 3 pieces or more");
        let (around, across) = (circle(ring), circle(tube));
        let corner = |i: usize, j: usize| {
            let (a, b) = (around[i % ring], across[j % tube]);
            let normal = (b.x * a).extend(b.y);
            (a.extend(0.0) + TUBE * normal, normal)
        };
        Body {
            name: format!("torus-{ring}x{tube}"),
            shape: Shape::Torus,
            triangles: (0..ring)
                .flat_map(|i| (0..tube).map(move |j| (i, j)))
                .flat_map(|(i, j)| {
                    let q = [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)];
                    cut_quad(q.map(|(i, j)| corner(i, j)))
                })
                .collect(),
        }
    }

    /// The bodies of the paper's Table 1, in its order; its torus, of 6 by 8 pieces, is named
    /// `torus` alone.
    #[must_use]
    pub fn table_1() -> Vec<Body> {
        let mut torus = Body::torus(6, 8);
        torus.name = "torus".into();
        vec![
            Body::sphere_tetrahedron(),
            Body::sphere_cube(),
            Body::cylinder(),
            Body::cone(),
            torus,
        ]
    }

    /// The torus cut finer and finer: 6 by 8, 12 by 16 and so on up to 96 by 128 pieces.
    #[must_use]
    pub fn torus_series() -> Vec<Body> {
        (0..5).map(|k| Body::torus(6 << k, 8 << k)).collect()
    }

    /// The body's name.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The body's cut.
    #[must_use]
    pub fn triangles(&self) -> &[BodyTriangle] {
        &self.triangles
    }

    /// The cut as a mesh, with the true normals.
    ///
    /// # Panics
    ///
    /// Never: the bodies' cuts are meshes.
    #[must_use]
    pub fn mesh(&self) -> Mesh {
        let corners = || self.triangles.iter();
        let count = self.triangles.len() as u32;
        Mesh::new(
            corners().flat_map(|t| t.positions).collect(),
            Some(corners().flat_map(|t| t.normals).collect()),
            (0..count).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect(),
        )
        .expect("a body's cut is a mesh")
    }

    /// The largest diameter, by which the paper divides its errors: that of the largest circle
    /// around the axis.
    #[must_use]
    pub fn diameter(&self) -> f64 {
        match self.shape {
            Shape::Sphere | Shape::Cylinder | Shape::Cone => 2.0,
            Shape::Torus => 2.0 * (1.0 + TUBE),
        }
    }

    /// The distance of a point from the true surface (the cylinder's and the cone's go on beyond
    /// their ends), negative inside. Beyond the cone's apex it is a lower bound.
    #[must_use]
    pub fn signed_distance(&self, point: DVec3) -> f64 {
        let radius = point.truncate().length();
        match self.shape {
            Shape::Sphere => point.length() - 1.0,
            Shape::Cylinder => radius - 1.0,
            Shape::Cone => {
                let n = cone_normal(DVec2::X);
                n.x * (radius - 1.0) + n.z * point.z
            }
            Shape::Torus => DVec2::new(radius - 1.0, point.z).length() - TUBE,
        }
    }

    /// The true surface's outward unit normal at a point on it (near it: at the foot of the
    /// perpendicular). Not defined on the axis, nor on the ring inside a torus's tube.
    #[must_use]
    pub fn normal(&self, point: DVec3) -> DVec3 {
        let outward = point.truncate().normalize_or(DVec2::X);
        match self.shape {
            Shape::Sphere => point.normalize(),
            Shape::Cylinder => outward.extend(0.0),
            Shape::Cone => cone_normal(outward),
            Shape::Torus => (point - outward.extend(0.0)).normalize(),
        }
    }

    /// The parameter, in lengths of `direction`, of the true surface's crossing that is nearest to
    /// `origin` on the line through it, forward or backward; `None` where the line passes the
    /// surface by, or meets it only further away than four diameters.
    #[must_use]
    pub fn true_parameter(&self, origin: DVec3, direction: DVec3) -> Option<f64> {
        let length = direction.length();
        let unit = direction / length;
        let crossings = [unit, -unit].map(|along| self.march(origin, along));
        let nearest = match crossings {
            [Some(a), Some(b)] => Some(if a <= b { a } else { -b }),
            [a, b] => a.or(b.map(|b| -b)),
        };
        // The march ends near the crossing; Newton's method takes it to the last digit.
        let mut t = nearest?;
        for _ in 0..4 {
            let point = origin + t * unit;
            let slope = self.normal(point).dot(unit);
            if slope.abs() > 1e-6 {
                t -= self.signed_distance(point) / slope;
            }
        }
        Some(t / length)
    }

    /// Marches by the distance, which never steps over a crossing, until very near to one.
    fn march(&self, origin: DVec3, along: DVec3) -> Option<f64> {
        let mut t = 0.0;
        for _ in 0..1000 {
            let distance = self.signed_distance(origin + t * along).abs();
            if distance < 1e-9 {
                return Some(t);
            }
            t += distance;
            if t > 4.0 * self.diameter() {
                return None;
            }
        }
        None
    }
}

/// Points of the unit circle at equal angles, counter-clockwise from (1, 0).
fn circle(count: usize) -> Vec<DVec2> {
    (0..count)
        .map(|i| DVec2::from_angle(TAU * i as f64 / count as f64))
        .collect()
}

/// The cone's unit normal in the half-plane of a unit vector of the xy plane.
fn cone_normal(outward: DVec2) -> DVec3 {
    (CONE_HEIGHT * outward).extend(1.0).normalize()
}

fn triangle(corners: [(DVec3, DVec3); 3]) -> BodyTriangle {
    BodyTriangle {
        positions: corners.map(|c| c.0),
        normals: corners.map(|c| c.1),
    }
}

fn cut_quad([a, b, c, d]: [(DVec3, DVec3); 4]) -> [BodyTriangle; 2] {
    [triangle([a, b, c]), triangle([a, c, d])]
}

#[cfg(test)]
mod tests {
    use super::*;
    use curvetri_mesh::Topology;

    fn all() -> Vec<Body> {
        let mut bodies = Body::table_1();
        bodies.extend(Body::torus_series());
        bodies
    }

    #[test]
    fn bodies_have_the_papers_numbers_of_triangles() {
        let counts: Vec<_> = all()
            .iter()
            .map(|b| (b.name().to_owned(), b.triangles().len()))
            .collect();
        let expected = [
            ("sphere-tetrahedron", 4),
            ("sphere-cube", 12),
            ("cylinder", 16),
            ("cone", 8),
            ("torus", 96),
            ("torus-6x8", 96),
            ("torus-12x16", 384),
            ("torus-24x32", 1536),
            ("torus-48x64", 6144),
            ("torus-96x128", 24576),
        ];
        assert_eq!(counts, expected.map(|(name, n)| (name.to_owned(), n)));
    }

    #[test]
    fn corners_lie_on_the_surface_with_its_normals() {
        for body in all() {
            for t in body.triangles() {
                for (p, n) in t.positions.into_iter().zip(t.normals) {
                    assert!(body.signed_distance(p).abs() < 1e-15, "{}", body.name());
                    assert!((n.length() - 1.0).abs() < 1e-15);
                    let apex = body.name() == "cone" && p.z > 0.0;
                    assert!(apex || body.normal(p).distance(n) < 1e-14);
                }
            }
        }
    }

    #[test]
    fn triangles_wind_outward() {
        for body in all() {
            for t in body.triangles() {
                let [a, b, c] = t.positions;
                let face = (b - a).cross(c - a).normalize();
                let least = t.normals.map(|n| n.dot(face)).into_iter().reduce(f64::min);
                assert!(least > Some(0.2), "{}: {least:?}", body.name());
            }
        }
    }

    #[test]
    fn spheres_and_tori_are_closed_and_smooth_and_walls_open_at_their_ends() {
        for body in all() {
            let mesh = body.mesh();
            assert_eq!(mesh.triangles().len(), body.triangles().len());
            let counts = *Topology::new(&mesh).counts();
            let (boundary, hard) = match body.name() {
                "cylinder" => (16, 0),
                "cone" => (8, 8),
                _ => (0, 0),
            };
            assert_eq!(
                (counts.boundary, counts.hard),
                (boundary, hard),
                "{}",
                body.name()
            );
            assert_eq!(counts.is_closed(), boundary == 0);
            assert_eq!(counts.flipped + counts.non_manifold, 0);
        }
    }

    #[test]
    fn the_nearest_crossing_is_found_to_the_last_digit() {
        for body in all() {
            for t in body.triangles().iter().take(20) {
                let point = (t.positions[0] + t.positions[1] + t.positions[2]) / 3.0;
                let direction = 3.0 * (t.normals[0] + 0.1 * t.normals[1]);
                let s = body.true_parameter(point, direction).unwrap();
                let foot = point + s * direction;
                assert!(body.signed_distance(foot).abs() < 1e-15, "{}", body.name());
                // No crossing nearer on either side: the sign does not change in between.
                for k in 1..100 {
                    let part = f64::from(k) / 100.0 * s;
                    let sign = |s: f64| body.signed_distance(point + s * direction) > 0.0;
                    assert_eq!(sign(part), sign(0.0));
                    assert_eq!(sign(-part), sign(0.0));
                }
            }
        }
    }

    #[test]
    fn a_line_that_passes_by_has_no_crossing() {
        for body in all() {
            assert_eq!(body.true_parameter(DVec3::X * 3.0, DVec3::Y), None);
        }
    }

    #[test]
    fn distances_are_true() {
        let origin = DVec3::ZERO;
        assert_eq!(Body::sphere_cube().signed_distance(origin), -1.0);
        assert_eq!(Body::cylinder().signed_distance(origin), -1.0);
        assert_eq!(Body::torus(6, 8).signed_distance(origin), 0.75);
        // The right triangle of legs 1 and 1.25 has the height 1.25 / sqrt(1 + 1.25^2).
        let expected = -1.25 / (1.0f64 + 1.25 * 1.25).sqrt();
        assert!((Body::cone().signed_distance(origin) - expected).abs() < 1e-15);
    }
}
