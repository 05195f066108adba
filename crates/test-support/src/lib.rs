//! What the whole-program tests share: bodies to trace, rays to trace them with.
//!
//! Everything here panics where something is wrong, as tests do.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use curvetri::curved::{CurvedMesh, CurvedOptions, FlatTriangles};
use curvetri::embree::{
    Device, GeometryBuilder, QueryOptions, Ray, RayPacket, Scene, SceneBuilder,
};
use curvetri::mesh::{Loader, Mesh, Topology};
use curvetri::method::{Solver, Surface};
use curvetri_bodies::{Blob, SplitMix};
use glam::Vec3;

/// A mesh to be traced.
pub struct Body {
    /// What messages call it.
    pub name: String,
    /// Its triangles.
    pub mesh: Arc<Mesh>,
}

/// A mesh as a committed scene of its own.
pub struct Traced {
    /// What messages call it.
    pub name: String,
    /// The curved surface.
    pub curved: Arc<CurvedMesh>,
    /// A robust scene of it alone.
    pub scene: Scene,
}

impl Body {
    /// With this surface, and all else by default.
    pub fn traced(&self, surface: Surface) -> Traced {
        self.traced_by(surface, Solver::default())
    }

    /// With this surface and root finder.
    pub fn traced_by(&self, surface: Surface, solver: Solver) -> Traced {
        self.traced_with(&CurvedOptions {
            surface,
            solver,
            ..CurvedOptions::default()
        })
    }

    /// # Panics
    /// If Embree is missing or refuses the mesh.
    pub fn traced_with(&self, options: &CurvedOptions) -> Traced {
        let device = curvetri::linked::device().expect("Embree is installed");
        let curved = Arc::new(CurvedMesh::new(self.mesh.clone(), options));
        let scene = together(&device, curved.geometries(&device).unwrap());
        Traced {
            name: self.name.clone(),
            curved,
            scene,
        }
    }
}

/// Every surface as it is by default, flat triangles as Embree's own, and the paper's own form.
pub fn all_forms() -> Vec<CurvedOptions> {
    let by_default = Surface::ALL.map(|surface| CurvedOptions {
        surface,
        ..CurvedOptions::default()
    });
    let mut all = by_default.to_vec();
    all.push(CurvedOptions {
        flat: FlatTriangles::Separate,
        ..CurvedOptions::default()
    });
    all.push(CurvedOptions::paper());
    all
}

fn together(device: &Device, geometries: Vec<GeometryBuilder>) -> Scene {
    let mut builder = SceneBuilder::new(device).unwrap().robust(true);
    for geometry in geometries {
        builder.attach(&geometry.commit().unwrap());
    }
    builder.commit().unwrap()
}

/// The meshes that `CURVETRI_MESHES` points to, by these names; says what it skips.
pub fn real_meshes(names: &[&str]) -> Vec<Body> {
    let Some(folder) = std::env::var_os("CURVETRI_MESHES").map(PathBuf::from) else {
        println!("skipped, because CURVETRI_MESHES is not set: {names:?}");
        return Vec::new();
    };
    let mut bodies = Vec::new();
    for &name in names {
        let path = folder.join(name);
        if path.exists() {
            let mesh = Arc::new(Loader::new().load(&path).unwrap().mesh);
            bodies.push(Body {
                name: name.to_owned(),
                mesh,
            });
        } else {
            println!("skipped, because {} does not exist", path.display());
        }
    }
    bodies
}

/// Closed bodies that the repo's own programs make, split vertices, hard rims and slivers included.
pub fn made_bodies() -> Vec<Body> {
    let blob = Blob {
        cells: 14,
        seed: 5,
        least_share: 0.01,
        rim: false,
        split: false,
    };
    let made = [
        (
            "sphere of 4 triangles",
            curvetri_bodies::Body::sphere_tetrahedron().mesh(),
        ),
        ("torus", curvetri_bodies::Body::torus(12, 16).mesh()),
        ("fine torus", curvetri_bodies::Body::torus(48, 64).mesh()),
        ("bumpy torus", curvetri_bodies::bumpy_torus(5_000)),
        ("capped cylinder", curvetri_bodies::capped_cylinder(16, 1.5)),
        (
            "teapot's pot",
            curvetri_bodies::teapot_part(curvetri_bodies::TeapotPart::Pot, 6),
        ),
        ("blob", blob.mesh()),
        ("blob with a rim", Blob { rim: true, ..blob }.mesh()),
        (
            "blob with a seam",
            Blob {
                split: true,
                ..blob
            }
            .mesh(),
        ),
    ];
    made.map(|(name, mesh)| Body {
        name: name.to_owned(),
        mesh: Arc::new(mesh),
    })
    .into()
}

/// Every closed body there is: made by the repo's own programs, and real ones.
pub fn closed_bodies() -> Vec<Body> {
    let real = [
        "spot/spot_triangulated.obj",
        "bunny_2k.obj",
        "armadillo_29k.obj",
    ];
    let mut bodies = made_bodies();
    bodies.extend(real_meshes(&real));
    bodies.retain(|body| {
        let counts = *Topology::new(&body.mesh).counts();
        if !counts.is_closed() {
            println!(
                "skipped, because it is not closed: {} {counts:?}",
                body.name
            );
        }
        counts.is_closed()
    });
    bodies
}

/// Every closed body there is: [`made_bodies`], and all meshes in the folder that `CURVETRI_MESHES`
/// points to that load and are closed.
pub fn all_closed_bodies() -> Vec<Body> {
    let mut bodies = made_bodies();
    let Some(folder) = std::env::var_os("CURVETRI_MESHES").map(PathBuf::from) else {
        println!("only made bodies, because CURVETRI_MESHES is not set");
        return bodies;
    };
    for path in mesh_files(&folder) {
        let Ok(loaded) = Loader::new().load(&path) else {
            continue;
        };
        if Topology::new(&loaded.mesh).counts().is_closed() {
            let name = path.strip_prefix(&folder).unwrap_or(&path);
            bodies.push(Body {
                name: name.display().to_string(),
                mesh: Arc::new(loaded.mesh),
            });
        }
    }
    bodies
}

/// All files of the formats that are read, in a folder and those in it.
pub fn mesh_files(folder: &Path) -> Vec<PathBuf> {
    let endings = ["obj", "ply", "stl", "off", "gltf", "glb", "gz"];
    let mut found = Vec::new();
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let ending = path.extension().and_then(|e| e.to_str());
        if path.is_dir() {
            found.extend(mesh_files(&path));
        } else if ending.is_some_and(|e| endings.contains(&e)) {
            found.push(path);
        }
    }
    found.sort();
    found
}

/// How many of some rays failed.
#[derive(Debug, Default)]
pub struct Tally {
    /// How many failed.
    pub failed: usize,
    /// Of how many.
    pub total: usize,
    /// One that failed.
    pub example: Option<Ray>,
}

impl Tally {
    /// Counts a ray.
    pub fn add(&mut self, ray: Ray, failed: bool) {
        self.total += 1;
        if failed {
            self.failed += 1;
            self.example = Some(ray);
        }
    }
    /// The share of the rays that failed.
    pub fn share(&self) -> f64 {
        self.failed as f64 / self.total.max(1) as f64
    }
}

/// The nearest hit of a ray.
pub fn first_hit(scene: &Scene, ray: &Ray) -> Option<curvetri::embree::Hit> {
    let mut packet = RayPacket::<1>::from_rays([ray]);
    scene.intersect(&mut packet, &QueryOptions::INCOHERENT);
    packet.hit(0)
}

/// All hits along a ray, each search beginning beyond the last hit's error bound.
pub fn all_hits(traced: &Traced, ray: &Ray) -> Vec<curvetri::embree::Hit> {
    let mut hits = Vec::new();
    let mut rest = *ray;
    while let Some(hit) = first_hit(&traced.scene, &rest) {
        hits.push(hit);
        let bound = traced.curved.error_bound(hit.prim_id, ray, hit.t);
        let slope = hit
            .ng
            .dot(ray.direction)
            .abs()
            .max(1e-3 * ray.direction.length());
        rest.tnear = hit.t + bound / slope;
        assert!(
            hits.len() < 1000,
            "{}: a ray never ends: {ray:?}",
            traced.name
        );
    }
    hits
}

/// Random points of the box that are tried before thin walls are looked for.
const BOX_POINTS: u32 = 100;

/// A point inside a closed body: rays from it cross the surface an odd number of times, in each of
/// nine directions, and not at once.
///
/// # Panics
/// If there seems to be none.
fn inside_point(traced: &Traced, random: &mut SplitMix) -> Vec3 {
    let bounds = traced.scene.bounds();
    let centre = (bounds.lower + bounds.upper) * 0.5;
    let half = (bounds.upper - bounds.lower) * 0.5;
    for tried in 0..20 * BOX_POINTS {
        let mut point = centre + half * random.in_cube();
        let mut clear = half.max_element() * 0.01;
        if tried >= BOX_POINTS {
            // A body that fills little of its box: half way between a ray's first two hits.
            let mesh = traced.curved.mesh();
            let corners = mesh.triangle_positions(random.below(mesh.triangles().len()));
            let direction = random.direction();
            let from = corners[0] - direction * (half.length() * 3.0);
            let b = random.barycentric();
            let across: Vec3 = (0..3).map(|k| (corners[k] - corners[0]) * b[k]).sum();
            let ray = Ray::new(from + across, direction);
            let hits = all_hits(traced, &ray);
            let [first, second, ..] = hits[..] else {
                continue;
            };
            point = ray.at(0.5 * (first.t + second.t));
            // nearer than rounding it is not certain which side it is on
            let rounding = 256.0 * f32::EPSILON * point.abs().max_element();
            clear = rounding.max(0.01 * (second.t - first.t));
        }
        let inside = (0..9).all(|_| {
            let hits = all_hits(traced, &Ray::new(point, random.direction()));
            hits.len() % 2 == 1 && hits[0].t > clear
        });
        if inside {
            return point;
        }
    }
    panic!("{}: no point is inside", traced.name);
}

/// Rays from inside at vertices, sides and anywhere that hit nothing.
pub fn lost_rays(traced: &Traced, count: usize) -> Tally {
    let all: Vec<usize> = (0..traced.curved.mesh().triangles().len()).collect();
    lost_rays_towards(traced, &all, count)
}

/// As [`lost_rays`], towards these triangles.
pub fn lost_rays_towards(traced: &Traced, triangles: &[usize], count: usize) -> Tally {
    let mut random = SplitMix::new(7);
    let mut tally = Tally::default();
    let mesh = traced.curved.mesh().clone();
    let mut origin = Vec3::ZERO;
    for n in 0..count {
        if n % 500 == 0 {
            origin = inside_point(traced, &mut random);
        }
        let triangle = triangles[random.below(triangles.len())];
        let p = mesh.triangle_positions(triangle);
        let target = match n % 3 {
            0 => p[random.below(3)],
            1 => {
                // On the curved side itself.
                let along = random.unit_f32();
                let patch = traced.curved.patch(triangle as u32);
                let (u, v) = [(along, 0.0), (0.0, along), (along, 1.0 - along)][random.below(3)];
                patch.point(u, v).position.into()
            }
            _ => {
                let b = random.barycentric();
                p[0] * b[0] + p[1] * b[1] + p[2] * b[2]
            }
        };
        let ray = Ray::new(origin, target - origin);
        tally.add(ray, first_hit(&traced.scene, &ray).is_none());
    }
    tally
}
