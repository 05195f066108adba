//! Rays' ends, and the rays that Debian 12's Embree aborts the process for.

use std::sync::Arc;

use glam::Vec3;

use super::packets::devices;
use super::sphere::*;
use curvetri_embree::*;

fn unit_sphere() -> Arc<Spheres> {
    Arc::new(Spheres(vec![(Vec3::ZERO, 1.0)]))
}

fn triangle(device: &Device) -> Scene {
    let corners = [
        Vec3::new(-9.0, -9.0, 0.0),
        Vec3::new(9.0, -9.0, 0.0),
        Vec3::new(0.0, 9.0, 0.0),
    ];
    scene_of(
        device,
        Geometry::triangles(device, &corners, &[[0, 1, 2]]).unwrap(),
    )
}

fn bad_rays() -> Vec<Ray> {
    let good = Ray::new(Vec3::new(0.0, 0.0, -3.0), Vec3::Z);
    let mut rays = Vec::new();
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 1.9e18, -3e38] {
        for axis in 0..3 {
            let mut ray = good;
            ray.origin[axis] = bad;
            rays.push(ray);
            ray = good;
            ray.direction[axis] = bad;
            rays.push(ray);
        }
    }
    rays.extend([
        good.between(f32::NAN, 9.0),
        good.between(0.0, f32::NAN),
        good.between(f32::NAN, f32::NAN),
        good.between(-1.0, 9.0),
        good.between(f32::NEG_INFINITY, f32::INFINITY),
        good.between(0.0, -1.0),
        good.between(0.0, f32::NEG_INFINITY),
        good.between(5.0, 1.0),
        good.between(-f32::MIN_POSITIVE, 9.0),
        Ray { time: -0.5, ..good },
        Ray { time: 1.5, ..good },
        Ray {
            time: f32::NAN,
            ..good
        },
    ]);
    rays
}

fn check_bad<const N: usize>(scene: &Scene)
where
    Width<N>: Traced,
{
    let good = Ray::new(Vec3::new(0.0, 0.0, -3.0), Vec3::Z);
    for (number, bad) in bad_rays().into_iter().enumerate() {
        let lane = number % N;
        let mut rays = [good; N];
        rays[lane] = bad;
        for options in [QueryOptions::INCOHERENT, QueryOptions::COHERENT] {
            let hits = hits::<N>(scene, &rays, &options);
            let shadows = shadows::<N>(scene, &rays, &options);
            for other in 0..N {
                assert_eq!(
                    hits[other].is_some(),
                    other != lane,
                    "{bad:?} in lane {lane} of {N}"
                );
                assert_eq!(
                    shadows[other],
                    other != lane,
                    "{bad:?} in lane {lane} of {N}"
                );
            }
        }
    }
}

#[test]
fn rays_that_embree_aborts_on_are_misses() {
    for device in devices() {
        let moving = scene_of(&device, Geometry::user(&device, Arc::new(Moving)).unwrap());
        for scene in [
            sphere_scene(&device, unit_sphere()),
            triangle(&device),
            moving,
        ] {
            check_bad::<1>(&scene);
            check_bad::<4>(&scene);
            check_bad::<8>(&scene);
            check_bad::<16>(&scene);
        }
    }
}

fn check_ends<const N: usize>(scene: &Scene)
where
    Width<N>: Traced,
{
    let ray = Ray::new(Vec3::new(0.0, 0.0, -3.0), 0.5 * Vec3::Z);
    let cases = [
        (ray, Some(4.0)),
        (ray.between(4.0, 8.0), Some(4.0)),
        (ray.between(4.01, 8.0), Some(8.0)),
        (ray.between(4.01, 7.99), None),
        (ray.between(0.0, 3.99), None),
        (ray.between(0.0, 4.0), Some(4.0)),
        (ray.between(4.0, 4.0), Some(4.0)),
        (ray.between(8.0, 8.0), Some(8.0)),
        (ray.between(5.0, 5.0), None),
        (ray.between(8.01, f32::INFINITY), None),
        (Ray::new(Vec3::ZERO, -2.0 * Vec3::X), Some(0.5)),
        (Ray::new(Vec3::ZERO, Vec3::ZERO), None),
        (ray.between(f32::INFINITY, f32::INFINITY), None),
    ];
    let rays: Vec<Ray> = cases.iter().map(|case| case.0).collect();
    let hits = hits::<N>(scene, &rays, &QueryOptions::default());
    let shadows = shadows::<N>(scene, &rays, &QueryOptions::default());
    for (case, (hit, shadow)) in cases.iter().zip(hits.iter().zip(shadows)) {
        assert_eq!(
            hit.map(|hit| hit.t),
            case.1,
            "{:?} in packets of {N}",
            case.0
        );
        assert_eq!(shadow, case.1.is_some(), "{:?} in packets of {N}", case.0);
    }
}

#[test]
fn hits_lie_between_the_ray_s_ends() {
    for device in devices() {
        let scene = sphere_scene(&device, unit_sphere());
        check_ends::<1>(&scene);
        check_ends::<4>(&scene);
        check_ends::<8>(&scene);
        check_ends::<16>(&scene);
    }
}

/// Reports what it is told to, whatever the ray.
struct Reporter(f32);

impl UserGeometry for Reporter {
    fn primitives(&self) -> u32 {
        1
    }

    fn bounds(&self, _: u32, _: u32) -> Bounds {
        Bounds {
            lower: Vec3::NEG_ONE,
            upper: Vec3::ONE,
        }
    }

    fn intersect(&self, query: &mut IntersectQuery<'_>) {
        for lane in 0..query.width() {
            let ray = query.ray(lane);
            let counts = query.valid() & 1 << lane != 0 && (ray.tnear..=ray.tfar).contains(&self.0);
            let hit = SurfaceHit {
                t: self.0,
                u: 0.0,
                v: 0.0,
                ng: Vec3::Z,
            };
            assert_eq!(query.report(lane, hit), counts);
        }
    }

    fn occluded(&self, query: &mut OccludedQuery<'_>) {
        for lane in 0..query.width() {
            let ray = query.ray(lane);
            let counts = query.valid() & 1 << lane != 0 && (ray.tnear..=ray.tfar).contains(&self.0);
            let hit = SurfaceHit {
                t: self.0,
                u: 0.0,
                v: 0.0,
                ng: Vec3::Z,
            };
            assert_eq!(query.report(lane, hit), counts);
            // done: the lane is valid no more, and a second hit does not count
            assert!(!counts || query.valid() & 1 << lane == 0);
            assert!(!query.report(lane, hit));
        }
    }
}

#[test]
fn reports_beyond_the_ray_or_its_lane_do_not_count() {
    let device = linked::device().unwrap();
    let ray = Ray::new(Vec3::new(0.0, 0.0, -3.0), Vec3::Z).between(1.0, 5.0);
    for (t, counts) in [
        (0.5, false),
        (1.0, true),
        (5.0, true),
        (5.1, false),
        (f32::NAN, false),
        (-3.0, false),
    ] {
        let scene = scene_of(
            &device,
            Geometry::user(&device, Arc::new(Reporter(t))).unwrap(),
        );
        let mut packet = RayPacket::<8>::from_rays(&[ray; 5]);
        let options = QueryOptions::COHERENT;
        assert_eq!(
            scene.occluded(&mut packet.clone(), &options),
            if counts { 0b1_1111 } else { 0 }
        );
        scene.intersect(&mut packet, &options);
        for lane in 0..8 {
            assert_eq!(
                packet.hit(lane).is_some(),
                counts && lane < 5,
                "t = {t}, lane {lane}"
            );
        }
    }
}

/// A sphere that moves from x = 0 to x = 10.
struct Moving;

impl Moving {
    fn at(time: f32) -> Spheres {
        Spheres(vec![(Vec3::new(10.0 * time, 0.0, 0.0), 1.0)])
    }
}

impl UserGeometry for Moving {
    fn primitives(&self) -> u32 {
        1
    }

    fn time_steps(&self) -> u32 {
        3
    }

    fn bounds(&self, prim: u32, time_step: u32) -> Bounds {
        Self::at(time_step as f32 / 2.0).bounds(prim, 0)
    }

    fn intersect(&self, query: &mut IntersectQuery<'_>) {
        for lane in query.lanes() {
            let ray = query.ray(lane);
            assert_eq!(query.time()[lane], ray.time);
            if let Some([t, _]) = Self::at(ray.time).roots(0, &ray) {
                query.report(lane, Self::at(ray.time).surface_hit(0, &ray, t, 0));
            }
        }
    }

    fn occluded(&self, query: &mut OccludedQuery<'_>) {
        for lane in query.lanes() {
            let ray = query.ray(lane);
            if let Some([t, _]) = Self::at(ray.time).roots(0, &ray) {
                query.report(lane, Self::at(ray.time).surface_hit(0, &ray, t, 0));
            }
        }
    }
}

#[test]
fn geometry_moves_between_its_time_steps() {
    let device = linked::device().unwrap();
    let scene = scene_of(&device, Geometry::user(&device, Arc::new(Moving)).unwrap());
    let rays: Vec<Ray> = (0..=20)
        .map(|i| {
            let time = i as f32 / 20.0;
            Ray {
                time,
                ..Ray::new(Vec3::new(10.0 * time, 0.0, -5.0), Vec3::Z)
            }
        })
        .collect();
    for hit in hits::<16>(&scene, &rays, &QueryOptions::COHERENT) {
        assert_eq!(hit.unwrap().t, 4.0);
    }
    let early: Vec<Ray> = rays[..15]
        .iter()
        .map(|ray| Ray { time: 1.0, ..*ray })
        .collect();
    assert_eq!(
        hits::<4>(&scene, &early, &QueryOptions::default()),
        vec![None; 15]
    );
}

#[test]
fn geometries_have_1_to_129_time_steps() {
    struct Steps(u32);
    impl UserGeometry for Steps {
        fn primitives(&self) -> u32 {
            0
        }
        fn time_steps(&self) -> u32 {
            self.0
        }
        fn bounds(&self, _: u32, _: u32) -> Bounds {
            Bounds::EMPTY
        }
        fn intersect(&self, _: &mut IntersectQuery<'_>) {}
        fn occluded(&self, _: &mut OccludedQuery<'_>) {}
    }
    let device = linked::device().unwrap();
    for steps in [0, 130, u32::MAX] {
        let refused = Geometry::user(&device, Arc::new(Steps(steps))).err();
        assert_eq!(refused, Some(Error::TimeSteps(steps)));
    }
    Geometry::user(&device, Arc::new(Steps(129)))
        .unwrap()
        .commit()
        .unwrap();
}

/// Unit spheres in a row, with the bounds given.
struct Bounded(Vec<Bounds>);

impl Bounded {
    fn spheres(&self) -> Spheres {
        let row = (0..self.0.len()).map(|i| (Vec3::new(0.0, 0.0, 4.0 * i as f32), 1.0));
        Spheres(row.collect())
    }
}

impl UserGeometry for Bounded {
    fn primitives(&self) -> u32 {
        self.0.len() as u32
    }

    fn bounds(&self, prim: u32, _: u32) -> Bounds {
        self.0[prim as usize]
    }

    fn intersect(&self, query: &mut IntersectQuery<'_>) {
        self.spheres().intersect(query);
    }

    fn occluded(&self, query: &mut OccludedQuery<'_>) {
        self.spheres().occluded(query);
    }
}

#[test]
fn primitives_without_a_finite_box_are_never_hit() {
    let boxed = |lower: f32, upper: f32| Bounds {
        lower: Vec3::splat(lower),
        upper: Vec3::splat(upper),
    };
    let nan = Bounds {
        lower: Vec3::new(-1.0, f32::NAN, -1.0),
        upper: Vec3::ONE,
    };
    let all = vec![
        Bounds::EMPTY,
        boxed(f32::NAN, f32::NAN),
        nan,
        boxed(1.0, -1.0),
        boxed(f32::NEG_INFINITY, f32::INFINITY),
        boxed(-1e30, 1e30),
        Bounds {
            lower: Vec3::new(-1.0, -1.0, 23.0),
            upper: Vec3::new(1.0, 1.0, 25.0),
        },
    ];
    for device in devices() {
        let geometry = Geometry::user(&device, Arc::new(Bounded(all.clone()))).unwrap();
        let scene = scene_of(&device, geometry);
        assert_eq!(scene.bounds(), all[6]);
        let rays = [Ray::new(Vec3::new(0.0, 0.0, -3.0), Vec3::Z); 16];
        for hit in [
            hits::<1>(&scene, &rays, &QueryOptions::default()),
            hits::<16>(&scene, &rays, &QueryOptions::COHERENT),
        ]
        .into_iter()
        .flatten()
        {
            assert_eq!(hit.map(|hit| hit.prim_id), Some(6));
        }
    }
}
