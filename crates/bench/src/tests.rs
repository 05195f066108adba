use super::*;
use curvetri_bodies::bumpy_torus;

fn tiny(forms: Vec<NamedForm>) -> (Subject, BenchOptions) {
    let subject = Subject {
        name: "tiny".to_owned(),
        mesh: bumpy_torus(3000),
        truth: Some(curvetri_bodies::bumpy_torus_distance),
    };
    let options = BenchOptions {
        forms,
        rays: 4096,
        rounds: 1,
        threads: vec![1],
        ways: Way::ALL.to_vec(),
        ..BenchOptions::default()
    };
    (subject, options)
}

#[test]
fn all_forms_see_the_same_rays_and_hit_alike() {
    let (subject, options) = tiny(forms());
    let report = measure(&subject, &options, &|_| ()).unwrap();
    assert_eq!(report.forms.len(), options.forms.len());
    let flat = report.form(BASELINE).unwrap();
    for form in &report.forms {
        assert_eq!(form.outcome, Outcome::Measured, "{}", form.name);
        assert!(!form.rows.is_empty());
        for row in &form.rows {
            let at = format!("{} {} {}", form.name, row.kind.name(), row.way.name());
            let flat = flat.best(row.kind, 1).unwrap();
            assert_eq!(row.rays, flat.rays, "{at}");
            let off = (row.hit_share() - flat.hit_share()).abs();
            // Catmull-Clark surfaces lie inside of their vertices
            let most = if form.name.starts_with("subdivision") {
                0.06
            } else {
                0.02
            };
            assert!(off < most, "{at}: {} {}", row.hit_share(), flat.hit_share());
            let curved = form.bytes.records > 0;
            assert_eq!(row.kernel.calls > 0, curved, "{at}");
            assert!(row.lanes_used() <= 1.0);
        }
        assert!(form.bytes.total() > 0 && form.times.total() > 0.0);
    }
    let primary = flat.best(RayKind::Primary, 1).unwrap();
    assert!(primary.hit_share() >= 0.6, "{}", primary.hit_share());
}

#[test]
fn goals_are_drawn_from_what_was_measured() {
    let wanted = ["flat", "smooth", "tessellated-x16"];
    let some = forms()
        .into_iter()
        .filter(|form| wanted.contains(&form.name.as_str()));
    let (subject, options) = tiny(some.collect());
    let report = measure(&subject, &options, &|_| ()).unwrap();
    let goals = goals(&[report], None);
    let reached = |what: &str| {
        let goal = goals.iter().find(|goal| goal.what.starts_with(what));
        goal.unwrap_or_else(|| panic!("no goal {what}")).reached
    };
    assert!(reached("primary rays: smooth over flat").unwrap() > 0.0);
    assert!(reached("primary rays: smooth over tessellated-x16").unwrap() > 0.0);
    assert!(reached("build time").unwrap() > 0.0);
    assert_eq!(reached("diffuse rays: smooth over tessellated-x64"), None);
    assert_eq!(reached("bytes at equal error"), None);
}

#[test]
fn what_does_not_fit_into_memory_is_left_out_with_a_reason() {
    let wanted = ["smooth", "tessellated-x64"];
    let some = forms()
        .into_iter()
        .filter(|form| wanted.contains(&form.name.as_str()));
    let (subject, options) = tiny(some.collect());
    let options = BenchOptions {
        memory: 10_000_000,
        kinds: vec![RayKind::Primary],
        ..options
    };
    let report = measure(&subject, &options, &|_| ()).unwrap();
    assert!(report.form("smooth").is_some());
    let left_out = report.forms.last().unwrap();
    assert!(matches!(&left_out.outcome, Outcome::Skipped(why) if why.contains("GB")));
}

#[test]
fn a_torus_needs_more_bytes_flat_than_curved() {
    let torus = torus_bytes().unwrap();
    assert!(torus.parts > 4, "{torus:?}");
    assert!(
        torus.tessellated > 4 * torus.grids && torus.grids > torus.curved,
        "{torus:?}"
    );
}

#[test]
fn the_median_is_in_the_middle() {
    assert_eq!(median([3.0, 1.0, 2.0].into_iter()), 2.0);
    assert_eq!(median([4.0, 1.0].into_iter()), 2.5);
    assert_eq!(median(std::iter::empty()), 0.0);
}
