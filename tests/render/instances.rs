//! Instances in scenes: hits, normals, and rays that leave from them, against the same meshes put into
//! the scene themselves.

use curvetri::curved::CurvedOptions;
use curvetri::embree::{Hit, QueryOptions, Ray};
use curvetri::mesh::{Mesh, Parts, Placement};
use curvetri::render::{
    Form, PacketWidth, Scene, UserRay, answer_all_hits, answer_occluded, answer_rays,
};
use curvetri_bodies::{Body, SplitMix};
use glam::{DAffine3, DMat3, DQuat, DVec3, Vec3};

use crate::batch;

fn forms() -> [Form; 3] {
    [
        Form::Flat,
        Form::Curved(CurvedOptions::default()),
        Form::Curved(CurvedOptions::paper()),
    ]
}

/// Turned; mirrored; stretched, mirrored and turned; sheared.
fn transforms() -> [DAffine3; 4] {
    let turn = DMat3::from_quat(DQuat::from_xyzw(0.2, -0.5, 0.7, 0.4).normalize());
    let stretch = DMat3::from_diagonal(DVec3::new(1.5, -0.4, 0.8));
    let shear = DMat3::from_cols(
        DVec3::X,
        DVec3::new(0.7, 1.0, 0.0),
        DVec3::new(0.0, -0.4, 0.6),
    );
    let linear = [
        turn,
        DMat3::from_diagonal(DVec3::new(-1.0, 1.0, 1.0)),
        turn * stretch * turn.transpose(),
        shear,
    ];
    let mut n = 0.0;
    linear.map(|linear| {
        n += 4.0;
        DAffine3::from_mat3_translation(linear, DVec3::new(n, 0.5 * n, -n))
    })
}

fn placed(mesh: Mesh, transforms: &[DAffine3]) -> Parts {
    let mut parts = Parts::from(mesh);
    parts.placements = (transforms.iter())
        .map(|&to_user| Placement { part: 0, to_user })
        .collect();
    parts
}

/// The mesh where a transform puts it.
fn moved(mesh: &Mesh, to_user: &DAffine3) -> Mesh {
    let positions =
        (0..mesh.positions().len()).map(|v| to_user.transform_point3(mesh.world_position(v)));
    let turn = to_user.matrix3.inverse().transpose();
    let normals = mesh.normals().iter().map(|n| turn * n.as_dvec3());
    let mirrored = to_user.matrix3.determinant() < 0.0;
    let wind = |&[a, b, c]: &[u32; 3]| if mirrored { [a, c, b] } else { [a, b, c] };
    let triangles = mesh.triangles().iter().map(wind).collect();
    Mesh::new(positions.collect(), Some(normals.collect()), triangles).unwrap()
}

/// Rays through the neighbourhoods of the placements from around the scene.
fn rays(scene: &Scene, transforms: &[DAffine3], count: usize) -> Vec<UserRay> {
    let mut random = SplitMix::new(7);
    let bounds = scene.bounds();
    (0..count)
        .map(|n| {
            let mut any = || DVec3::from([0; 3].map(|_| random.between(-1.0, 1.0)));
            let origin = bounds.centre() + bounds.diagonal() * any().normalize();
            let target = transforms[n % transforms.len()].transform_point3(any());
            UserRay {
                origin,
                direction: (target - origin).normalize(),
                tnear: 0.0,
                tfar: f64::INFINITY,
            }
        })
        .collect()
}

#[test]
fn instances_are_hit_as_meshes_in_their_places() {
    let device = curvetri::linked::device().unwrap();
    let mesh = Body::torus(24, 32).mesh();
    for offset in [DVec3::ZERO, DVec3::new(3e6, -1e5, 2e6)] {
        let transforms = transforms().map(|t| DAffine3::from_translation(offset) * t);
        for form in forms() {
            let instances = Scene::new(&device, placed(mesh.clone(), &transforms), form).unwrap();
            let meshes: Vec<Mesh> = transforms.iter().map(|t| moved(&mesh, t)).collect();
            let copies = Scene::new(&device, meshes, form).unwrap();
            assert_eq!((instances.instances(), copies.instances()), (4, 0));
            assert_eq!(
                instances.triangles().total() * 4,
                copies.triangles().total()
            );
            let [a, b] = [instances.bounds(), copies.bounds()];
            assert!(a.min.distance(b.min) + a.max.distance(b.max) < 1e-5 * a.diagonal());
            let up = Vec3::new(0.6, 0.0, 0.8);
            let lowest = [&instances, &copies]
                .map(|scene| f64::from(scene.lowest(up)) + scene.origin().dot(up.as_dvec3()));
            assert!((lowest[0] - lowest[1]).abs() < 3e-3, "{lowest:?}");
            let rays = rays(&instances, &transforms, 6000);
            let ray = |n: usize| rays[n];
            let [one, other] = [&instances, &copies]
                .map(|scene| answer_rays(scene, &batch(rays.len(), &ray), PacketWidth::One));
            // The curved surface of a stretched mesh is not quite the stretched curved surface, and the
            // angular one has creases.
            let (near, alike, share) = match form {
                Form::Flat => (1e-4, 0.9999, 1e-3),
                Form::Curved(options) if options == CurvedOptions::paper() => (1e-2, 0.98, 0.03),
                Form::Curved(_) => (2e-3, 0.998, 0.01),
            };
            let (mut met, mut off) = (0, 0);
            for n in 0..rays.len() {
                let [t, u] = [one.t[n], other.t[n]];
                let [a, b] = [&one, &other].map(|hits| Vec3::from(hits.ng[n]));
                let same = t.is_finite() == u.is_finite()
                    && (!t.is_finite() || (t - u).abs() < near && a.dot(b) > alike);
                met += usize::from(t.is_finite());
                off += usize::from(!same);
                assert!(!t.is_finite() || (a.length() - 1.0).abs() < 1e-5);
            }
            assert!(met > 1500, "{met}");
            assert!(
                off as f64 <= share * met as f64,
                "{off} of {met}, {form:?}, {offset}"
            );
        }
    }
}

#[test]
fn packets_all_hits_and_occlusion_agree_on_instances() {
    let device = curvetri::linked::device().unwrap();
    let mesh = Body::torus(24, 32).mesh();
    for form in forms() {
        let parts = placed(mesh.clone(), &transforms());
        let scene = Scene::with_filters(&device, parts, form).unwrap();
        let rays = rays(&scene, &transforms(), 3000);
        let ray = |n: usize| rays[n];
        let rays_of_all = batch(rays.len(), &ray);
        let single = answer_rays(&scene, &rays_of_all, PacketWidth::One);
        for width in [PacketWidth::Four, PacketWidth::Eight, PacketWidth::Sixteen] {
            let hits = answer_rays(&scene, &rays_of_all, width);
            let off = (0..rays.len()).filter(|&n| {
                let apart = (hits.t[n] - single.t[n]).abs() > 1e-4;
                apart || (hits.prim_id[n] != single.prim_id[n] && hits.t[n] != single.t[n])
            });
            assert_eq!(off.count(), 0, "{form:?} {width:?}");
            let occluded = answer_occluded(&scene, &rays_of_all, width);
            let hit: Vec<bool> = single.t.iter().map(|t| t.is_finite()).collect();
            assert_eq!(occluded, hit, "{form:?} {width:?}");
        }
        // From outside closed bodies: in and out by turns, each front of its own side.
        let all = answer_all_hits(&scene, &rays_of_all, PacketWidth::Eight, 16);
        assert!(all.count.iter().any(|&count| count > 4));
        let mut odd = 0;
        for (n, ray) in rays.iter().enumerate() {
            let count = all.count[n] as usize;
            let fronts = (16 * n..16 * n + count)
                .map(|slot| Vec3::from(all.hits.ng[slot]).dot(ray.direction.as_vec3()) < 0.0);
            let alternate = fronts.enumerate().all(|(k, front)| front == (k % 2 == 0));
            odd += usize::from(count % 2 == 1 || !alternate);
        }
        assert_eq!(odd, 0, "{form:?}");
    }
}

/// The rays that leave a convex body from where others hit it, counted with those that meet it again.
fn shadowed(scene: &Scene, centre: Vec3, radius: f32, distance: f32) -> [usize; 2] {
    let mut random = SplitMix::new(3);
    let mut any = || random.in_cube();
    let mut counts = [0; 2];
    for n in 0..1500 {
        let origin = centre + distance * radius * any().normalize();
        let target = centre + 0.5 * radius * any();
        let ray = Ray::new(origin, (target - origin).normalize());
        let Some(hit) = scene.tree().intersect1(&ray, &QueryOptions::default()) else {
            continue;
        };
        assert_ne!(hit.inst_id[0], Hit::NONE);
        let unit = scene.normal(&hit);
        let normal = -unit * unit.dot(ray.direction).signum();
        let outwards = any();
        let mut outwards = outwards * normal.dot(outwards).signum();
        if n % 4 == 0 {
            outwards = (outwards - 0.999 * normal.dot(outwards) * normal).normalize();
        }
        let start = scene.leaving_point(&hit, &ray, normal);
        let next = Ray::new(start, outwards);
        let next = scene.tree().intersect1(&next, &QueryOptions::default());
        counts[0] += 1;
        // The other one is met from time to time.
        counts[1] += usize::from(next.is_some_and(|next| next.inst_id == hit.inst_id));
    }
    counts
}

#[test]
fn a_convex_instance_does_not_shadow_itself() {
    let device = curvetri::linked::device().unwrap();
    let ball = Body::sphere_tetrahedron().mesh();
    for form in forms() {
        for scale in [1e-3, 1.0, 1e3] {
            for transform in transforms() {
                for offset in [0.0, 30.0, 1e4] {
                    let moved = DAffine3 {
                        matrix3: scale * transform.matrix3,
                        translation: scale * (offset * DVec3::ONE + transform.translation),
                    };
                    // The same twice, one far off: the origin is then near neither.
                    let away = DAffine3::from_translation(scale * (offset + 20.0) * DVec3::NEG_X);
                    let parts = placed(ball.clone(), &[moved, away * moved]);
                    let scene = Scene::new(&device, parts, form).unwrap();
                    let centre = (moved.translation - scene.origin()).as_vec3();
                    for distance in [2.0, 50.0] {
                        let [hits, again] = shadowed(&scene, centre, scale as f32, distance);
                        assert!(hits > 150, "{hits} hits are too few to tell");
                        assert_eq!(
                            again, 0,
                            "of {hits}: {form:?}, {scale}, {offset}, {transform:?}, {distance}"
                        );
                    }
                }
            }
        }
    }
}

#[test]
fn plates_of_an_instance_close_to_each_other_shadow_each_other() {
    let device = curvetri::linked::device().unwrap();
    let square = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)];
    let level = |z: f64| square.map(|(x, y)| DVec3::new(x, y, z));
    let positions = [level(0.0), level(1e-4)].concat();
    let triangles = vec![[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]];
    let plates = Mesh::new(positions, None, triangles).unwrap();
    // Squeezed and stretched, near the origin: what is thin stays thicker than the error bound.
    for scales in [DVec3::new(300.0, 1.0, 1.0), DVec3::new(-20.0, 40.0, 0.1)] {
        let transform = DAffine3::from_scale(scales);
        let away = DAffine3::from_translation(3.0 * DVec3::Y) * transform;
        for form in forms() {
            let parts = placed(plates.clone(), &[transform, away]);
            let scene = Scene::new(&device, parts, form).unwrap();
            let mut random = SplitMix::new(5);
            for _ in 0..500 {
                let [x, y] = [0; 2].map(|_| random.between(0.05, 0.95) as f32);
                let origin = scales.as_vec3() * Vec3::new(x, y, -1.0);
                let ray = Ray::new(origin, Vec3::Z);
                let tree = scene.tree();
                let hit = tree.intersect1(&ray, &QueryOptions::default()).unwrap();
                assert!(hit.prim_id < 2);
                let start = scene.leaving_point(&hit, &ray, Vec3::Z);
                let above = tree.intersect1(&Ray::new(start, Vec3::Z), &QueryOptions::default());
                assert!(
                    above.is_some_and(|above| above.prim_id >= 2),
                    "{form:?} {scales}"
                );
            }
        }
    }
}
