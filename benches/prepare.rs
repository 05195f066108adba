//! Seconds to make a mesh ready for rays, by part: how its triangles share sides, what is kept of each
//! and its box, all of it with the grouping, and Embree's tree; beside Embree's flat triangles. On a
//! bumpy torus whose vertices and triangles are shuffled.
//!
//! Run with `cargo bench --bench prepare`; `DIVAN_MIN_TIME=2` makes it more certain.

use std::sync::Arc;

use curvetri::curved::{CurvedMesh, CurvedOptions};
use curvetri::embree::{Device, Geometry, GeometryBuilder, SceneBuilder};
use curvetri::mesh::{Mesh, Topology};
use curvetri_bodies::{SplitMix, bumpy_torus};
use curvetri_method::{BuiltPatch, PatchFlags, TriangleVertices, Vector};
use divan::counter::ItemsCount;
use divan::{Bencher, black_box};

fn main() {
    divan::main();
}

const SIZES: [usize; 2] = [100_000, 1_000_000];

fn torus(triangles: usize) -> Arc<Mesh> {
    let mesh = bumpy_torus(triangles);
    let mut random = SplitMix::new(1);
    let mut place: Vec<u32> = (0..mesh.positions().len() as u32).collect();
    random.shuffle(&mut place);
    let mut positions = vec![glam::DVec3::ZERO; place.len()];
    let mut normals = positions.clone();
    for (old, &new) in place.iter().enumerate() {
        positions[new as usize] = mesh.positions()[old].as_dvec3();
        normals[new as usize] = mesh.normals()[old].as_dvec3();
    }
    let triangles = mesh.triangles().iter();
    let mut triangles: Vec<_> = triangles.map(|t| t.map(|v| place[v as usize])).collect();
    random.shuffle(&mut triangles);
    Arc::new(Mesh::new(positions, Some(normals), triangles).expect("a torus is a mesh"))
}

fn counted<'a, 'b>(bencher: Bencher<'a, 'b>, mesh: &Mesh) -> Bencher<'a, 'b> {
    bencher.counter(ItemsCount::new(mesh.triangles().len()))
}

#[divan::bench(args = SIZES)]
fn topology(bencher: Bencher<'_, '_>, triangles: usize) {
    let mesh = torus(triangles);
    counted(bencher, &mesh).bench_local(|| Topology::new(&mesh));
}

/// On one thread.
#[divan::bench(args = SIZES)]
fn patches(bencher: Bencher<'_, '_>, triangles: usize) {
    let mesh = torus(triangles);
    let corners = |triangle: usize| TriangleVertices {
        positions: mesh.triangle_positions(triangle).map(Vector::from),
        normals: mesh.triangle_normals(triangle).map(Vector::from),
    };
    let all: Vec<_> = (0..mesh.triangles().len()).map(corners).collect();
    counted(bencher, &mesh).bench_local(|| {
        BuiltPatch::each(&all, PatchFlags::default(), |_, prepared| {
            black_box(prepared);
        });
    });
}

#[divan::bench(args = SIZES)]
fn curved(bencher: Bencher<'_, '_>, triangles: usize) {
    let mesh = torus(triangles);
    counted(bencher, &mesh)
        .bench_local(|| CurvedMesh::new(mesh.clone(), &CurvedOptions::default()));
}

fn commit(device: &Device, geometry: GeometryBuilder) {
    let mut builder = SceneBuilder::new(device).expect("a scene");
    builder.attach(&geometry.commit().expect("a geometry"));
    black_box(builder.commit().expect("a scene"));
}

#[divan::bench(args = SIZES)]
fn curved_tree(bencher: Bencher<'_, '_>, triangles: usize) {
    let mesh = torus(triangles);
    let curved = Arc::new(CurvedMesh::new(mesh.clone(), &CurvedOptions::default()));
    let device = curvetri::linked::device().expect("a device");
    counted(bencher, &mesh).bench_local(|| {
        commit(
            &device,
            Geometry::user(&device, curved.clone()).expect("a geometry"),
        );
    });
}

#[divan::bench(args = SIZES)]
fn flat_tree(bencher: Bencher<'_, '_>, triangles: usize) {
    let mesh = torus(triangles);
    let device = curvetri::linked::device().expect("a device");
    counted(bencher, &mesh).bench_local(|| {
        let geometry = Geometry::triangles(&device, mesh.positions(), mesh.triangles());
        commit(&device, geometry.expect("a geometry"));
    });
}
