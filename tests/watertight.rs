//! No ray slips through a closed body, and every ray from outside enters as often as it leaves.

mod support;

use curvetri::curved::CurvedOptions;
use support::{lost_rays, odd_rays};

/// Rays a body: of the default form, and of the others.
fn rays(options: &CurvedOptions) -> usize {
    if *options == CurvedOptions::default() {
        100_000
    } else {
        50_000
    }
}

/// Share of rays that may be lost: what Embree's own watertight test allows.
const MAX_LOST: f64 = 2e-5;
/// Share of rays from outside that must cross a body evenly and alternately.
const MIN_EVEN: f64 = 0.9999;

#[test]
fn no_ray_from_inside_is_lost() {
    for body in support::closed_bodies() {
        for options in support::all_forms() {
            let traced = body.traced_with(&options);
            let lost = lost_rays(&traced, rays(&options));
            println!(
                "{} {options:?}: lost {lost:?}, {:?}",
                traced.name,
                traced.curved.kinds()
            );
            assert!(
                lost.share() <= MAX_LOST,
                "{} {options:?}: {lost:?}",
                traced.name
            );
        }
    }
}

#[test]
fn rays_from_outside_cross_evenly_and_alternately() {
    for body in support::closed_bodies() {
        for options in support::all_forms() {
            let traced = body.traced_with(&options);
            let odd = odd_rays(&traced, rays(&options));
            println!("{} {options:?}: odd {odd:?}", traced.name);
            assert!(
                1.0 - odd.share() >= MIN_EVEN,
                "{} {options:?}: {odd:?}",
                traced.name
            );
        }
    }
}
