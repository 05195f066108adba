//! No ray slips through a closed body from inside. (That those from outside enter as often as they leave
//! is in `contract/all_hits.rs`.)

use std::sync::Arc;

use curvetri::curved::{CurvedOptions, FlatTriangles};
use curvetri::method::PatchKind;
use curvetri_test_support::{Body, lost_rays, lost_rays_towards};
use rayon::prelude::*;

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
    curvetri_test_support::closed_bodies()
        .par_iter()
        .for_each(|body| {
            for options in curvetri_test_support::all_forms() {
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

#[test]
fn none_is_lost_between_curved_triangles_and_flat_ones_that_are_apart() {
    let made = |segments| Body {
        name: format!("cylinder of {segments}"),
        mesh: Arc::new(curvetri_bodies::capped_cylinder(segments, 1.5)),
    };
    let mut bodies: Vec<Body> = [5, 16, 64].map(made).into();
    bodies.extend(curvetri_test_support::real_meshes(&["cad_feature.stl"]));
    bodies.par_iter().for_each(|body| {
        let traced = body.traced_with(&CurvedOptions {
            flat: FlatTriangles::Separate,
            ..CurvedOptions::default()
        });
        let curved = &traced.curved;
        let flat: Vec<usize> = (0..curved.mesh().triangles().len())
            .filter(|&triangle| matches!(curved.kind(triangle as u32), PatchKind::Flat(_)))
            .collect();
        let lost = lost_rays_towards(&traced, &flat, 100_000);
        println!("{}: lost {lost:?}", traced.name);
        assert!(lost.share() <= MAX_LOST, "{}: {lost:?}", traced.name);
    });
}
