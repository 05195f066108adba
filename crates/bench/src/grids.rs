//! A tessellation as Embree's grids: one for two triangles that share an edge.

use glam::Vec3;
use rayon::prelude::*;

use curvetri::curved::Tessellation;
use curvetri::embree::Grid;
use curvetri::mesh::{Mesh, NO_TRIANGLE, Topology};

/// Two triangles, each with the corner that is not on the edge they share. A triangle that found no
/// other is alone.
type Pair = ((usize, usize), Option<(usize, usize)>);

/// The positions and the grids of a tessellation of a mesh.
pub(super) fn of(fine: &Tessellation, mesh: &Mesh) -> (Vec<Vec3>, Vec<Grid>) {
    let pairs = pairs(mesh);
    let level = fine.level();
    let places = level + 1;
    let positions = pairs
        .par_iter()
        .flat_map_iter(|pair| {
            let all = (0..places).flat_map(|y| (0..places).map(move |x| [x, y]));
            all.map(|place| fine.mesh().positions()[vertex(fine, pair, place) as usize])
        })
        .collect();
    let grids = (0..pairs.len() as u32)
        .map(|n| Grid {
            first: n * places * places,
            stride: places,
            width: places as u16,
            height: places as u16,
        })
        .collect();
    (positions, grids)
}

/// The vertex at a place of a pair's grid: the first triangle's far corner is at (0, 0), the other's
/// at the opposite one, and the edge they share runs between.
fn vertex(fine: &Tessellation, &(one, other): &Pair, [x, y]: [u32; 2]) -> u32 {
    let level = fine.level();
    let at = |(triangle, far): (usize, usize), [next, previous]: [u32; 2]| {
        let mut shares = [0; 3];
        shares[(far + 1) % 3] = next;
        shares[(far + 2) % 3] = previous;
        shares[far] = level - next - previous;
        fine.vertex(triangle, [shares[1], shares[2]])
    };
    match other {
        _ if x + y <= level => at(one, [x, y]),
        Some(other) => at(other, [level - x, level - y]),
        // folded onto the edge, without area
        None => at(one, [level - y, y]),
    }
}

/// Pairs triangles whose common edge is the longest of both first, as in quadrangles that were cut,
/// and then as it comes.
fn pairs(mesh: &Mesh) -> Vec<Pair> {
    let topology = Topology::new(mesh);
    let count = mesh.triangles().len();
    let longest = |triangle: usize| {
        let p = mesh.triangle_positions(triangle);
        let length = |k: usize| p[k].distance_squared(p[(k + 1) % 3]);
        (0..3)
            .max_by(|&a, &b| length(a).total_cmp(&length(b)))
            .unwrap_or(0)
    };
    // the neighbour's edge that is this one, run through the other way
    let across = |triangle: usize, k: usize| {
        let neighbour = topology.neighbours(triangle)[k];
        let ours = mesh.triangle_positions(triangle);
        (neighbour != NO_TRIANGLE && neighbour as usize != triangle).then_some(())?;
        let theirs = mesh.triangle_positions(neighbour as usize);
        let edge =
            (0..3).find(|&s| theirs[s] == ours[(k + 1) % 3] && theirs[(s + 1) % 3] == ours[k])?;
        Some((neighbour as usize, edge))
    };
    let mut free = vec![true; count];
    let mut pairs = Vec::with_capacity(count / 2 + 1);
    for only_longest in [true, false] {
        for triangle in 0..count {
            let edges = if only_longest {
                let k = longest(triangle);
                k..k + 1
            } else {
                0..3
            };
            let partner = edges.filter_map(|k| Some((k, across(triangle, k)?))).find(
                |&(_, (other, edge))| free[other] && (!only_longest || longest(other) == edge),
            );
            let Some((k, (other, edge))) = partner.filter(|_| free[triangle]) else {
                continue;
            };
            free[triangle] = false;
            free[other] = false;
            pairs.push(((triangle, (k + 2) % 3), Some((other, (edge + 2) % 3))));
        }
    }
    pairs.extend((0..count).filter(|&t| free[t]).map(|t| ((t, 0), None)));
    pairs
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use curvetri::curved::{CurvedMesh, CurvedOptions};
    use curvetri_bodies::{Blob, bumpy_torus};

    #[test]
    fn every_triangle_is_in_one_grid() {
        for mesh in [bumpy_torus(500), Blob::default().mesh()] {
            let mut seen = vec![0; mesh.triangles().len()];
            for ((one, _), other) in pairs(&mesh) {
                seen[one] += 1;
                if let Some((other, _)) = other {
                    seen[other] += 1;
                }
            }
            assert!(seen.iter().all(|&times| times == 1));
        }
    }

    #[test]
    fn a_torus_of_quadrangles_is_paired_without_rest() {
        let mesh = bumpy_torus(2000);
        assert_eq!(pairs(&mesh).len(), mesh.triangles().len() / 2);
    }

    #[test]
    fn grids_have_the_area_of_their_triangles() {
        let mesh = Arc::new(Blob::default().mesh());
        let curved = CurvedMesh::new(mesh.clone(), &CurvedOptions::default());
        let fine = curved.tessellate(3).unwrap();
        let (positions, grids) = of(&fine, &mesh);
        let area = |a: Vec3, b: Vec3, c: Vec3| f64::from((b - a).cross(c - a).length());
        let mut sum = 0.0;
        for grid in &grids {
            let at = |x: u32, y: u32| positions[(grid.first + y * grid.stride + x) as usize];
            for (x, y) in (0..3).flat_map(|y| (0..3).map(move |x| (x, y))) {
                let [a, b, c, d] = [at(x, y), at(x + 1, y), at(x, y + 1), at(x + 1, y + 1)];
                sum += area(a, b, c) + area(d, c, b);
            }
        }
        let triangles =
            (0..fine.mesh().triangles().len()).map(|t| fine.mesh().triangle_positions(t));
        let expected: f64 = triangles.map(|[a, b, c]| area(a, b, c)).sum();
        assert!((sum / expected - 1.0).abs() < 1e-5, "{sum} {expected}");
    }
}
