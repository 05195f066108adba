//! The peers: other curved triangles made of three vertices with normals, all of them polynomials.

use glam::DVec3;

use super::model::Peer;
use curvetri_bodies::BodyTriangle;

/// Boubekeur and Alexa's shape factor, the value they recommend.
const PHONG_SHAPE: f64 = 0.75;
/// Squared distance of two unit normals below which they are parallel to Nagata's formula.
const PARALLEL: f64 = 1e-24;

/// A triangular Bezier patch.
pub(super) struct Bezier {
    degree: usize,
    /// Control point (i, j, k) with `i + j + k = degree`, by k, then by j.
    points: Vec<DVec3>,
}

impl Bezier {
    pub fn new(peer: Peer, triangle: &BodyTriangle) -> Self {
        match peer {
            Peer::Pn => Self::pn(triangle),
            Peer::Phong => Self::quadratic(triangle, phong_middle),
            Peer::Nagata => Self::quadratic(triangle, nagata_middle),
        }
    }

    /// Vlachos, Peters, Boyd and Mitchell, "Curved PN triangles", 2001: the cubic of positions. (Their
    /// quadratic of normals is for shading; the geometric normal is this one's.)
    fn pn(t: &BodyTriangle) -> Self {
        let p = t.positions;
        // A third of the way from vertex i to vertex j, in the tangent plane of i.
        let near = |i: usize, j: usize| {
            let lift = (p[j] - p[i]).dot(t.normals[i]);
            (2.0 * p[i] + p[j] - lift * t.normals[i]) / 3.0
        };
        let [a, b, c] = p;
        let (ab, ba, bc) = (near(0, 1), near(1, 0), near(1, 2));
        let (cb, ca, ac) = (near(2, 1), near(2, 0), near(0, 2));
        let mean = (ab + ba + bc + cb + ca + ac) / 6.0;
        let centre = mean + 0.5 * (mean - (a + b + c) / 3.0);
        Self {
            degree: 3,
            points: vec![a, ab, ba, b, ac, centre, bc, ca, cb, c],
        }
    }

    /// The quadratic patch whose edges have these middle control points.
    fn quadratic(t: &BodyTriangle, middle: impl Fn(&BodyTriangle, usize, usize) -> DVec3) -> Self {
        let [a, b, c] = t.positions;
        let (ab, bc, ca) = (middle(t, 0, 1), middle(t, 1, 2), middle(t, 2, 0));
        Self {
            degree: 2,
            points: vec![a, ab, b, ca, bc, c],
        }
    }

    /// The position, and its derivatives by u and by v, by de Casteljau's algorithm.
    pub fn at(&self, [u, v]: [f64; 2]) -> [DVec3; 3] {
        let mut points = self.points.clone();
        for degree in (1..self.degree).rev() {
            points = step(&points, degree, [u, v]);
        }
        let [a, b, c] = [points[0], points[1], points[2]];
        let slope = self.degree as f64;
        [
            (1.0 - u - v) * a + u * b + v * c,
            slope * (b - a),
            slope * (c - a),
        ]
    }
}

/// One step of de Casteljau's algorithm, down to this degree.
fn step(points: &[DVec3], degree: usize, [u, v]: [f64; 2]) -> Vec<DVec3> {
    let mut reduced = Vec::with_capacity(points.len());
    let mut row = 0;
    for k in 0..=degree {
        // Rows of the higher degree have one point more.
        let above = row + degree + 2 - k;
        for j in 0..=degree - k {
            let (a, b, c) = (points[row + j], points[row + j + 1], points[above + j]);
            reduced.push((1.0 - u - v) * a + u * b + v * c);
        }
        row = above;
    }
    reduced
}

/// Boubekeur and Alexa, "Phong tessellation", 2008: between the edge's middle and its projections
/// onto the two tangent planes.
fn phong_middle(t: &BodyTriangle, i: usize, j: usize) -> DVec3 {
    let (p, q) = (t.positions[i], t.positions[j]);
    let onto = |at: usize, x: DVec3| {
        let normal = t.normals[at];
        x - (x - t.positions[at]).dot(normal) * normal
    };
    let flat = 0.5 * (p + q);
    let projected = 0.5 * (onto(i, q) + onto(j, p));
    flat + PHONG_SHAPE * (projected - flat)
}

/// Nagata, "Simple local interpolation of surfaces using normal vectors", 2005: the edge
/// `x + (d - c) s + c s^2` with the shortest `c` that makes it perpendicular to both normals.
fn nagata_middle(t: &BodyTriangle, i: usize, j: usize) -> DVec3 {
    let d = t.positions[j] - t.positions[i];
    let (sum, difference) = (t.normals[i] + t.normals[j], t.normals[i] - t.normals[j]);
    let along = |direction: DVec3, value: f64| {
        let length2 = direction.length_squared();
        if length2 < PARALLEL {
            DVec3::ZERO
        } else {
            direction * (value / length2)
        }
    };
    // n_i.c = n_i.d and n_j.c = -n_j.d, as sum and difference, which are perpendicular.
    let c = along(sum, difference.dot(d)) + along(difference, sum.dot(d));
    0.5 * (t.positions[i] + t.positions[j]) - 0.5 * c
}

#[cfg(test)]
mod tests {
    use super::*;
    use curvetri_bodies::Body;

    const PEERS: [Peer; 3] = [Peer::Pn, Peer::Phong, Peer::Nagata];

    fn normal([_, du, dv]: [DVec3; 3]) -> DVec3 {
        du.cross(dv).normalize()
    }

    #[test]
    fn corners_keep_their_places_and_pn_and_nagata_their_normals() {
        for t in Body::torus(12, 16).triangles() {
            for peer in PEERS {
                let bezier = Bezier::new(peer, t);
                for (i, at) in [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]].into_iter().enumerate() {
                    let point = bezier.at(at);
                    assert!(point[0].distance(t.positions[i]) < 1e-15);
                    // In a narrow corner Nagata's edges can cross each other, which turns the
                    // geometric normal over: it is the given one or its opposite.
                    let off = normal(point).cross(t.normals[i]).length();
                    assert!(peer == Peer::Phong || off < 1e-12, "{peer:?}: {off}");
                    let turned = normal(point).dot(t.normals[i]) < 0.0;
                    assert!(peer == Peer::Nagata || !turned, "{peer:?}");
                }
            }
        }
    }

    #[test]
    fn derivatives_are_those_of_the_position() {
        let t = &Body::torus(12, 16).triangles()[5].clone();
        let step = 1e-6;
        for peer in PEERS {
            let bezier = Bezier::new(peer, t);
            let [u, v] = [0.3, 0.45];
            let [_, du, dv] = bezier.at([u, v]);
            let between = |a: [f64; 2], b: [f64; 2]| (bezier.at(b)[0] - bezier.at(a)[0]) / step;
            assert!(between([u - step / 2.0, v], [u + step / 2.0, v]).distance(du) < 1e-9);
            assert!(between([u, v - step / 2.0], [u, v + step / 2.0]).distance(dv) < 1e-9);
        }
    }

    #[test]
    fn phong_is_what_its_definition_says() {
        let t = &Body::torus(12, 16).triangles()[7].clone();
        let b = [0.2, 0.5, 0.3];
        let flat: DVec3 = (0..3).map(|i| b[i] * t.positions[i]).sum();
        let onto = |i: usize| flat - (flat - t.positions[i]).dot(t.normals[i]) * t.normals[i];
        let projected: DVec3 = (0..3).map(|i| b[i] * onto(i)).sum();
        let expected = 0.25 * flat + 0.75 * projected;
        let point = Bezier::new(Peer::Phong, t).at([b[1], b[2]])[0];
        assert!(point.distance(expected) < 1e-15);
    }
}
