//! Recognises stored normals that say no more than the triangles do.
//!
//! Many programs write normals that are averages over the faces around each vertex. Such a normal tilts a large
//! panel beside a narrow chamfer by half the bend, and the panel bulges. Corners at one place with the same
//! stored normal are a group: the faces that the program smoothed into each other. If nearly all of a file's
//! normals are one and the same average over their groups, they carry no knowledge. They are made anew where
//! another average serves better, which is where large faces meet small ones. All others stay as they are: at
//! regular faces exact normals are averages as well.

use std::sync::{Mutex, PoisonError};

use glam::DVec3;
use rayon::prelude::*;

use super::fan::Fan;
use super::weights::{Areas, Face, LEAST_RATIO, NaiveWeight};
use super::{Assigner, tasks};
use crate::mesh::SAME_NORMAL_ANGLE;

/// How far (0.05 degrees) a stored normal may be off an average: what a few decimals of a text file round by.
const SAME_AVERAGE: f64 = 8.7e-4;

/// So many of a file's normals are an average if they carry no knowledge.
const NAIVE_SHARE: f64 = 0.95;

/// At a place with more groups than this the further ones are left alone, so that a malicious file cannot make
/// the search quadratic.
const MOST_GROUPS: usize = 64;

/// Corners at one place with the same stored normal.
pub(super) struct Group {
    /// The stored normal, unit.
    normal: DVec3,
    /// Places in the list of the place's corners.
    pub members: Vec<u32>,
}

impl Group {
    fn faces<'a>(&'a self, fan: &'a Fan) -> impl Iterator<Item = Face> + Clone + 'a {
        self.members.iter().map(|&member| fan.face(member as usize))
    }

    /// Whether the stored normal is this average, whichever way the triangles wind.
    fn is_average(&self, weight: NaiveWeight, fan: &Fan) -> bool {
        let average = weight.sum(self.faces(fan)).normalize_or_zero();
        let off = |sign: f64| (self.normal - sign * average).length_squared();
        off(1.0).min(off(-1.0)) < SAME_AVERAGE * SAME_AVERAGE
    }

    /// Whether areas make another average than the angles' alone.
    fn is_uneven(&self, fan: &Fan) -> bool {
        Areas::of(self.faces(fan)).ratio() > LEAST_RATIO
    }

    /// The normal that serves better than this average; none where the stored one stays.
    pub fn remade(&self, weight: NaiveWeight, fan: &Fan) -> Option<DVec3> {
        if !self.is_uneven(fan) || !self.is_average(weight, fan) {
            return None;
        }
        let areas = Areas::of(self.faces(fan));
        let made = areas.sum(self.faces(fan)).try_normalize()?;
        Some(made * made.dot(self.normal).signum())
    }
}

/// Groups the corners of a place by their stored unit normals; those without one (zero) are in no group.
pub(super) fn group(normals: &[DVec3]) -> Vec<Group> {
    let mut groups: Vec<Group> = Vec::new();
    for (member, &normal) in (0u32..).zip(normals) {
        if normal == DVec3::ZERO {
            continue;
        }
        let same = |group: &Group| group.normal.distance(normal) < SAME_NORMAL_ANGLE;
        match groups.iter().position(same) {
            Some(group) => groups[group].members.push(member),
            None if groups.len() < MOST_GROUPS => groups.push(Group {
                normal,
                members: vec![member],
            }),
            None => (),
        }
    }
    groups
}

/// What the stored normals of some corners are.
#[derive(Clone, Copy, Default)]
struct Votes {
    /// Corners that have one.
    corners: u64,
    /// Of how many it is each of the averages.
    averages: [u64; NaiveWeight::ALL.len()],
    /// Whether a group has faces of so different areas that its normal would be made anew.
    any_uneven: bool,
}

impl Votes {
    fn add(&mut self, other: Self) {
        self.corners += other.corners;
        for (sum, more) in self.averages.iter_mut().zip(other.averages) {
            *sum += more;
        }
        self.any_uneven |= other.any_uneven;
    }

    /// Whether some average may still turn out to be nearly all normals of so many corners.
    fn may_be_naive(&self, all: u64) -> bool {
        let most_others = (1.0 - NAIVE_SHARE) * all as f64;
        let others = |votes: &u64| (self.corners - votes) as f64;
        self.averages
            .iter()
            .any(|votes| others(votes) <= most_others)
    }
}

impl Assigner<'_> {
    /// The average that nearly all stored normals are; `None` if they are more than that, or would all stay as
    /// they are.
    pub(super) fn naive_weight(&self) -> Option<NaiveWeight> {
        self.stored?;
        let all = 3 * self.corners.len() as u64;
        let so_far = Mutex::new(Votes::default());
        // Most files are known to be more than averages long before their end.
        tasks(self.at_place.len()).try_for_each(|places| {
            let mut votes = Votes::default();
            let mut fan = Fan::default();
            places.for_each(|place| votes.add(self.votes(place, &mut fan)));
            let mut so_far = so_far.lock().unwrap_or_else(PoisonError::into_inner);
            so_far.add(votes);
            so_far.may_be_naive(all).then_some(())
        })?;
        let votes = so_far.into_inner().unwrap_or_else(PoisonError::into_inner);
        let by_votes = (votes.averages.into_iter()).zip(NaiveWeight::ALL);
        let (most, weight) = by_votes.max_by_key(|(votes, _)| *votes)?;
        let is_naive = most as f64 >= NAIVE_SHARE * votes.corners as f64 && most > 0;
        (is_naive && votes.any_uneven).then_some(weight)
    }

    fn votes(&self, place: usize, fan: &mut Fan) -> Votes {
        let corners = self.at_place.of(place);
        let mut unread = super::NormalsReport::default();
        let normals: Vec<DVec3> = (corners.iter())
            .map(|&corner| self.stored_normal(corner, &mut unread))
            .collect();
        fan.gather_faces(self.places, self.corners, corners);
        let with_normal = normals.iter().filter(|normal| **normal != DVec3::ZERO);
        let mut votes = Votes {
            corners: with_normal.count() as u64,
            ..Votes::default()
        };
        for group in group(&normals) {
            votes.any_uneven |= group.is_uneven(fan);
            for (sum, weight) in votes.averages.iter_mut().zip(NaiveWeight::ALL) {
                if group.is_average(weight, fan) {
                    *sum += group.members.len() as u64;
                }
            }
        }
        votes
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Mesh, NormalOptions, NormalsPolicy, NormalsReport, RawMesh};

    /// A cube of half the size 1 whose edges and corners are cut off, `chamfer` wide on each panel.
    fn chamfered_box(chamfer: f64) -> RawMesh {
        let inner = 1.0 - chamfer;
        let signs = [-1.0, 1.0];
        let mut raw = RawMesh::default();
        let mut add = |corners: &[DVec3]| {
            let first = raw.positions.len() as u32;
            let outside = (corners[1] - corners[0])
                .cross(corners[2] - corners[0])
                .dot(corners[0])
                > 0.0;
            raw.positions.extend(corners);
            for n in 1..corners.len() as u32 - 1 {
                let [b, c] = if outside { [n, n + 1] } else { [n + 1, n] };
                raw.corners.push([first, first + b, first + c]);
            }
        };
        let turned = |v: [f64; 3], axis: usize| {
            DVec3::new(v[(3 - axis) % 3], v[(4 - axis) % 3], v[(5 - axis) % 3])
        };
        for axis in 0..3 {
            for s in signs {
                let panel = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
                add(&panel.map(|[y, z]| turned([s, inner * y, inner * z], axis)));
                for t in signs {
                    let (a, b) = ([s, t * inner], [s * inner, t]);
                    let corner = |[x, y]: [f64; 2], z: f64| turned([x, y, z * inner], axis);
                    add(&[
                        corner(a, -1.0),
                        corner(b, -1.0),
                        corner(b, 1.0),
                        corner(a, 1.0),
                    ]);
                }
            }
        }
        for [x, y, z] in [
            [1.0, 1.0, 1.0],
            [1.0, 1.0, -1.0],
            [1.0, -1.0, 1.0],
            [1.0, -1.0, -1.0],
        ] {
            for s in signs {
                let [x, y, z] = [x, y, z].map(|v| s * v);
                let at = |a, b, c| DVec3::new(a * x, b * y, c * z);
                add(&[
                    at(1.0, inner, inner),
                    at(inner, 1.0, inner),
                    at(inner, inner, 1.0),
                ]);
            }
        }
        raw
    }

    fn normals(raw: RawMesh, policy: NormalsPolicy) -> (Mesh, NormalsReport) {
        let options = NormalOptions {
            policy,
            crease_angle_degrees: Some(60.0),
        };
        let (mesh, report) = raw.into_mesh(&options).unwrap();
        (mesh, report.normals)
    }

    /// The greatest angle, in degrees, of a panel's normals to the panel.
    fn tilt(mesh: &Mesh, chamfer: f64) -> f64 {
        let inner = (1.0 - chamfer) as f32;
        let mut greatest: f64 = 0.0;
        let mut panels = 0;
        for triangle in mesh.triangles() {
            let [a, b, c] = triangle.map(|v| mesh.positions()[v as usize]);
            let plane = (b - a).cross(c - a);
            let along = plane.normalize().abs().max_element();
            if along > 0.999 && plane.length() > inner * inner {
                panels += 1;
                for v in triangle {
                    let normal = mesh.normals()[*v as usize].as_dvec3();
                    greatest = greatest.max(normal.angle_between(plane.as_dvec3()).to_degrees());
                }
            }
        }
        assert_eq!(panels, 12);
        greatest
    }

    /// The same with the normals of the made mesh of another weight stored at each corner.
    fn with_stored(raw: &RawMesh, weight: NaiveWeight) -> RawMesh {
        let mut raw = raw.clone();
        let places: Vec<_> = raw.positions.iter().map(|p| p.as_vec3()).collect();
        let (place_of, count) = crate::topology::weld(&places);
        let mut sums = vec![Vec::new(); count];
        for triangle in &raw.corners {
            for k in 0..3 {
                let p = [0, 1, 2].map(|n| raw.positions[triangle[(k + n) % 3] as usize]);
                let cross = (p[1] - p[0]).cross(p[2] - p[0]);
                sums[place_of[triangle[k] as usize] as usize].push(Face {
                    normal: cross.normalize(),
                    angle: (p[1] - p[0]).angle_between(p[2] - p[0]),
                    area: cross.length(),
                });
            }
        }
        raw.normals = sums
            .into_iter()
            .map(|faces| weight.sum(faces.into_iter()).normalize())
            .collect();
        raw.normal_corners = Some(
            raw.corners
                .iter()
                .map(|triangle| triangle.map(|v| place_of[v as usize]))
                .collect(),
        );
        raw
    }

    #[test]
    fn panels_beside_narrow_chamfers_stay_flat() {
        for (chamfer, most) in [(0.2, 6.0), (0.1, 0.5), (0.05, 0.15)] {
            let (mesh, report) = normals(chamfered_box(chamfer), NormalsPolicy::Smooth);
            assert_eq!(report.made, 3 * mesh.triangles().len() as u64);
            let tilt = tilt(&mesh, chamfer);
            assert!(tilt < most, "chamfer {chamfer}: {tilt} degrees");
            assert!(
                tilt > 0.0,
                "the panel's corners are smooth into the chamfer"
            );
        }
    }

    #[test]
    fn averages_that_a_program_wrote_are_made_anew_where_areas_differ() {
        for weight in NaiveWeight::ALL {
            let raw = with_stored(&chamfered_box(0.05), weight);
            let (kept, report) = normals(raw.clone(), NormalsPolicy::Stored);
            assert_eq!((report.made, report.averaged), (0, 0));
            let (remade, report) = normals(raw, NormalsPolicy::Auto);
            assert_eq!(report.averaged, report.made);
            assert_eq!(
                report.made,
                3 * remade.triangles().len() as u64,
                "{weight:?}"
            );
            let [before, after] = [&kept, &remade].map(|mesh| tilt(mesh, 0.05));
            assert!(after < 0.15, "{weight:?}: {before}, then {after} degrees");
        }
    }

    #[test]
    fn averages_of_even_faces_and_normals_that_know_more_are_kept() {
        let even = with_stored(&chamfered_box(0.4), NaiveWeight::Angle);
        assert_eq!(normals(even, NormalsPolicy::Auto).1.made, 0);
        // exact normals of a box whose edges are rounded off: the panels' own at the panels
        let mut exact = chamfered_box(0.05);
        exact.normals = exact
            .positions
            .iter()
            .map(|p| {
                let panel = p.abs().max_position();
                let mut normal = DVec3::ZERO;
                normal[panel] = p[panel].signum();
                normal
            })
            .collect();
        exact.normal_corners = Some(exact.corners.clone());
        let report = normals(exact, NormalsPolicy::Auto).1;
        assert_eq!((report.made, report.averaged), (0, 0));
    }

    #[test]
    fn normals_against_the_winding_stay_on_their_side() {
        let mut raw = with_stored(&chamfered_box(0.05), NaiveWeight::Area);
        for normal in &mut raw.normals {
            *normal = -*normal;
        }
        let (mesh, report) = normals(raw, NormalsPolicy::Auto);
        assert!(report.averaged > 0);
        let inwards = |(p, n): (&glam::Vec3, &glam::Vec3)| p.dot(*n) < 0.0;
        assert!(mesh.positions().iter().zip(mesh.normals()).all(inwards));
    }
}
