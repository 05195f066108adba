//! Meshes of bodies of revolution, from profiles in the plane of radius and height.

use glam::{DVec2, DVec3};

use curvetri_mesh::Mesh;

/// A point of a profile (radius, height) and the profile's normal there, of any length.
pub(super) type ProfilePoint = (DVec2, DVec2);

/// Triangles with a normal at each corner, put together without indices: equal corners become one
/// vertex in the end.
#[derive(Default)]
pub(super) struct Soup {
    positions: Vec<DVec3>,
    normals: Vec<DVec3>,
}

impl Soup {
    /// Adds a triangle, unless two corners are one.
    pub(super) fn triangle(&mut self, corners: [(DVec3, DVec3); 3]) {
        let [a, b, c] = corners.map(|c| c.0);
        if a == b || b == c || c == a {
            return;
        }
        self.positions.extend(corners.map(|c| c.0));
        self.normals.extend(corners.map(|c| c.1));
    }

    /// Adds a quad, cut from its first corner to its third.
    pub(super) fn quad(&mut self, [a, b, c, d]: [(DVec3, DVec3); 4]) {
        self.triangle([a, b, c]);
        self.triangle([a, c, d]);
    }

    /// Adds a flat fan around `centre` that fills a closed outline, counter-clockwise seen from
    /// where its `normal` points.
    pub(super) fn cap(&mut self, outline: &[DVec3], centre: DVec3, normal: DVec3) {
        for (i, &p) in outline.iter().enumerate() {
            let next = outline[(i + 1) % outline.len()];
            self.triangle([(centre, normal), (p, normal), (next, normal)]);
        }
    }

    /// Adds all triangles of another.
    pub(super) fn append(&mut self, mut other: Soup) {
        self.positions.append(&mut other.positions);
        self.normals.append(&mut other.normals);
    }

    pub(super) fn mesh(self) -> Mesh {
        let count = self.positions.len() as u32 / 3;
        let triangles = (0..count).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
        Mesh::new(self.positions, Some(self.normals), triangles).expect("a made body is a mesh")
    }
}

/// A body around the z axis.
pub(super) struct Revolution {
    /// Points around the axis at radius 1, counter-clockwise, and the outward normals there.
    around: Vec<(DVec2, DVec2)>,
    soup: Soup,
}

impl Revolution {
    pub(super) fn new(around: Vec<(DVec2, DVec2)>) -> Revolution {
        Revolution {
            around,
            soup: Soup::default(),
        }
    }

    fn corner(&self, i: usize, (point, normal): ProfilePoint) -> (DVec3, DVec3) {
        let (place, outward) = self.around[i % self.around.len()];
        (
            (point.x * place).extend(point.y),
            (normal.x * outward).extend(normal.y),
        )
    }

    /// Adds the wall between two points of the profile, the first below the second where the
    /// normal points outward.
    pub(super) fn band(&mut self, [below, above]: [ProfilePoint; 2]) {
        for i in 0..self.around.len() {
            let q = [(i, below), (i + 1, below), (i + 1, above), (i, above)];
            self.soup.quad(q.map(|(i, point)| self.corner(i, point)));
        }
    }

    /// Adds a wall from a base to an apex on the axis, where each triangle has its own normal.
    pub(super) fn cone(&mut self, base: ProfilePoint, apex: ProfilePoint) {
        for i in 0..self.around.len() {
            let ends = [self.corner(i, base), self.corner(i + 1, base)];
            let (point, from) = self.corner(i, apex);
            let to = self.corner(i + 1, apex).1;
            let middle = (from.normalize() + to.normalize()).truncate().normalize();
            let normal = (apex.1.x * middle).extend(apex.1.y);
            self.soup.triangle([ends[0], ends[1], (point, normal)]);
        }
    }

    /// Adds a flat disc up to a point of the profile, its normal up (1) or down (-1).
    pub(super) fn disc(&mut self, rim: DVec2, up: f64) {
        let mut outline: Vec<DVec3> = (0..self.around.len())
            .map(|i| self.corner(i, (rim, DVec2::X)).0)
            .collect();
        if up < 0.0 {
            outline.reverse();
        }
        self.soup.cap(&outline, rim.y * DVec3::Z, up * DVec3::Z);
    }

    pub(super) fn soup(self) -> Soup {
        self.soup
    }

    pub(super) fn mesh(self) -> Mesh {
        self.soup.mesh()
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use curvetri_mesh::{Topology, TopologyCounts};

    /// Checks that a mesh is closed and wound outward, has no triangle without area, and that the
    /// normals' cosines to their triangles are at least `least`.
    pub fn check_closed(mesh: &Mesh, least: f32) -> TopologyCounts {
        let counts = *Topology::new(mesh).counts();
        assert!(counts.is_closed(), "{counts:?}");
        assert_eq!(counts.degenerate_triangles + counts.duplicate_triangles, 0);
        let mut volume = 0.0;
        for t in 0..mesh.triangles().len() {
            let [a, b, c] = mesh.triangle_positions(t);
            let face = (b - a).cross(c - a).normalize();
            for n in mesh.triangle_normals(t) {
                assert!(n.is_normalized());
                assert!(n.dot(face) >= least, "triangle {t}: {} {n}", n.dot(face));
            }
            volume += a.as_dvec3().dot(b.as_dvec3().cross(c.as_dvec3()));
        }
        assert!(volume > 0.0, "the mesh is inside out");
        counts
    }
}
