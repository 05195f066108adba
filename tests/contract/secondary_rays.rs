//! Rays that start on a surface: they do not meet the surface they leave, and they meet whatever is
//! near it.

use curvetri::curved::CurvedOptions;
use curvetri::embree::{Hit, QueryOptions, Ray, RayPacket};
use curvetri::mesh::Mesh;
use curvetri::method::{Solver, Surface};
use curvetri::render::{Form, Scene};
use curvetri_bodies::SplitMix;
use glam::{DVec3, Vec3};

/// Every surface, and the default one by the paper's root finder.
fn forms() -> Vec<Form> {
    let curved = |surface, solver| {
        Form::Curved(CurvedOptions {
            surface,
            solver,
            ..CurvedOptions::default()
        })
    };
    let mut forms = vec![Form::Flat];
    forms.extend(Surface::ALL.map(|surface| curved(surface, Solver::default())));
    forms.push(curved(Surface::Smooth, Solver::Ita { bits: 24, step: 3 }));
    forms
}

/// The sphere as four triangles: convex, so that no ray that leaves it outwards meets it again.
fn sphere(centre: DVec3, radius: f64) -> Mesh {
    let corners = [(1, 1, 1), (1, -1, -1), (-1, 1, -1), (-1, -1, 1)];
    let normals = corners.map(|(x, y, z)| DVec3::new(x.into(), y.into(), z.into()).normalize());
    let positions = normals.map(|n| centre + radius * n).to_vec();
    let triangles = vec![[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]];
    Mesh::new(positions, Some(normals.to_vec()), triangles).unwrap()
}

fn trace(scene: &Scene, ray: Ray) -> Option<Hit> {
    let mut packet = RayPacket::<1>::from_rays(&[ray]);
    scene
        .tree()
        .intersect(&mut packet, &QueryOptions::default());
    packet.hit(0)
}

fn occluded(scene: &Scene, ray: Ray) -> bool {
    let mut packet = RayPacket::<1>::from_rays(&[ray]);
    scene.tree().occluded(&mut packet, &QueryOptions::default()) != 0
}

/// Shoots rays at a sphere from `distance` radii away and sends a ray outwards from each hit; gives
/// the numbers of hits and of those whose ray met the sphere again.
fn shadowed(scene: &Scene, centre: Vec3, radius: f32, distance: f32) -> [usize; 2] {
    let mut random = SplitMix::new(3);
    let [mut hits, mut shadowed] = [0; 2];
    for n in 0..4000 {
        let origin = centre + distance * radius * random.direction();
        let target = centre + 0.5 * radius * random.direction();
        let ray = Ray::new(origin, (target - origin).normalize());
        let Some(hit) = trace(scene, ray) else {
            continue;
        };
        hits += 1;
        let unit = hit.ng.normalize();
        let normal = if unit.dot(ray.direction) > 0.0 {
            -unit
        } else {
            unit
        };
        let any = random.direction();
        let mut outwards = any * normal.dot(any).signum();
        if n % 4 == 0 {
            // Along the surface.
            outwards = (outwards - 0.999 * normal.dot(outwards) * normal).normalize();
        }
        let start = scene.leaving_point(&hit, &ray, normal);
        shadowed += usize::from(occluded(scene, Ray::new(start, outwards)));
    }
    [hits, shadowed]
}

#[test]
fn a_convex_body_does_not_shadow_itself() {
    let device = curvetri::linked::device().unwrap();
    for form in forms() {
        for radius in [1e-3, 1.0, 1e3] {
            for offset in [0.0, 3.0] {
                let centre = DVec3::new(1.0, -0.7, 0.4) * offset * radius;
                let scene = Scene::new(&device, vec![sphere(centre, radius)], form).unwrap();
                let centre = (centre - scene.origin()).as_vec3();
                for distance in [2.0, 300.0] {
                    let [hits, shadowed] = shadowed(&scene, centre, radius as f32, distance);
                    assert!(hits > 1000, "{form:?}: {hits} hits are too few to tell");
                    assert_eq!(
                        shadowed, 0,
                        "of {hits}: {form:?}, radius {radius}, offset {offset}, from {distance}"
                    );
                }
            }
        }
    }
}

/// Two plates, one above the other, each a square of two triangles with bent normals.
fn plates(size: f64, gap: f64, bend: f64) -> Mesh {
    let square = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)];
    let (mut positions, mut normals) = (Vec::new(), Vec::new());
    for level in [0.0, gap] {
        for (x, y) in square {
            positions.push(size * DVec3::new(x, y, level));
            normals.push(DVec3::new(bend * (x - 0.5), bend * (y - 0.5), 1.0));
        }
    }
    let triangles = vec![[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]];
    Mesh::new(positions, Some(normals), triangles).unwrap()
}

#[test]
fn plates_close_to_each_other_shadow_each_other() {
    let device = curvetri::linked::device().unwrap();
    for form in forms() {
        for size in [1e-3_f32, 1.0, 1e3] {
            for bend in [0.0, 0.2] {
                let mesh = plates(size.into(), 1e-4, bend);
                let scene = Scene::new(&device, vec![mesh], form).unwrap();
                let mut random = SplitMix::new(5);
                for _ in 0..500 {
                    let [x, y] = [0; 2].map(|_| random.between(0.05, 0.95) as f32);
                    // From below: the lower plate's lower face, then on from its upper face.
                    let ray = Ray::new(size * Vec3::new(x, y, -1.0), Vec3::Z);
                    let hit = trace(&scene, ray).expect("the lower plate is there");
                    assert!(hit.prim_id < 2);
                    let unit = hit.ng.normalize();
                    let up = if unit.z < 0.0 { -unit } else { unit };
                    let start = scene.leaving_point(&hit, &ray, up);
                    let above = trace(&scene, Ray::new(start, Vec3::Z));
                    let above = above.unwrap_or_else(|| panic!("{form:?} {size} {bend}: a leak"));
                    assert!(
                        above.prim_id >= 2,
                        "{form:?} {size} {bend}: its own surface"
                    );
                }
            }
        }
    }
}
