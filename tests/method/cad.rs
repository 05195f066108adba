//! CAD parts with hard edges, simplified to a third: the curved surface is no worse than the flat
//! triangles, because hard edges stay hard.

use std::sync::Arc;

use curvetri::curved::{CurvedMesh, CurvedOptions};
use curvetri::mesh::{Mesh, NormalOptions, NormalsPolicy, RawMesh};
use curvetri::method::Surface;
use curvetri_bodies::SplitMix;
use curvetri_test_support::Body;
use glam::{DVec3, Vec3};
use rayon::prelude::*;

/// How much further off than flat triangles the curved surface may be, on the average.
const MAX_RATIO: f64 = 1.1;
/// Points that are measured.
const SAMPLES: usize = 4_000;

/// The mesh with about a third of its triangles, on some of its vertices. Vertices of split normals
/// stay on their hard edges.
fn third(mesh: &Mesh) -> Mesh {
    let vertices: Vec<[f32; 3]> = mesh.positions().iter().map(|p| p.to_array()).collect();
    let bytes: Vec<u8> = vertices
        .as_flattened()
        .iter()
        .flat_map(|x| x.to_ne_bytes())
        .collect();
    let adapter = meshopt::VertexDataAdapter::new(&bytes, 12, 0).unwrap();
    let indices = mesh.triangles().as_flattened();
    let wanted = indices.len() / 9 * 3;
    let options = meshopt::SimplifyOptions::None;
    let kept = meshopt::simplify(indices, &adapter, wanted, 1.0, options, None);
    Mesh::new(
        (0..vertices.len())
            .map(|v| mesh.world_position(v))
            .collect(),
        Some(mesh.normals().iter().map(|n| n.as_dvec3()).collect()),
        kept.as_chunks::<3>().0.to_vec(),
    )
    .unwrap()
}

/// The same triangles with normals that know no hard edges.
fn without_hard_edges(mesh: &Mesh) -> Mesh {
    let raw = RawMesh {
        positions: (0..mesh.positions().len())
            .map(|v| mesh.world_position(v))
            .collect(),
        corners: mesh.triangles().to_vec(),
        ..RawMesh::default()
    };
    let options = NormalOptions {
        policy: NormalsPolicy::Smooth,
        crease_angle_degrees: Some(180.0),
    };
    raw.into_mesh(&options).unwrap().0
}

/// How far points of the surface over a coarse mesh are from a fine one, on the average; of the
/// curved surface, and of the flat triangles themselves.
fn mean_distances(coarse: Mesh, fine: &Mesh) -> [f64; 2] {
    let options = CurvedOptions {
        surface: Surface::default(),
        ..CurvedOptions::default()
    };
    let curved = CurvedMesh::new(Arc::new(coarse), &options);
    let mesh = curved.mesh();
    // Points are spread over the triangles by their area.
    let mut areas = Vec::new();
    let mut sum = 0.0;
    for triangle in 0..mesh.triangles().len() {
        let [a, b, c] = mesh.triangle_positions(triangle);
        sum += (b - a).cross(c - a).length();
        areas.push(sum);
    }
    let mut random = SplitMix::new(5);
    let points: Vec<[Vec3; 2]> = (0..SAMPLES)
        .map(|_| {
            let at = random.unit_f32() * sum;
            let triangle = areas
                .partition_point(|&area| area < at)
                .min(areas.len() - 1);
            let [w, u, v] = random.barycentric();
            let [a, b, c] = mesh.triangle_positions(triangle);
            let on_curved = curved.patch(triangle as u32).point(u, v).position;
            [on_curved.into(), a * w + b * u + c * v]
        })
        .collect();
    let triangles: Vec<[DVec3; 3]> = (0..fine.triangles().len())
        .map(|t| fine.triangle_positions(t).map(|p| p.as_dvec3()))
        .collect();
    let shift = mesh.origin() - fine.origin();
    [0, 1].map(|which| {
        let distances = points.par_iter().map(|both| {
            let p = both[which].as_dvec3() + shift;
            let squared = triangles.iter().map(|t| p.distance_squared(nearest(p, *t)));
            squared.fold(f64::INFINITY, f64::min).sqrt()
        });
        distances.sum::<f64>() / SAMPLES as f64
    })
}

/// The point of a triangle nearest to a point: Ericson, Real-Time Collision Detection, 5.1.5.
fn nearest(p: DVec3, [a, b, c]: [DVec3; 3]) -> DVec3 {
    let (ab, ac, ap) = (b - a, c - a, p - a);
    let (d1, d2) = (ab.dot(ap), ac.dot(ap));
    if d1 <= 0.0 && d2 <= 0.0 {
        return a;
    }
    let bp = p - b;
    let (d3, d4) = (ab.dot(bp), ac.dot(bp));
    if d3 >= 0.0 && d4 <= d3 {
        return b;
    }
    let vc = d1 * d4 - d3 * d2;
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        return a + ab * (d1 / (d1 - d3));
    }
    let cp = p - c;
    let (d5, d6) = (ab.dot(cp), ac.dot(cp));
    if d6 >= 0.0 && d5 <= d6 {
        return c;
    }
    let vb = d5 * d2 - d1 * d6;
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        return a + ac * (d2 / (d2 - d6));
    }
    let va = d3 * d6 - d5 * d4;
    if va <= 0.0 && d4 >= d3 && d5 >= d6 {
        return b + (c - b) * ((d4 - d3) / ((d4 - d3) + (d5 - d6)));
    }
    let sum = va + vb + vc;
    a + ab * (vb / sum) + ac * (vc / sum)
}

fn check(name: &str, fine: &Mesh) {
    let coarse = third(fine);
    let [curved, flat] = mean_distances(coarse.clone(), fine);
    let [rounded, _] = mean_distances(without_hard_edges(&coarse), fine);
    println!(
        "{name}: {} of {} triangles, curved {curved:.3e}, flat {flat:.3e}, ratio {:.3}, without \
         hard edges {:.1}",
        coarse.triangles().len(),
        fine.triangles().len(),
        curved / flat,
        rounded / flat
    );
    let share = coarse.triangles().len() as f64 / fine.triangles().len() as f64;
    assert!(share < 0.4, "{name} was not simplified: {share}");
    assert!(curved <= MAX_RATIO * flat, "{name}: {curved} and {flat}");
    assert!(
        rounded > 2.0 * curved,
        "{name} is not about hard edges: {rounded} without them"
    );
}

#[test]
fn simplified_made_parts_are_no_worse_than_flat() {
    for (name, height) in [("cylinder", 1.5), ("long cylinder", 3.0)] {
        let fine = curvetri_bodies::capped_cylinder(192, height);
        check(name, &fine);
    }
}

#[test]
fn simplified_real_parts_are_no_worse_than_flat() {
    // Finely cut parts with hard edges: where coarse facets with smooth normals are the reference,
    // curving them is no error.
    let parts = ["fandisk.obj", "cad_feature.stl"];
    for Body { name, mesh } in curvetri_test_support::real_meshes(&parts) {
        check(&name, &mesh);
    }
}
