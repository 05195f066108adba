//! A mesh of any numbers, and rays of any numbers at it: what has to hold of every hit.

use std::sync::{Arc, OnceLock};

use arbitrary::Unstructured;
use curvetri::curved::{CurvedMesh, CurvedOptions, Primitives};
use curvetri::embree::{
    Device, Geometry, Hit, LEAST_COMPONENT, QueryOptions, Ray, RayPacket, Scene, SceneBuilder,
    Traced, Width,
};
use curvetri::mesh::{Mesh, NormalOptions, NormalsPolicy, RawMesh, Topology};
use curvetri::method::{BoundsKind, Solver, Surface};
use glam::{DVec3, Vec3};

/// How far outside its triangle a hit's foot may lie, in barycentric coordinates.
const OUTSIDE: f32 = 1e-4;

const MOST_VERTICES: u8 = 48;
const MOST_TRIANGLES: u8 = 64;
const RAYS: usize = 16;

/// Reads bytes as a mesh, options and rays (zeros where they end), traces the rays one by one and
/// in packets of every width, and checks the hits.
///
/// | bytes | meaning |
/// |---|---|
/// | 1 | the surface |
/// | 1 | bits: 0 ITA, 1 unchecked, 2 single precision, 3 robust, 4 stored normals, 5 spheres, 6 triangles, 7 a tolerance |
/// | 1 | the crease angle in degrees |
/// | 1, 1 | how many vertices and triangles |
/// | 4 or 8 each | coordinates of the positions |
/// | 4 each | coordinates of the normals, where stored |
/// | 1 each | the triangles' vertices |
/// | | sixteen rays, see `ray` |
pub fn cast_rays(data: &[u8]) {
    super::one_thread();
    let mut bytes = Unstructured::new(data);
    let options = Options::read(&mut bytes);
    let Ok((mesh, _)) = options.raw(&mut bytes).into_mesh(&options.normals) else {
        return;
    };
    let mesh = Arc::new(mesh);
    check_topology(&mesh);
    let curved = Arc::new(CurvedMesh::new(mesh.clone(), &options.curved));
    assert_eq!(curved.kinds().total(), mesh.triangles().len());
    let scene = scene(&curved, options.robust);
    let rays: [Ray; RAYS] = std::array::from_fn(|_| ray(&mut bytes, &mesh));
    let singly = rays.map(|ray| scene.intersect1(&ray, &QueryOptions::INCOHERENT));
    let comparable =
        rays.map(|ray| is_sharp(&ray, &mesh) && !leaves_a_box(&curved, &ray, &options));
    let told = Told {
        rays,
        singly,
        comparable,
    };
    for ((ray, hit), comparable) in told.rays.iter().zip(&told.singly).zip(told.comparable) {
        check(&curved, ray, hit.as_ref());
        let occluded = scene.occluded1(ray, &QueryOptions::INCOHERENT);
        assert!(occluded == hit.is_some() || !comparable, "{ray:?} {hit:?}");
    }
    for how in [QueryOptions::INCOHERENT, QueryOptions::COHERENT] {
        compare::<4>(&scene, &mesh, &told, &how);
        compare::<8>(&scene, &mesh, &told, &how);
        compare::<16>(&scene, &mesh, &told, &how);
    }
}

/// Rays and what each of them meets alone.
struct Told {
    rays: [Ray; RAYS],
    singly: [Option<Hit>; RAYS],
    /// Whether that does not depend on the way that the tree is walked.
    comparable: [bool; RAYS],
}

/// What is asked for, besides the numbers.
struct Options {
    curved: CurvedOptions,
    normals: NormalOptions,
    single_precision: bool,
    robust: bool,
    stored: bool,
    vertices: u8,
    triangles: u8,
}

fn byte(bytes: &mut Unstructured<'_>) -> u8 {
    bytes.arbitrary().unwrap_or_default()
}

fn float(bytes: &mut Unstructured<'_>) -> f32 {
    bytes.arbitrary().unwrap_or_default()
}

fn vector(bytes: &mut Unstructured<'_>) -> Vec3 {
    Vec3::from_array(std::array::from_fn(|_| float(bytes)))
}

impl Options {
    fn read(bytes: &mut Unstructured<'_>) -> Options {
        let surface = Surface::ALL[usize::from(byte(bytes)) % Surface::ALL.len()];
        let bits = byte(bytes);
        let bit = |k: u32| bits & 1 << k != 0;
        let solver = match bit(0) {
            true => Solver::ITA,
            false => Solver::default(),
        };
        Options {
            curved: CurvedOptions {
                surface,
                solver,
                bounds: match bit(5) {
                    true => BoundsKind::Sphere,
                    false => BoundsKind::default(),
                },
                primitives: match bit(6) {
                    true => Primitives::Triangles,
                    false => Primitives::Clusters,
                },
                tolerance: if bit(7) { 0.01 } else { 0.0 },
                unchecked: bit(1),
                // Flat triangles stay inside: Embree's own are rounded another way in packets.
                ..CurvedOptions::default()
            },
            normals: NormalOptions {
                policy: NormalsPolicy::Stored,
                crease_angle_degrees: Some(byte(bytes).into()),
            },
            single_precision: bit(2),
            robust: bit(3),
            stored: bit(4),
            vertices: 1 + byte(bytes) % MOST_VERTICES,
            triangles: 1 + byte(bytes) % MOST_TRIANGLES,
        }
    }

    fn raw(&self, bytes: &mut Unstructured<'_>) -> RawMesh {
        let positions = (0..self.vertices).map(|_| match self.single_precision {
            true => vector(bytes).as_dvec3(),
            false => DVec3::from_array(std::array::from_fn(|_| {
                bytes.arbitrary().unwrap_or_default()
            })),
        });
        let positions: Vec<DVec3> = positions.collect();
        let stored = if self.stored { self.vertices } else { 0 };
        let normals = (0..stored).map(|_| vector(bytes).as_dvec3()).collect();
        let corner = |bytes: &mut Unstructured<'_>| u32::from(byte(bytes) % self.vertices);
        let corners = (0..self.triangles).map(|_| std::array::from_fn(|_| corner(bytes)));
        let corners: Vec<[u32; 3]> = corners.collect();
        RawMesh {
            normal_corners: self.stored.then(|| corners.clone()),
            positions,
            corners,
            normals,
            ..RawMesh::default()
        }
    }
}

fn check_topology(mesh: &Mesh) {
    let topology = Topology::new(mesh);
    for triangle in 0..mesh.triangles().len() {
        for other in topology.neighbours(triangle) {
            let back = |t: u32| topology.neighbours(t as usize).contains(&(triangle as u32));
            assert!(other as usize >= mesh.triangles().len() || back(other));
        }
    }
}

fn scene(curved: &Arc<CurvedMesh>, robust: bool) -> Scene {
    static DEVICE: OnceLock<Device> = OnceLock::new();
    let device = DEVICE.get_or_init(|| curvetri::linked::device_with_config("threads=1").expect("Embree is there"));
    let geometry = Geometry::user(device, curved.clone()).and_then(|g| g.commit());
    let mut builder = SceneBuilder::new(device).expect("a scene").robust(robust);
    builder.attach(&geometry.expect("a geometry"));
    builder.commit().expect("a tree")
}

/// A ray of any numbers, or towards a point of a triangle from a given distance or from anywhere.
fn ray(bytes: &mut Unstructured<'_>, mesh: &Mesh) -> Ray {
    let how = byte(bytes);
    let origin = vector(bytes);
    let ray = if how & 1 == 0 {
        Ray::new(origin, vector(bytes))
    } else {
        let triangle = usize::from(byte(bytes)) % mesh.triangles().len();
        let [a, b, c] = mesh.triangle_positions(triangle);
        let [u, v] = [0; 2].map(|_| f32::from(byte(bytes)) / 128.0);
        let target = a + u * (b - a) + v * (c - a);
        let size = (b - a).abs().max((c - a).abs()).max_element();
        match how & 2 {
            0 => Ray::new(origin, target - origin),
            _ => Ray::new(target + size * origin, -origin),
        }
    };
    match how & 4 {
        0 => ray,
        _ => ray.between(float(bytes), float(bytes)),
    }
}

fn check(curved: &CurvedMesh, ray: &Ray, hit: Option<&Hit>) {
    let Some(hit) = hit else { return };
    let what = || format!("{ray:?} {hit:?} {:?}", curved.mesh());
    assert!(ray.is_traceable(), "{}", what());
    assert!(hit.t.is_finite(), "{}", what());
    assert!((ray.tnear..=ray.tfar).contains(&hit.t), "{}", what());
    assert!((hit.prim_id as usize) < curved.mesh().triangles().len());
    let barycentric = [hit.u, hit.v, 1.0 - hit.u - hit.v];
    assert!(barycentric.iter().all(|&b| b >= -OUTSIDE), "{}", what());
    assert!(hit.ng.is_finite() && hit.ng != Vec3::ZERO, "{}", what());
    let bound = curved.error_bound(hit.prim_id, ray, hit.t);
    assert!(bound.is_finite() && bound >= 0.0, "{bound} {}", what());
}

/// Whether rounding of the ray's way is nothing to the smallest of the triangles, and its direction is not less
/// than what Embree computes with: what any other ray meets is up to the way that the tree is walked.
fn is_sharp(ray: &Ray, mesh: &Mesh) -> bool {
    let triangles = 0..mesh.triangles().len();
    let least = triangles.map(|triangle| {
        let [a, b, c] = mesh.triangle_positions(triangle);
        // Not by the distance, whose square may be too small a number.
        let [a, b] = [b - a, c - a].map(|side| side.abs().max_element());
        a.max(b)
    });
    let least = least.filter(|&size| size > 0.0).fold(f32::MAX, f32::min);
    let furthest = mesh.positions().iter().map(|p| p.length());
    let away = furthest.fold(ray.origin.length(), f32::max);
    let tiny = ray.direction.abs().max_element() < LEAST_COMPONENT / f32::EPSILON;
    f32::EPSILON * away < SHARP * least && !tiny
}

/// Whether a ray meets a patch beyond its box: a packet comes there with the rays beside it, and one ray alone
/// does not. The rim by which neighbours overlap reaches out of the box a little; what is not in the rim is
/// surely in the box where the surface was checked.
fn leaves_a_box(curved: &CurvedMesh, ray: &Ray, options: &Options) -> bool {
    let kernel_ray = curvetri::method::Ray {
        origin: ray.origin.into(),
        direction: ray.direction.into(),
        tnear: ray.tnear,
        tfar: ray.tfar,
    };
    (0..curved.mesh().triangles().len() as u32).any(|triangle| {
        let patch = curved.patch(triangle);
        let [lower, upper] = patch.bounds().map(Vec3::from);
        let hit = patch.intersect(&kernel_ray, options.curved.solver);
        let at = ray.at(hit.t);
        let free = options.curved.unchecked || is_beside([hit.u, hit.v]);
        hit.found && free && at.clamp(lower, upper) != at
    })
}

/// Rounding of a ray's way that does not matter, in sizes of a triangle.
const SHARP: f32 = 1e-3;

/// How far a ray may come off the surface between hits, in sizes of the mesh, of which one is beside its triangle.
const BESIDE: f32 = 1e-3;

/// Whether these coordinates are in the rim by which neighbours overlap, or were moved from there onto the
/// side.
fn is_beside([u, v]: [f32; 2]) -> bool {
    u <= 0.0 || v <= 0.0 || u + v >= 1.0 - f32::EPSILON
}

/// Sets packets beside single rays: the same, but where two triangles are met at the same t (within
/// rounding) either may be named.
fn compare<const N: usize>(scene: &Scene, mesh: &Mesh, told: &Told, how: &QueryOptions<'_>)
where
    Width<N>: Traced,
{
    let size = mesh.bounds().diagonal() as f32;
    for first in (0..RAYS).step_by(N) {
        let rays = &told.rays[first..][..N];
        let mut packet = RayPacket::<N>::from_rays(rays);
        let mut shadows = packet.clone();
        scene.intersect(&mut packet, how);
        let occluded = scene.occluded(&mut shadows, how);
        for (lane, ray) in rays.iter().enumerate() {
            let single = &told.singly[first + lane];
            if !told.comparable[first + lane] {
                continue;
            }
            let hit = packet.hit(lane);
            let same = match (single, &hit) {
                (Some(a), Some(b)) if a.prim_id == b.prim_id => a == b,
                (Some(a), Some(b)) => {
                    let apart = (a.t - b.t).abs();
                    // A ray at a grazing angle goes far within rounding.
                    let off = [a, b].map(|hit| apart * ray.direction.dot(hit.ng.normalize()).abs());
                    apart <= 4.0 * f32::EPSILON * a.t.abs()
                        || (is_beside([a.u, a.v]) || is_beside([b.u, b.v]))
                            && off[0].min(off[1]) <= BESIDE * size
                }
                (a, b) => a.is_none() && b.is_none(),
            };
            assert!(same, "packets of {N}: {ray:?} {single:?}, but {hit:?}");
            assert_eq!(occluded & 1 << lane != 0, single.is_some(), "{ray:?}");
        }
    }
}
