//! T-junctions: vertices that lie within an open edge of another triangle.

use glam::{DVec3, Vec3};
use rayon::prelude::*;

use super::{EdgeKind, Topology};
use crate::mesh::Mesh;

/// How near to an edge a vertex lies that is meant to be on it, in lengths of the edge.
const NEAR: f64 = 1e-4;

/// A direction along which no usual mesh lies in layers.
const DIRECTION: DVec3 = DVec3::new(0.541_196_1, 0.618_034, 0.570_796_3);

/// How many vertices are tried for one edge: so many only lie there in files made to be slow.
const MAX_TRIED: usize = 4096;

/// How many open edges have another open edge's end within them. On a curved surface the long edge
/// bends away from that vertex, and a hole opens.
///
/// Of edges with thousands of open ends beside them only so many are looked at.
#[must_use]
pub fn t_junctions(mesh: &Mesh, topology: &Topology) -> u64 {
    let edges: Vec<[Vec3; 2]> = (0..mesh.triangles().len())
        .into_par_iter()
        .flat_map_iter(|triangle| {
            let p = mesh.triangle_positions(triangle);
            let open = move |k: &usize| topology.edge(triangle, *k) == EdgeKind::Boundary;
            (0..3).filter(open).map(move |k| [p[k], p[(k + 1) % 3]])
        })
        .collect();
    let key = |p: Vec3| p.as_dvec3().dot(DIRECTION);
    let mut ends: Vec<(f64, Vec3)> = edges.iter().map(|s| (key(s[0]), s[0])).collect();
    ends.par_sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
    let has_one = |edge: &&[Vec3; 2]| {
        let keys = edge.map(key);
        let [low, high] = [keys[0].min(keys[1]), keys[0].max(keys[1])];
        let first = ends.partition_point(|end| end.0 < low);
        let between = ends[first..].iter().take(MAX_TRIED);
        let mut between = between.take_while(|end| end.0 <= high);
        between.any(|end| is_within(end.1, edge))
    };
    edges.par_iter().filter(has_one).count() as u64
}

/// Whether a point lies on a segment, between its ends.
fn is_within(p: Vec3, [a, b]: &[Vec3; 2]) -> bool {
    let [p, a, b] = [p, *a, *b].map(|p| p.as_dvec3());
    let (along, length) = (b - a, a.distance(b));
    let share = (p - a).dot(along) / (length * length);
    // Ends are no junctions, nor is what lies so near to them.
    (10.0 * NEAR..1.0 - 10.0 * NEAR).contains(&share)
        && p.distance(a + share * along) <= NEAR * length
}

#[cfg(test)]
mod tests {
    use super::*;

    fn junctions(middle: [f64; 2]) -> u64 {
        // A large triangle below the x axis and two small ones above it that meet at the middle.
        let corners = [[0., 0.], [2., 0.], [1., -1.], middle, [0.5, 1.], [1.5, 1.]];
        let positions = corners.map(|[x, y]| DVec3::new(x, y, 0.0)).to_vec();
        let triangles = vec![[0, 2, 1], [0, 3, 4], [3, 1, 5], [3, 5, 4]];
        let mesh = Mesh::new(positions, None, triangles).unwrap();
        t_junctions(&mesh, &Topology::new(&mesh))
    }

    #[test]
    fn a_vertex_within_an_open_side_is_found() {
        assert_eq!(junctions([1.0, 0.0]), 1);
        assert_eq!(junctions([0.3, 1e-5]), 1);
        assert_eq!(junctions([1.0, 0.1]), 0);
    }
}
