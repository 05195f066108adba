//! No ray slips through a closed body from inside. (That those from outside enter as often as they leave
//! is in `contract_all_hits.rs`.)

mod support;

use curvetri::curved::CurvedOptions;
use rayon::prelude::*;
use support::lost_rays;

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

#[test]
fn no_ray_from_inside_is_lost() {
    support::closed_bodies().par_iter().for_each(|body| {
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
    });
}
