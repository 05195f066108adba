//! The paper's own bounds give the hits that the tight ones give.

use curvetri::curved::{CurvedOptions, Primitives};
use curvetri::embree::Ray;
use curvetri::method::{BoundsKind, Solver, Surface};
use curvetri_bodies::SplitMix;
use curvetri_test_support::{Tally, first_hit};

/// Share of rays whose hits may differ.
const MAX_DIFFERENT: f64 = 1e-5;
/// How far apart the same hit may be, in units of the scene's size: the root finder starts elsewhere.
const SAME: f32 = 1e-5;

/// Counts the rays that a form hits elsewhere with the sphere's bounds than with tight ones.
fn differences(solver: Solver, surface: Surface) -> Tally {
    let mut different = Tally::default();
    for body in curvetri_test_support::closed_bodies() {
        let [tight, round] = [BoundsKind::Tight, BoundsKind::Sphere].map(|bounds| {
            body.traced_with(&CurvedOptions {
                surface,
                solver,
                bounds,
                primitives: Primitives::Triangles,
                ..CurvedOptions::default()
            })
        });
        let bounds = tight.scene.bounds();
        let centre = (bounds.lower + bounds.upper) * 0.5;
        let half = (bounds.upper - bounds.lower) * 0.5;
        let mut random = SplitMix::new(53);
        let mut met = 0;
        for _ in 0..100_000 {
            let target = centre + half * random.in_cube();
            let direction = random.direction();
            let ray = Ray::new(target - direction * (half.length() * 3.0), direction);
            let hits = [&tight, &round].map(|traced| first_hit(&traced.scene, &ray));
            let same = match &hits {
                [Some(a), Some(b)] => (a.t - b.t).abs() < SAME * half.length(),
                [None, None] => true,
                _ => false,
            };
            met += usize::from(hits[0].is_some());
            if !same {
                println!(
                    "{} {:?} {:?}: {:?}",
                    body.name,
                    ray.origin,
                    ray.direction,
                    hits.map(|hit| hit.map(|hit| (hit.t, hit.prim_id)))
                );
            }
            different.add(ray, !same);
        }
        assert!(met > 5_000, "{}: {met}", body.name);
    }
    println!("{surface:?} {solver:?}: {different:?}");
    different
}

#[test]
fn smooth_gives_the_same_hits_within_spheres_as_within_tight_bounds() {
    let different = differences(Solver::default(), Surface::Smooth);
    assert!(different.share() <= MAX_DIFFERENT, "{different:?}");
}

#[test]
fn the_paper_s_form_gives_the_hits_that_ours_gives_of_its_surface() {
    let different = differences(Solver::ITA, Surface::Angular);
    assert!(different.share() <= MAX_DIFFERENT, "{different:?}");
}
