//! Filters of geometries and of queries decide on the hits of curved triangles: a rejected root is
//! followed by the next one of the same patch, and then by those of other patches.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicUsize, Ordering};

use crate::queries::*;
use curvetri::curved::CurvedOptions;
use curvetri::embree::{Candidate, Device, QueryOptions, RayPacket, Scene};
use curvetri_test_support::Body;

/// Accepts what faces away.
fn back(candidate: &Candidate) -> bool {
    assert_eq!(candidate.ray.tfar, candidate.hit.t);
    assert_eq!(candidate.hit.geom_id, 0);
    candidate.hit.ng.dot(candidate.ray.direction) > 0.0
}

/// Accepts every third triangle.
fn third(candidate: &Candidate) -> bool {
    candidate.hit.prim_id.is_multiple_of(3)
}

/// Accepts a stripe of every triangle.
fn stripe(candidate: &Candidate) -> bool {
    (0.2..0.4).contains(&candidate.hit.u)
}

fn nothing(_: &Candidate) -> bool {
    false
}

const FILTERS: [fn(&Candidate) -> bool; 4] = [back, third, stripe, nothing];

/// Demands of single rays and of packets that they give the first of all hits that `accepts`.
fn check(
    scene: &Scene,
    everything: &Scene,
    filter: Option<fn(&Candidate) -> bool>,
    accepts: &dyn Fn(&Candidate) -> bool,
    what: &str,
) -> usize {
    let filter = filter.as_ref().map(|filter| filter as _);
    let rays = rays(scene, 1_000, 51);
    let single = singly(scene, &rays, filter);
    for ((ray, hit), occluded) in rays.iter().zip(&single.hits).zip(&single.occluded) {
        let accepted = offered(everything, ray).into_iter().find(|c| accepts(c));
        let expected = accepted.map(|candidate| (candidate.hit.t, candidate.hit.prim_id));
        assert_eq!(hit.map(|hit| (hit.t, hit.prim_id)), expected, "{what}");
        assert_eq!(*occluded, expected.is_some(), "{what}");
    }
    let mut agreement = Agreement::default();
    for (how, said) in by_all_packets(scene, &rays, filter) {
        agreement.compare(&single, &said, &format!("{what}, {how}"));
    }
    agreement.assert_ties_are_rare();
    single.met()
}

fn each(check: impl Fn(&Device, &Body, &CurvedOptions, &Scene, &str)) {
    let device = curvetri::linked::device().unwrap();
    for body in few_bodies() {
        for options in all_options() {
            let everything = scene(&body, &options);
            let what = format!("{} {options:?}", body.name);
            check(&device, &body, &options, &everything, &what);
        }
    }
}

#[test]
fn a_query_s_filter_is_asked_about_every_root() {
    each(|_, _, _, everything, what| {
        for filter in FILTERS {
            let met = check(everything, everything, Some(filter), &filter, what);
            assert_eq!(met > 0, !filter_is(filter, nothing), "{what}");
        }
    });
}

fn filter_is(a: fn(&Candidate) -> bool, b: fn(&Candidate) -> bool) -> bool {
    std::ptr::fn_addr_eq(a, b)
}

#[test]
fn a_geometry_s_filter_is_asked_about_every_root() {
    each(|device, body, options, everything, what| {
        for filter in FILTERS {
            let geometry = geometry(device, body, options)
                .intersect_filter(filter)
                .occluded_filter(filter);
            let scene = scene_of(device, [geometry]);
            check(&scene, everything, None, &filter, what);
        }
    });
}

#[test]
fn a_hit_needs_both_filters() {
    each(|device, body, options, everything, what| {
        let geometry = geometry(device, body, options)
            .intersect_filter(back)
            .occluded_filter(back);
        let scene = scene_of(device, [geometry]);
        let both = |candidate: &Candidate| back(candidate) && stripe(candidate);
        check(&scene, everything, Some(stripe), &both, what);
    });
}

#[test]
fn the_next_root_of_the_same_patch_comes_before_other_patches() {
    // The ball's far side is on the patch of the near side, for rays that pass its middle by far.
    let body = &few_bodies()[0];
    for options in all_options() {
        let scene = scene(body, &options);
        let (mut same, mut other) = (0, 0);
        for ray in rays(&scene, 10_000, 52) {
            let roots = offered(&scene, &ray);
            if let [first, second] = &roots[..] {
                let filter = |c: &Candidate| c.hit.t != first.hit.t;
                let hit = scene.intersect1(&ray, &QueryOptions::default().with_filter(&filter));
                let hit = hit.expect("the second root");
                assert_eq!((hit.t, hit.prim_id), (second.hit.t, second.hit.prim_id));
                if first.hit.prim_id == hit.prim_id {
                    same += 1;
                } else {
                    other += 1;
                }
            }
        }
        assert!(same > 100 && other > 100, "{same} and {other}");
    }
}

fn explode(_: &Candidate) -> bool {
    std::panic::panic_any("of a filter")
}

#[test]
fn panics_of_filters_arrive_in_the_caller() {
    let device = curvetri::linked::device().unwrap();
    let body = &few_bodies()[1];
    let options = CurvedOptions::default();
    let by_geometry = scene_of(
        &device,
        [geometry(&device, body, &options)
            .intersect_filter(explode)
            .occluded_filter(explode)],
    );
    let by_query = scene(body, &options);
    let rays = rays(&by_query, 160, 53);
    let plain = QueryOptions::default();
    let calls = AtomicUsize::new(0);
    // The panic comes with the root after the one that is rejected.
    let second = |c: &Candidate| calls.fetch_add(1, Ordering::Relaxed) > 0 && explode(c);
    for (scene, options) in [
        (&by_geometry, plain),
        (&by_query, plain.with_filter(&explode)),
        (&by_query, plain.with_filter(&second)),
    ] {
        let intersect = || {
            for chunk in rays.chunks(16) {
                scene.intersect(&mut RayPacket::<16>::from_rays(chunk), &options);
            }
        };
        let occluded = || {
            for ray in &rays {
                scene.occluded1(ray, &options);
            }
        };
        for run in [&intersect as &dyn Fn(), &occluded] {
            calls.store(0, Ordering::Relaxed);
            let panic = catch_unwind(AssertUnwindSafe(run)).expect_err("a filter panics");
            assert_eq!(panic.downcast_ref(), Some(&"of a filter"));
        }
    }
    // and all is well without them
    assert!(singly(&by_query, &rays, None).met() > 40);
}
