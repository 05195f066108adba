//! Panics of callbacks arrive in the caller, and leave everything usable.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};

use glam::Vec3;

use super::packets::devices;
use super::sphere::*;
use curvetri_embree::*;

/// A row of spheres whose functions panic where told to.
struct Explosive {
    spheres: Arc<Spheres>,
    bounds: AtomicBool,
    intersect: AtomicBool,
    occluded: AtomicBool,
    calls: AtomicU32,
}

impl Explosive {
    fn new() -> Arc<Self> {
        let off = || AtomicBool::new(false);
        let spheres = (0..1000)
            .map(|i| (Vec3::new(0.0, 0.0, i as f32), 0.4))
            .collect();
        Arc::new(Self {
            spheres: Arc::new(Spheres(spheres)),
            bounds: off(),
            intersect: off(),
            occluded: off(),
            calls: AtomicU32::new(0),
        })
    }

    fn count(&self, fuse: &AtomicBool, name: &'static str) {
        self.calls.fetch_add(1, Ordering::Relaxed);
        if fuse.load(Ordering::Relaxed) {
            std::panic::panic_any(name);
        }
    }
}

impl UserGeometry for Explosive {
    fn primitives(&self) -> u32 {
        self.spheres.primitives()
    }

    fn bounds(&self, prim: u32, time_step: u32) -> Bounds {
        self.count(&self.bounds, "bounds");
        self.spheres.bounds(prim, time_step)
    }

    fn intersect(&self, query: &mut IntersectQuery<'_>) {
        self.count(&self.intersect, "intersect");
        self.spheres.intersect(query);
    }

    fn occluded(&self, query: &mut OccludedQuery<'_>) {
        self.count(&self.occluded, "occluded");
        self.spheres.occluded(query);
    }
}

/// What a call panics with.
fn caught<T>(call: impl FnOnce() -> T) -> Option<&'static str> {
    let payload = catch_unwind(AssertUnwindSafe(call)).err()?;
    Some(
        payload
            .downcast_ref::<&'static str>()
            .expect("a panic of these tests"),
    )
}

fn rays() -> Vec<Ray> {
    vec![Ray::new(Vec3::new(0.01, 0.0, -3.0), Vec3::Z); 16]
}

fn check<const N: usize>(device: &Device)
where
    Width<N>: Traced,
{
    let shape = Explosive::new();
    let scene = scene_of(device, Geometry::user(device, shape.clone()).unwrap());
    let options = QueryOptions::COHERENT;
    let intersect = || hits::<N>(&scene, &rays()[..N], &options);
    let occluded = || shadows::<N>(&scene, &rays()[..N], &options);
    for _ in 0..2 {
        shape.intersect.store(true, Ordering::Relaxed);
        shape.occluded.store(true, Ordering::Relaxed);
        shape.calls.store(0, Ordering::Relaxed);
        assert_eq!(caught(intersect), Some("intersect"));
        // the first call panics, and no other is made
        assert_eq!(shape.calls.load(Ordering::Relaxed), 1);
        assert_eq!(caught(occluded), Some("occluded"));
        assert_eq!(shape.calls.load(Ordering::Relaxed), 2);

        shape.intersect.store(false, Ordering::Relaxed);
        shape.occluded.store(false, Ordering::Relaxed);
        assert!(
            intersect()
                .iter()
                .all(|hit| hit.is_some_and(|hit| hit.prim_id == 0))
        );
        assert_eq!(occluded(), vec![true; N]);
    }
}

#[test]
fn panics_of_a_geometry_resume_in_the_query() {
    for device in devices() {
        check::<1>(&device);
        check::<4>(&device);
        check::<8>(&device);
        check::<16>(&device);
    }
}

#[test]
fn panics_of_bounds_resume_in_commit() {
    for threads in ["threads=1", "threads=4"] {
        let device = linked::device_with_config(threads).unwrap();
        let shape = Explosive::new();
        let geometry = Geometry::user(&device, shape.clone())
            .unwrap()
            .commit()
            .unwrap();
        let build = || {
            let mut builder = SceneBuilder::new(&device).unwrap();
            builder.attach(&geometry);
            builder.commit().unwrap()
        };
        for _ in 0..2 {
            shape.bounds.store(true, Ordering::Relaxed);
            assert_eq!(caught(build), Some("bounds"));
            shape.bounds.store(false, Ordering::Relaxed);
            let hits = hits::<4>(&build(), &rays(), &QueryOptions::default());
            assert!(
                hits.iter()
                    .all(|hit| hit.is_some_and(|hit| hit.prim_id == 0))
            );
        }
    }
}

fn explode(_: &Candidate) -> bool {
    std::panic::panic_any("filter")
}

#[test]
fn panics_of_filters_resume_in_the_query() {
    let corners = [
        Vec3::new(-9.0, -9.0, 0.0),
        Vec3::new(9.0, -9.0, 0.0),
        Vec3::new(0.0, 9.0, 0.0),
    ];
    type Build<'a> = &'a dyn Fn(&Device) -> GeometryBuilder;
    let builds: [Build<'_>; 2] = [
        &|device| Geometry::user(device, Explosive::new()).unwrap(),
        &|device| Geometry::triangles(device, &corners, &[[0, 1, 2]]).unwrap(),
    ];
    for device in devices() {
        for build in builds {
            let geometry = build(&device)
                .intersect_filter(explode)
                .occluded_filter(explode);
            let scene = scene_of(&device, geometry);
            let options = QueryOptions::default();
            assert_eq!(
                caught(|| hits::<1>(&scene, &rays(), &options)),
                Some("filter")
            );
            assert_eq!(
                caught(|| hits::<16>(&scene, &rays(), &options)),
                Some("filter")
            );
            assert_eq!(
                caught(|| shadows::<1>(&scene, &rays(), &options)),
                Some("filter")
            );
            assert_eq!(
                caught(|| shadows::<8>(&scene, &rays(), &options)),
                Some("filter")
            );

            let mut builder = SceneBuilder::new(&device).unwrap().query_filters(true);
            builder.attach(&build(&device).commit().unwrap());
            let scene = builder.commit().unwrap();
            let options = QueryOptions::COHERENT.with_filter(&explode);
            assert_eq!(
                caught(|| hits::<1>(&scene, &rays(), &options)),
                Some("filter")
            );
            assert_eq!(
                caught(|| hits::<16>(&scene, &rays(), &options)),
                Some("filter")
            );
            assert_eq!(
                caught(|| shadows::<1>(&scene, &rays(), &options)),
                Some("filter")
            );
            assert_eq!(
                caught(|| shadows::<4>(&scene, &rays(), &options)),
                Some("filter")
            );
            // and without the filter all is well
            let options = QueryOptions::COHERENT;
            assert!(
                hits::<16>(&scene, &rays(), &options)
                    .iter()
                    .all(Option::is_some)
            );
            assert!(
                shadows::<1>(&scene, &rays(), &options)
                    .iter()
                    .all(|shadow| *shadow)
            );
        }
    }
}

/// A geometry that looks at another scene for its answer.
struct Portal(Scene);

impl UserGeometry for Portal {
    fn primitives(&self) -> u32 {
        1
    }

    fn bounds(&self, _: u32, _: u32) -> Bounds {
        self.0.bounds()
    }

    fn intersect(&self, query: &mut IntersectQuery<'_>) {
        for lane in query.lanes() {
            let mut packet = RayPacket::<1>::from_rays(&[query.ray(lane)]);
            self.0.intersect(&mut packet, &QueryOptions::default());
            if let Some(hit) = packet.hit(0) {
                query.report(
                    lane,
                    SurfaceHit {
                        t: hit.t,
                        u: hit.u,
                        v: hit.v,
                        ng: hit.ng,
                    },
                );
            }
        }
    }

    fn occluded(&self, query: &mut OccludedQuery<'_>) {
        for lane in query.lanes() {
            let mut packet = RayPacket::<1>::from_rays(&[query.ray(lane)]);
            if self.0.occluded(&mut packet, &QueryOptions::default()) != 0 {
                let t = query.tnear()[lane];
                query.report(
                    lane,
                    SurfaceHit {
                        t,
                        u: 0.0,
                        v: 0.0,
                        ng: Vec3::Z,
                    },
                );
            }
        }
    }
}

#[test]
fn callbacks_may_trace_other_scenes() {
    for device in devices() {
        let shape = Explosive::new();
        let inner = scene_of(&device, Geometry::user(&device, shape.clone()).unwrap());
        let portal = Arc::new(Portal(inner.clone()));
        let outer = scene_of(&device, Geometry::user(&device, portal).unwrap());
        let options = QueryOptions::COHERENT;
        let through = hits::<16>(&outer, &rays(), &options);
        for (seen, direct) in through.iter().zip(hits::<1>(&inner, &rays(), &options)) {
            assert_eq!(seen.unwrap().t, direct.unwrap().t);
        }
        assert_eq!(shadows::<8>(&outer, &rays(), &options), vec![true; 16]);
        // through two queries, one inside the other
        shape.intersect.store(true, Ordering::Relaxed);
        assert_eq!(
            caught(|| hits::<16>(&outer, &rays(), &options)),
            Some("intersect")
        );
        shape.intersect.store(false, Ordering::Relaxed);
        assert_eq!(hits::<16>(&outer, &rays(), &options), through);
    }
}
