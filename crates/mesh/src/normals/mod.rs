//! Vertex normals: stored ones checked, missing ones made, and corners of the same position and
//! normal merged into vertices.

mod disjoint_sets;
mod fan;
mod flat_walls;
mod naive;
mod weights;

use std::collections::HashMap;
use std::ops::Range;

use glam::{DVec3, Vec3};
use rayon::prelude::*;

use crate::mesh::SAME_NORMAL_ANGLE;
use crate::topology::Groups;
use fan::{Fan, Smoothness};
use flat_walls::Walls;
use weights::NaiveWeight;

/// A stored normal whose length differs from 1 by more than this counts as renormalised.
const UNIT_TOLERANCE: f64 = 1e-3;

/// How many normals of one position are searched for near ones; beyond that only equal ones merge,
/// so that a malicious file cannot make the search quadratic.
const NEAR_SEARCH: usize = 64;

/// The crease angle where none is given.
const DEFAULT_CREASE_DEGREES: f32 = 30.0;

/// No normal: the index of a corner whose file names none.
pub const NO_NORMAL: u32 = u32::MAX;

/// How the normals of a mesh's vertices are chosen.
///
/// ```
/// use curvetri_mesh::{NormalOptions, NormalsPolicy, RawMesh};
/// use glam::DVec3;
///
/// let raw = RawMesh {
///     positions: vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::new(0.0, -1.0, -1.0)],
///     corners: vec![[0, 1, 2], [1, 0, 3]],
///     ..RawMesh::default()
/// };
/// // The two triangles meet at 45 degrees.
/// let smooth = NormalOptions {
///     policy: NormalsPolicy::Smooth,
///     crease_angle_degrees: Some(50.0),
/// };
/// assert_eq!(raw.clone().into_mesh(&smooth)?.0.normals().len(), 4);
/// assert_eq!(raw.into_mesh(&NormalOptions::default())?.0.normals().len(), 6);
/// # Ok::<(), curvetri_mesh::MeshError>(())
/// ```
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct NormalOptions {
    /// Which of the stored normals are used.
    pub policy: NormalsPolicy,
    /// Where normals are made, faces whose dihedral angle (in degrees, 0 where they lie in one
    /// plane) is at most this are smoothed into each other. A greater angle makes a hard edge. From
    /// 0 to 180.
    ///
    /// `None` is 30, but where a file has smoothing groups and its normals are missing or not
    /// wanted, the groups decide.
    pub crease_angle_degrees: Option<f32>,
}

/// Which of the normals that a file has are used.
///
/// ```
/// use curvetri_mesh::{Loader, NormalsPolicy};
///
/// let obj = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 1 0 1\nf 1//1 2//1 3//1\n";
/// let made = |policy| {
///     let loaded = Loader::new().normals(policy).load_bytes(obj.into(), "a.obj");
///     loaded.map(|loaded| loaded.report.normals.made)
/// };
/// assert_eq!(made(NormalsPolicy::Stored)?, 0);
/// assert_eq!(made(NormalsPolicy::Smooth)?, 3);
/// # Ok::<(), curvetri_mesh::LoadError>(())
/// ```
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Hash)]
pub enum NormalsPolicy {
    /// All that are usable; missing ones are made.
    Stored,
    /// None: all are made.
    Smooth,
    /// All that are usable, but not where a curved wall is stored with each triangle's own flat
    /// normal: there they are made. A region (triangles connected across edges that bend by no more
    /// than the crease angle) counts as stored flat if flat triangles with different normals meet at
    /// more than nine in ten of its edges, of those where the stored normals show anything.
    ///
    /// Nor where a program has written averages of the faces around each vertex, which say nothing that the
    /// faces do not: if that is what 95 % of the corners have, within 0.05 degrees, better normals are made
    /// where the greatest face is more than 8 times the least.
    #[default]
    Auto,
}

/// Where a mesh's normals come from, counted by triangle corners.
///
/// ```
/// let off = "OFF 3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
/// let loaded = curvetri_mesh::Loader::new().load_bytes(off.into(), "a.off")?;
/// let normals = loaded.report.normals;
/// assert_eq!((normals.stored, normals.made), (0, 3));
/// # Ok::<(), curvetri_mesh::LoadError>(())
/// ```
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct NormalsReport {
    /// Corners whose stored normal is used.
    pub stored: u64,
    /// Corners whose normal was made, because it is missing, unusable or not wanted.
    pub made: u64,
    /// Corners whose normal was made as the file's smoothing groups say.
    pub by_group: u64,
    /// Corners whose normal was made because the stored ones are flat on a curved wall
    /// ([`NormalsPolicy::Auto`]).
    pub faceted: u64,
    /// Corners whose normal was made because the stored one is an average of faces whose areas differ much
    /// ([`NormalsPolicy::Auto`]).
    pub averaged: u64,
    /// Corners whose stored normal is zero or not finite.
    pub unusable: u64,
    /// Corners whose stored normal was not of unit length, by more than 0.001.
    pub renormalised: u64,
    /// Corners whose stored normal points away from the triangle's front, the side from which it
    /// winds counter-clockwise.
    pub against_face: u64,
}

impl NormalsReport {
    pub(crate) fn add(self, other: NormalsReport) -> NormalsReport {
        NormalsReport {
            stored: self.stored + other.stored,
            made: self.made + other.made,
            by_group: self.by_group + other.by_group,
            faceted: self.faceted + other.faceted,
            averaged: self.averaged + other.averaged,
            unusable: self.unusable + other.unusable,
            renormalised: self.renormalised + other.renormalised,
            against_face: self.against_face + other.against_face,
        }
    }
}

/// Vertices distinct in (position, normal) and the triangles over them.
pub(crate) struct Vertices {
    pub(crate) positions: Vec<Vec3>,
    pub(crate) normals: Vec<Vec3>,
    pub(crate) triangles: Vec<[u32; 3]>,
    pub(crate) report: NormalsReport,
}

/// Stored normals and the corners' indices into them.
pub(crate) type Stored<'a> = Option<(&'a [DVec3], &'a [[u32; 3]])>;

/// What a file says of its normals.
#[derive(Clone, Copy, Default)]
pub(crate) struct GivenNormals<'a> {
    pub(crate) stored: Stored<'a>,
    /// A number for each triangle.
    pub(crate) smoothing_groups: Option<&'a [u32]>,
}

impl<'a> GivenNormals<'a> {
    /// The groups, where they decide what is smooth: they do where the file has no normals or they
    /// are not wanted, and no crease angle is given.
    fn deciding_groups(&self, options: &NormalOptions) -> Option<&'a [u32]> {
        let names_one = |(_, corners): (_, &[[u32; 3]])| {
            let mut indices = corners.as_flattened().iter();
            indices.any(|&index| index != NO_NORMAL)
        };
        let wants_made = options.policy == NormalsPolicy::Smooth;
        let decide = wants_made || !self.stored.is_some_and(names_one);
        self.smoothing_groups
            .filter(|_| decide && options.crease_angle_degrees.is_none())
    }
}

/// Gives each corner its normal and merges corners that agree in position and normal.
///
/// `places` are distinct positions and `corners` index them; every index has been checked.
/// Vertices come out in the order of their places.
pub(crate) fn assign(
    places: &[Vec3],
    corners: &[[u32; 3]],
    given: GivenNormals<'_>,
    options: &NormalOptions,
) -> Vertices {
    let groups = given.deciding_groups(options);
    let cos_crease = cos_crease(
        options
            .crease_angle_degrees
            .unwrap_or(DEFAULT_CREASE_DEGREES),
    );
    let stored = given
        .stored
        .filter(|_| options.policy != NormalsPolicy::Smooth);
    let faceted = match stored {
        Some((normals, normal_corners)) if options.policy == NormalsPolicy::Auto => {
            let walls = Walls {
                places,
                corners,
                normals,
                normal_corners,
                cos_crease,
            };
            walls.recognise()
        }
        _ => None,
    };
    let at_place = Groups::new(corners.as_flattened().iter().copied(), places.len());
    let mut maker = Assigner {
        places,
        corners,
        stored,
        faceted: faceted.as_deref(),
        smoothness: match groups {
            Some(groups) => Smoothness::Groups(groups),
            None => Smoothness::Crease(cos_crease),
        },
        at_place: &at_place,
        naive: None,
    };
    if options.policy == NormalsPolicy::Auto {
        maker.naive = maker.naive_weight();
    }
    let parts = tasks(at_place.len()).map(|range| maker.part(range));
    join(places, corners.len(), &at_place, parts.collect())
}

/// So many places in ranges, one a parallel task.
fn tasks(places: usize) -> impl IndexedParallelIterator<Item = Range<usize>> {
    const PLACES_A_TASK: usize = 8192;
    let ranges = (0..places.div_ceil(PLACES_A_TASK)).into_par_iter();
    ranges.map(move |task| {
        let first = task * PLACES_A_TASK;
        first..(first + PLACES_A_TASK).min(places)
    })
}

/// The cosine from which on two faces are joined. A thousandth of a degree is added so that a
/// prism whose faces turn by exactly the crease angle is joined all around or not at all.
fn cos_crease(degrees: f32) -> f64 {
    let degrees = f64::from(degrees);
    if degrees >= 180.0 {
        return f64::NEG_INFINITY;
    }
    (degrees.max(0.0) + 1e-3).to_radians().cos()
}

/// The vertices of a range of places.
#[derive(Default)]
struct Part {
    /// Normal of each vertex.
    normals: Vec<Vec3>,
    /// Place of each vertex.
    places: Vec<u32>,
    /// For the range's corners, grouped by place, their vertex counted from the range's first.
    vertex_of_corner: Vec<u32>,
    report: NormalsReport,
}

struct Assigner<'a> {
    places: &'a [Vec3],
    corners: &'a [[u32; 3]],
    stored: Stored<'a>,
    /// Triangles whose stored normals are flat on a curved wall.
    faceted: Option<&'a [bool]>,
    smoothness: Smoothness<'a>,
    at_place: &'a Groups,
    /// The average that the stored normals are, if they are no more than that.
    naive: Option<NaiveWeight>,
}

impl Assigner<'_> {
    fn part(&self, range: Range<usize>) -> Part {
        let mut part = Part::default();
        let mut fan = Fan::default();
        let mut normals = Vec::new();
        for place in range {
            self.corner_normals(place, &mut fan, &mut normals, &mut part.report);
            merge(place as u32, &normals, &mut part);
        }
        part
    }

    /// The normals of the corners at a place, in the order of the corners.
    fn corner_normals(
        &self,
        place: usize,
        fan: &mut Fan,
        normals: &mut Vec<DVec3>,
        report: &mut NormalsReport,
    ) {
        let corners = self.at_place.of(place);
        let is_faceted = |c: u32| self.faceted.is_some_and(|f| f[c as usize / 3]);
        normals.clear();
        normals.extend(corners.iter().map(|&c| {
            let stored = self.stored_normal(c, report);
            if is_faceted(c) { DVec3::ZERO } else { stored }
        }));
        let made = normals.iter().filter(|n| **n == DVec3::ZERO).count() as u64;
        report.stored += normals.len() as u64 - made;
        report.made += made;
        if let Smoothness::Groups(_) = self.smoothness {
            report.by_group += made;
        }
        if let Some(weight) = self.naive {
            fan.gather_faces(self.places, self.corners, corners);
            remake(weight, fan, normals, report);
        }
        if made == 0 {
            return;
        }
        fan.gather(self.places, self.corners, corners);
        fan.join(self.smoothness);
        fan.replace_zeros(normals);
        for (&c, normal) in corners.iter().zip(normals) {
            if is_faceted(c) {
                report.faceted += 1;
                // The stored ones say where the front is, even against the winding.
                if normal.dot(self.stored_normal(c, &mut NormalsReport::default())) < 0.0 {
                    *normal = -*normal;
                }
            }
        }
    }

    /// The stored normal of a corner made unit length, or zero where there is no usable one.
    fn stored_normal(&self, corner: u32, report: &mut NormalsReport) -> DVec3 {
        let Some((normals, indices)) = self.stored else {
            return DVec3::ZERO;
        };
        let index = indices.as_flattened()[corner as usize];
        if index == NO_NORMAL {
            return DVec3::ZERO;
        }
        let n = normals[index as usize];
        let scale = n.abs().max_element();
        if !n.is_finite() || scale == 0.0 {
            report.unusable += 1;
            return DVec3::ZERO;
        }
        let scaled = n / scale;
        if (scaled.length() * scale - 1.0).abs() > UNIT_TOLERANCE {
            report.renormalised += 1;
        }
        let unit = scaled.normalize();
        let [a, b, c] =
            self.corners[corner as usize / 3].map(|v| self.places[v as usize].as_dvec3());
        if (b - a).cross(c - a).dot(unit) < 0.0 {
            report.against_face += 1;
        }
        unit
    }
}

/// Puts better normals in place of averages of faces whose areas differ much.
fn remake(weight: NaiveWeight, fan: &Fan, normals: &mut [DVec3], report: &mut NormalsReport) {
    for group in naive::group(normals) {
        if let Some(made) = group.remade(weight, fan) {
            let count = group.members.len() as u64;
            report.averaged += count;
            report.made += count;
            report.stored -= count;
            for member in group.members {
                normals[member as usize] = made;
            }
        }
    }
}

/// Merges nearly equal normals of one place into vertices.
fn merge(place: u32, normals: &[DVec3], part: &mut Part) {
    let near = SAME_NORMAL_ANGLE * SAME_NORMAL_ANGLE;
    let first = part.normals.len();
    let mut further: HashMap<[u32; 3], u32> = HashMap::new();
    for n in normals {
        // Adding zero turns -0 into +0, so that equal normals have equal bits.
        let n = n.as_vec3() + Vec3::ZERO;
        let here = &part.normals[first..];
        let searched = &here[..here.len().min(NEAR_SEARCH)];
        let found = searched
            .iter()
            .position(|m| f64::from(m.distance_squared(n)) < near)
            .map(|i| (first + i) as u32);
        let found = found.or_else(|| further.get(&n.to_array().map(f32::to_bits)).copied());
        let vertex = found.unwrap_or_else(|| {
            let new = part.normals.len() as u32;
            if new as usize - first >= NEAR_SEARCH {
                further.insert(n.to_array().map(f32::to_bits), new);
            }
            part.normals.push(n);
            part.places.push(place);
            new
        });
        part.vertex_of_corner.push(vertex);
    }
}

/// Numbers the parts' vertices through.
fn join(places: &[Vec3], triangles: usize, at_place: &Groups, parts: Vec<Part>) -> Vertices {
    let count = parts.iter().map(|p| p.normals.len()).sum();
    let mut out = Vertices {
        positions: Vec::with_capacity(count),
        normals: Vec::with_capacity(count),
        triangles: vec![[0; 3]; triangles],
        report: NormalsReport::default(),
    };
    let corners = out.triangles.as_flattened_mut();
    let mut grouped = (0..at_place.len()).flat_map(|place| at_place.of(place));
    for part in parts {
        let first = out.normals.len() as u32;
        for vertex in part.vertex_of_corner {
            let corner = grouped.next().expect("as many corners as were grouped");
            corners[*corner as usize] = first + vertex;
        }
        out.positions
            .extend(part.places.iter().map(|&p| places[p as usize]));
        out.normals.extend(part.normals);
        out.report = out.report.add(part.report);
    }
    out
}
