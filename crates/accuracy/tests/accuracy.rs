//! The figures the method is known by, on bodies with a known true surface: by the formulas in
//! `f64`, and by rays through Embree and the `f32` kernel.
//!
//! The reference figures are the paper's Table 1 as an independent `f64` prototype of the method
//! has it, and that prototype's figures for finer tori. It averaged over other points than we do,
//! which the tolerances stand for.
use curvetri::method::{Patch, PatchFlags, Surface};
use curvetri_accuracy::{
    AccuracyOptions, BodyRow, Measure, Peer, SurfaceModel, bodies, measure, measure_traced, order,
    triangles_needed,
};
use curvetri_bodies::Body;
use glam::DVec3;

const ANGULAR: SurfaceModel = SurfaceModel::Curved(Surface::Angular);
const TENSOR: SurfaceModel = SurfaceModel::Curved(Surface::Tensor);
const SMOOTH: SurfaceModel = SurfaceModel::Curved(Surface::Smooth);
const PN: SurfaceModel = SurfaceModel::Peer(Peer::Pn);
const NAGATA: SurfaceModel = SurfaceModel::Peer(Peer::Nagata);

fn body(name: &str) -> Body {
    let mut named = bodies().into_iter().filter(|body| body.name() == name);
    named.next().expect(name)
}

fn row(name: &str, model: SurfaceModel) -> BodyRow {
    let row = measure(&body(name), model, &AccuracyOptions::default());
    assert_eq!(row.missed, 0, "{row:?}");
    row
}

fn traced(name: &str, model: SurfaceModel) -> BodyRow {
    let options = AccuracyOptions {
        samples: 20_000,
        ..AccuracyOptions::default()
    };
    let row = measure_traced(
        &curvetri::linked::device().unwrap(),
        &body(name),
        model,
        &options,
    )
    .unwrap();
    assert_eq!(row.missed, 0, "{row:?}");
    row
}

/// Asserts that a value is a figure but for this share of it.
#[track_caller]
fn assert_near(value: f64, figure: f64, share: f64, row: &BodyRow) {
    let off = value / figure - 1.0;
    assert!(off.abs() <= share, "{value} is no {figure}: {row:?}");
}

/// Greatest and mean error of Table 1.
const TABLE_1: [(&str, SurfaceModel, f64, Option<f64>); 9] = [
    // The mean over the area is 0.00184; see the test of the regular grid.
    ("cylinder", ANGULAR, 0.0053, None),
    ("cone", ANGULAR, 0.0085, Some(0.0028)),
    ("torus", ANGULAR, 0.0156, Some(0.0030)),
    ("cylinder", TENSOR, 0.0012, None),
    ("cylinder", SMOOTH, 0.0012, None),
    ("cone", TENSOR, 0.0045, None),
    ("cone", SMOOTH, 0.0045, None),
    ("torus", TENSOR, 0.0158, None),
    ("torus", SMOOTH, 0.0158, None),
];

fn check_table_1(measured: impl Fn(&str, SurfaceModel) -> BodyRow) {
    for (name, model, max, mean) in TABLE_1 {
        let row = measured(name, model);
        assert_near(row.max, max, 0.045, &row);
        if let Some(mean) = mean {
            assert_near(row.mean, mean, 0.03, &row);
        }
    }
    let cylinder = measured("cylinder", ANGULAR);
    assert_near(cylinder.mean, 0.00184, 0.01, &cylinder);
}

#[test]
fn table_1_comes_out() {
    check_table_1(row);
}

#[test]
fn table_1_comes_out_of_rays() {
    check_table_1(traced);
}

#[test]
fn table_1_on_a_regular_grid_is_the_prototypes_to_two_digits() {
    // The prototype's points are those of a grid over each triangle, the sides' as good as the
    // inner ones; on the cylinder's straight sides there is no error at all.
    let parts = 40;
    for (name, max, mean) in [
        ("cylinder", "0.0053", "0.0017"),
        ("cone", "0.0086", "0.0028"),
        ("torus", "0.0156", "0.0030"),
    ] {
        let errors = grid_errors(&body(name), parts);
        let greatest = errors.iter().copied().fold(0.0, f64::max);
        let average = errors.iter().sum::<f64>() / errors.len() as f64;
        let printed = (format!("{greatest:.4}"), format!("{average:.4}"));
        assert_eq!(printed, (max.to_owned(), mean.to_owned()), "{name}");
    }
}

/// The angular surface's errors along the guide over the diameter.
fn grid_errors(body: &Body, parts: usize) -> Vec<f64> {
    let mut errors = Vec::new();
    for t in body.triangles() {
        let flags = PatchFlags::new(Surface::Angular).with_unchecked();
        let (positions, normals) = (t.positions.map(Into::into), t.normals.map(Into::into));
        let patch = Patch::<f64>::new(positions, normals, flags);
        for i in 0..=parts {
            for j in 0..=parts - i {
                let [u, v] = [i, j].map(|n| n as f64 / parts as f64);
                let guide: DVec3 = patch.guide_at(u, v).into();
                let position = patch.point(u, v).position.into();
                let t = body.true_parameter(position, guide).unwrap();
                errors.push((t * guide).length() / body.diameter());
            }
        }
    }
    errors
}

#[test]
fn spheres_are_exact() {
    let device = curvetri::linked::device().unwrap();
    for name in ["sphere-tetrahedron", "sphere-cube"] {
        for model in [ANGULAR, TENSOR, SMOOTH] {
            let exact = row(name, model);
            assert!(exact.max < 1e-14 && exact.normal_deg < 1e-12, "{exact:?}");
            let single =
                measure_traced(&device, &body(name), model, &AccuracyOptions::default()).unwrap();
            assert!(single.max < 2e-6 && single.missed == 0, "{single:?}");
            assert!(single.normal_deg < 1e-4, "{single:?}");
        }
        assert!(row(name, SurfaceModel::Flat).max > 0.2);
    }
}

#[test]
fn mean_errors_on_tori_are_the_known_ones() {
    for (name, model, mean) in [
        ("torus-12x16", SurfaceModel::Flat, 6.0e-3),
        ("torus-12x16", ANGULAR, 3.6e-4),
        ("torus-12x16", TENSOR, 2.7e-4),
        ("torus-12x16", SMOOTH, 2.6e-4),
        ("torus-12x16", PN, 4.4e-4),
        ("torus-12x16", NAGATA, 2.2e-4),
        ("torus-48x64", SurfaceModel::Flat, 3.8e-4),
        ("torus-48x64", ANGULAR, 3.2e-5),
        ("torus-48x64", TENSOR, 2.0e-6),
        ("torus-48x64", SMOOTH, 1.2e-6),
        ("torus-48x64", PN, 2.6e-6),
        ("torus-48x64", NAGATA, 2.6e-6),
        ("torus-96x128", SurfaceModel::Flat, 9.5e-5),
        ("torus-96x128", ANGULAR, 8.1e-6),
        ("torus-96x128", TENSOR, 2.4e-7),
        ("torus-96x128", SMOOTH, 1.2e-7),
        ("torus-96x128", PN, 2.6e-7),
        ("torus-96x128", NAGATA, 3.2e-7),
    ] {
        let row = row(name, model);
        assert_near(row.mean, mean, 0.075, &row);
    }
}

#[test]
fn normals_on_tori_are_the_known_ones() {
    for (model, normal) in [
        (SurfaceModel::Flat, 2.0),
        (ANGULAR, 1.17),
        (TENSOR, 0.057),
        (SMOOTH, 0.067),
        (PN, 0.060),
        (NAGATA, 0.081),
    ] {
        let row = row("torus-48x64", model);
        assert_near(row.normal_deg, normal, 0.11, &row);
    }
    for (name, model, jump, share) in [
        ("torus-12x16", SurfaceModel::Flat, 12.9, 0.1),
        ("torus-12x16", ANGULAR, 13.9, 0.05),
        ("torus-12x16", TENSOR, 0.32, 0.05),
        ("torus-12x16", SMOOTH, 0.011, 0.3),
        ("torus-48x64", SurfaceModel::Flat, 3.4, 0.05),
        ("torus-48x64", ANGULAR, 3.0, 0.2),
        ("torus-48x64", TENSOR, 0.0037, 0.15),
    ] {
        let row = row(name, model);
        assert_near(row.jump_deg.unwrap(), jump, share, &row);
    }
}

fn check_fine_torus(measured: impl Fn(&str, SurfaceModel) -> BodyRow) {
    let tensor = measured("torus-48x64", TENSOR);
    assert!(
        tensor.mean <= 2.1e-6 && tensor.jump_deg.unwrap() <= 0.005,
        "{tensor:?}"
    );
    let smooth = measured("torus-48x64", SMOOTH);
    assert!(
        smooth.mean <= 1.4e-6 && smooth.jump_deg.unwrap() <= 0.0005,
        "{smooth:?}"
    );
}

#[test]
fn fine_tori_are_as_good_and_as_smooth_as_promised() {
    check_fine_torus(row);
}

#[test]
fn fine_tori_are_as_good_and_as_smooth_for_rays() {
    check_fine_torus(traced);
}

#[test]
fn rays_find_what_the_formulas_say() {
    for name in ["cylinder", "cone", "torus-12x16", "torus-24x32"] {
        for model in SurfaceModel::OURS {
            let options = AccuracyOptions {
                samples: 20_000,
                ..AccuracyOptions::default()
            };
            let (exact, single) = (measure(&body(name), model, &options), traced(name, model));
            assert_near(single.max, exact.max, 0.005, &single);
            assert_near(single.mean, exact.mean, 0.005, &single);
            assert_near(single.normal_deg, exact.normal_deg, 0.005, &single);
            assert_eq!(single.jump_deg.is_some(), exact.jump_deg.is_some());
            if let (Some(single_jump), Some(jump)) = (single.jump_deg, exact.jump_deg) {
                assert_near(single_jump, jump, 0.02, &single);
            }
        }
    }
}

#[test]
fn only_the_coarse_torus_is_not_curved_throughout_by_default() {
    for body in bodies() {
        let options = AccuracyOptions {
            samples: 1,
            seed: 1,
        };
        let kept_flat = measure(&body, SMOOTH, &options).flat_by_default;
        assert_eq!(kept_flat > 0, body.name() == "torus", "{}", body.name());
    }
}

#[test]
fn a_cone_has_no_sides_to_jump_across() {
    assert_eq!(row("cone", SMOOTH).jump_deg, None);
    assert!(row("cylinder", SMOOTH).jump_deg.is_some());
}

#[test]
fn the_same_seed_gives_the_same_row() {
    let body = body("torus");
    let seeded = |seed| measure(&body, SMOOTH, &AccuracyOptions { samples: 500, seed });
    assert_eq!(seeded(3), seeded(3));
    assert_ne!(seeded(3).mean, seeded(4).mean);
}

#[test]
fn errors_fall_as_fast_as_known() {
    let mean = |name, model| row(name, model).mean;
    for (model, low, high) in [
        (SurfaceModel::Flat, 1.95, 2.05),
        (ANGULAR, 1.9, 2.1),
        (TENSOR, 3.0, 4.0),
        (SMOOTH, 3.2, 4.0),
        (PN, 3.0, 4.0),
        (SurfaceModel::Peer(Peer::Phong), 1.9, 2.1),
        (NAGATA, 2.9, 3.2),
    ] {
        let observed = order(mean("torus-48x64", model), mean("torus-96x128", model));
        assert!((low..high).contains(&observed), "{model:?}: {observed}");
    }
}

#[test]
fn the_papers_claim_against_nagata_holds_for_the_smooth_surface_only() {
    let needed = |model| {
        let found = triangles_needed(model, &[1e-3, 1e-4], 1);
        let count = |measure, error| {
            let goal = found
                .iter()
                .find(|n| n.measure == measure && n.error == error);
            goal.unwrap().triangles().unwrap()
        };
        [
            count(Measure::Mean, 1e-3),
            count(Measure::Mean, 1e-4),
            count(Measure::Max, 1e-3),
            count(Measure::Max, 1e-4),
        ]
    };
    let [flat, angular, smooth, nagata] = [SurfaceModel::Flat, ANGULAR, SMOOTH, NAGATA].map(needed);
    for goal in 0..4 {
        assert!(smooth[goal] <= nagata[goal] && nagata[goal] <= angular[goal]);
        assert!(angular[goal] < flat[goal] / 10);
    }
    assert!(smooth[3] < nagata[3] && 3 * nagata[3] < angular[3]);
}
