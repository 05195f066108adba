//! The Utah teapot, from Martin Newell's Bezier patches of 1975, made closed.
//!
//! Of its 32 bicubic patches, the pot's are products of a profile and a quarter turn, and the
//! handle's and the spout's are mirrored in y with cross-sections of one kind; so the profiles and
//! cross-sections are all the numbers there are. (The original's lid knob has 0.45 where the quarter
//! turn's factor 0.56 gives 0.448; here it is 0.448.)
//!
//! The original is open. Here it is three closed bodies that overlap as its parts do:
//!
//! - the pot: bottom, body, rim and lid, with a flat ring over the gap between rim and lid;
//! - the handle: its lower end, which in the original just touches the pot and shows a slit, goes
//!   on straight into the pot, and both ends have flat caps, which are inside the pot;
//! - the spout: with a flat cap inside the pot and another in its mouth, as if filled to there.

use glam::{DVec2, DVec3};

use super::revolution::{ProfilePoint, Revolution, Soup};
use curvetri_mesh::Mesh;

/// A quarter turn's control points are (1, 0), (1, q), (q, 1), (0, 1), with this q.
const QUARTER: f64 = 0.56;

/// The pot's profile, radius and height, from the middle of the bottom to the top of the lid, as
/// cubic Bezier curves; the ring over the gap comes after the fourth.
const PROFILE: [[[f64; 2]; 4]; 6] = [
    [[0.0, 0.0], [1.425, 0.0], [1.5, 0.075], [1.5, 0.15]],
    [[1.5, 0.15], [1.5, 0.225], [2.0, 0.45], [2.0, 0.9]],
    [[2.0, 0.9], [2.0, 1.35], [1.75, 1.875], [1.5, 2.4]],
    [[1.5, 2.4], [1.4375, 2.53125], [1.3375, 2.53125], [1.4, 2.4]],
    [[1.3, 2.4], [1.3, 2.55], [0.4, 2.55], [0.2, 2.7]],
    [[0.2, 2.7], [0.0, 2.85], [0.8, 3.15], [0.0, 3.15]],
];

/// A cross-section of handle or spout, symmetric in y: x and z of its one edge, x and z of its
/// other, and the control points' distance from the plane y = 0.
type Section = [f64; 5];

const HANDLE: [Section; 7] = [
    [-1.6, 2.025, -1.5, 2.25, 0.3],
    [-2.3, 2.025, -2.5, 2.25, 0.3],
    [-2.7, 2.025, -3.0, 2.25, 0.3],
    [-2.7, 1.8, -3.0, 1.8, 0.3],
    [-2.7, 1.575, -3.0, 1.35, 0.3],
    [-2.5, 1.125, -2.65, 0.9375, 0.3],
    [-2.0, 0.9, -1.9, 0.6, 0.3],
];

const SPOUT: [Section; 7] = [
    [1.7, 1.425, 1.7, 0.6, 0.66],
    [2.6, 1.425, 3.1, 0.825, 0.66],
    [2.3, 2.1, 2.4, 2.025, 0.25],
    [2.7, 2.4, 3.3, 2.4, 0.25],
    [2.8, 2.475, 3.525, 2.49375, 0.25],
    [2.9, 2.475, 3.45, 2.5125, 0.15],
    [2.8, 2.4, 3.2, 2.4, 0.15],
];

/// How far the handle goes on into the pot, in steps between its last two control sections.
const HANDLE_EXTENSION: f64 = 0.5;

/// One of the closed bodies the teapot consists of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TeapotPart {
    /// Body and lid.
    Pot,
    /// The handle.
    Handle,
    /// The spout.
    Spout,
}

/// The teapot with its true normals, each patch cut into `cut` by `cut` quads of two triangles
/// (those of the spout's tip into twice as many along it); z is up, the bottom at 0 and the lid's top at 3.15. Three closed bodies that overlap; see
/// [`teapot_part`] for each alone.
///
/// # Panics
///
/// If `cut` is less than 2.
#[must_use]
pub fn teapot(cut: usize) -> Mesh {
    let mut all = pot(cut);
    all.append(tube(&handle(cut), cut));
    all.append(tube(&spout(cut), cut));
    all.mesh()
}

/// One of the teapot's closed bodies.
///
/// # Panics
///
/// If `cut` is less than 2.
#[must_use]
pub fn teapot_part(part: TeapotPart, cut: usize) -> Mesh {
    match part {
        TeapotPart::Pot => pot(cut).mesh(),
        TeapotPart::Handle => tube(&handle(cut), cut).mesh(),
        TeapotPart::Spout => tube(&spout(cut), cut).mesh(),
    }
}

/// The parameters at which a patch is cut: both ends included, and exact.
fn cuts(cut: usize) -> impl Iterator<Item = f64> + Clone {
    assert!(cut > 1, "a patch is cut into 2 by 2 pieces or more");
    (0..=cut).map(move |i| i as f64 / cut as f64)
}

/// The Bernstein polynomials of third degree.
fn bernstein(t: f64) -> [f64; 4] {
    let s = 1.0 - t;
    [s * s * s, 3.0 * s * s * t, 3.0 * s * t * t, t * t * t]
}

/// A cubic Bezier curve's point and derivative.
fn bezier<const N: usize>(control: &[[f64; N]; 4], t: f64) -> ([f64; N], [f64; N]) {
    let b = bernstein(t);
    let s = 1.0 - t;
    let d = [3.0 * s * s, 6.0 * s * t, 3.0 * t * t];
    let point = |n: usize| (0..4).map(|i| b[i] * control[i][n]).sum();
    let slope = |n: usize| {
        (0..3)
            .map(|i| d[i] * (control[i + 1][n] - control[i][n]))
            .sum()
    };
    (std::array::from_fn(point), std::array::from_fn(slope))
}

fn pot(cut: usize) -> Soup {
    let mut pot = Revolution::new(turn(cut));
    for (i, curve) in PROFILE.iter().enumerate() {
        let points: Vec<ProfilePoint> = cuts(cut).map(|t| profile_point(curve, t)).collect();
        for pair in points.windows(2) {
            pot.band([pair[0], pair[1]]);
        }
        if i == 3 {
            let [rim, lid] = [curve[3], PROFILE[4][0]].map(DVec2::from);
            pot.band([(rim, DVec2::Y), (lid, DVec2::Y)]);
        }
    }
    pot.soup()
}

fn profile_point(curve: &[[f64; 2]; 4], t: f64) -> ProfilePoint {
    let (point, [by_radius, by_height]) = bezier(curve, t);
    (point.into(), DVec2::new(by_height, -by_radius))
}

/// A whole turn of four quarters: points and outward normals, these so long that their product
/// with the points is 1; then a profile's normal (a, b) is (a * outward, b) for the body.
fn turn(cut: usize) -> Vec<(DVec2, DVec2)> {
    let control = [[1.0, 0.0], [1.0, QUARTER], [QUARTER, 1.0], [0.0, 1.0]];
    let quarter: Vec<(DVec2, DVec2)> = cuts(cut)
        .take(cut)
        .map(|t| {
            let (point, slope) = bezier(&control, t);
            let (point, slope) = (DVec2::from(point), DVec2::from(slope));
            (point, -slope.perp() / point.perp_dot(slope))
        })
        .collect();
    let mut turned = quarter;
    for i in 0..3 * cut {
        let (point, outward) = turned[i];
        turned.push((point.perp(), outward.perp()));
    }
    turned
}

/// A cross-section and its derivative along the tube.
type Ring = (Section, Section);

/// The rings over two curves of sections, each cut along the tube into its number of pieces.
fn rings(control: &[Section; 7], cut: [usize; 2]) -> Vec<Ring> {
    let (first, _) = control.split_first_chunk::<4>().expect("seven sections");
    let (_, second) = control.split_last_chunk::<4>().expect("seven sections");
    let second_rings = cuts(cut[1]).skip(1).map(|t| bezier(second, t));
    cuts(cut[0])
        .map(|t| bezier(first, t))
        .chain(second_rings)
        .collect()
}

fn handle(cut: usize) -> Vec<Ring> {
    let mut rings = rings(&HANDLE, [cut; 2]);
    let [before, last] = [HANDLE[5], HANDLE[6]];
    let step: Section = std::array::from_fn(|i| last[i] - before[i]);
    let end = std::array::from_fn(|i| last[i] + HANDLE_EXTENSION * step[i]);
    rings.push((end, step));
    rings
}

fn spout(cut: usize) -> Vec<Ring> {
    // The lip turns by more than half a circle within the second curve.
    rings(&SPOUT, [cut, 2 * cut])
}

/// A closed tube over cross-sections, with a flat cap at each end.
fn tube(rings: &[Ring], cut: usize) -> Soup {
    let outlines: Vec<Vec<(DVec3, DVec3)>> = rings.iter().map(|r| outline(r, cut)).collect();
    let mut soup = Soup::default();
    for pair in outlines.windows(2) {
        let count = pair[0].len();
        for i in 0..count {
            let next = (i + 1) % count;
            let mut quad = [pair[0][i], pair[0][next], pair[1][next], pair[1][i]];
            // The other half is the mirror image, diagonals included.
            if 2 * i >= count {
                quad.rotate_left(1);
            }
            soup.quad(quad);
        }
    }
    let ends = [&outlines[0], &outlines[outlines.len() - 1]];
    let [first, last] = ends.map(|end| end.iter().map(|corner| corner.0).collect::<Vec<_>>());
    cap(&mut soup, first.into_iter().rev().collect());
    cap(&mut soup, last);
    soup
}

/// A cap over an outline that is counter-clockwise seen from outside.
fn cap(soup: &mut Soup, outline: Vec<DVec3>) {
    let centre = outline.iter().sum::<DVec3>() / outline.len() as f64;
    let area: DVec3 = (0..outline.len())
        .map(|i| (outline[i] - centre).cross(outline[(i + 1) % outline.len()] - centre))
        .sum();
    soup.cap(&outline, centre, area.normalize());
}

/// The points and normals around a cross-section.
fn outline((section, along): &Ring, cut: usize) -> Vec<(DVec3, DVec3)> {
    let mut outline: Vec<(DVec3, DVec3)> = cuts(cut)
        .map(|t| {
            let (point, across) = section_point(section, t);
            // The derivative along the tube is made of the sections' derivatives in the same way.
            let (along, _) = section_point(along, t);
            (point, across.cross(along))
        })
        .collect();
    let mirror = |v: DVec3| DVec3::new(v.x, -v.y, v.z);
    for i in (1..cut).rev() {
        let (point, normal) = outline[i];
        outline.push((mirror(point), mirror(normal)));
    }
    outline
}

/// A point on the half of a cross-section where y is not positive, and the derivative there.
fn section_point(&[x0, z0, x1, z1, width]: &Section, t: f64) -> (DVec3, DVec3) {
    let control = [
        [x0, 0.0, z0],
        [x0, -width, z0],
        [x1, -width, z1],
        [x1, 0.0, z1],
    ];
    let (point, slope) = bezier(&control, t);
    (point.into(), slope.into())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::revolution::tests::check_closed;

    #[test]
    fn each_part_is_closed_with_normals_outward_at_any_cut() {
        for part in [TeapotPart::Pot, TeapotPart::Handle, TeapotPart::Spout] {
            for (cut, least) in [(2, -0.3), (4, 0.2), (16, 0.8)] {
                check_closed(&teapot_part(part, cut), least);
            }
        }
    }

    #[test]
    fn hard_edges_are_only_at_the_lid_and_the_caps() {
        let cut = 5;
        let hard = |part| check_closed(&teapot_part(part, cut), 0.0).hard;
        assert_eq!(hard(TeapotPart::Pot), 2 * 4 * cut as u64);
        assert_eq!(hard(TeapotPart::Handle), 2 * 2 * cut as u64);
        assert_eq!(hard(TeapotPart::Spout), 2 * 2 * cut as u64);
    }

    #[test]
    fn the_whole_is_its_parts_and_has_the_teapots_size() {
        let mesh = teapot(4);
        check_closed(&mesh, 0.2);
        let parts = [TeapotPart::Pot, TeapotPart::Handle, TeapotPart::Spout];
        let sum: usize = parts
            .map(|p| teapot_part(p, 4).triangles().len())
            .iter()
            .sum();
        assert_eq!(mesh.triangles().len(), sum);
        let bounds = mesh.bounds();
        let size = bounds.max - bounds.min;
        assert!(
            (size - DVec3::new(6.43, 4.0, 3.15)).abs().max_element() < 0.02,
            "{size}"
        );
    }

    #[test]
    fn ends_that_should_be_inside_the_pot_are() {
        // The pot's radius at a height, from the cut profile.
        let radius_at = |z: f64| {
            PROFILE[..3]
                .iter()
                .flat_map(|c| cuts(1000).map(|t| profile_point(c, t).0))
                .min_by(|a, b| (a.y - z).abs().total_cmp(&(b.y - z).abs()))
                .map_or(0.0, |p| p.x)
        };
        let handle = handle(8);
        for ring in [&handle[0], &handle[handle.len() - 1], &spout(8)[0]] {
            for (p, _) in outline(ring, 8) {
                assert!(p.truncate().length() < radius_at(p.z) - 0.02, "{p}");
            }
        }
    }
}
