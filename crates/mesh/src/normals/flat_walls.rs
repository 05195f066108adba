//! Recognises curved walls that are stored with flat normals.
//!
//! Many programs store each triangle or polygon of a part with one normal at all its corners,
//! whatever the part is. A triangle is *flat* here if that normal is about its plane's. A *region* is
//! a set of triangles connected across edges that bend by no more than the crease angle. Each edge in
//! it votes: for flat where two flat triangles with different normals meet, for smooth where both
//! triangles have the same normals at both ends. If nearly all edges vote for flat, the file knows
//! nothing of smoothness, and the normals of the region's flat triangles are made anew. Otherwise the
//! file distinguishes smooth from hard, and its normals are used.

use glam::{DVec3, Vec3};
use rayon::prelude::*;

use super::disjoint_sets::DisjointSets;
use super::fan::plane_normal;
use crate::mesh::SAME_NORMAL_ANGLE;
use crate::normals::NO_NORMAL;
use crate::topology::Groups;

/// The cosine of how far (20 degrees) a flat triangle's normal may be off its plane's: polygons of
/// more corners are not quite plane.
const COS_ALONG_PLANE: f64 = 0.94;

/// A region is stored flat if more than this share of its votes are for flat.
const FLAT_SHARE: f64 = 0.9;

/// How many such votes a curved wall has at least: fewer are a roof or a bevel.
const LEAST_EDGES: u64 = 3;

/// At an edge with more triangles than this nothing is joined: it is no surface.
const MAX_USES: usize = 16;

/// A mesh with stored normals.
pub(super) struct Walls<'a> {
    pub(super) places: &'a [Vec3],
    pub(super) corners: &'a [[u32; 3]],
    pub(super) normals: &'a [DVec3],
    pub(super) normal_corners: &'a [[u32; 3]],
    /// The cosine of the crease angle.
    pub(super) cos_crease: f64,
}

/// A triangle's plane.
#[derive(Clone, Copy)]
struct Plane {
    /// Its unit normal by the winding; zero for a triangle too thin to have one.
    normal: Vec3,
    /// The one normal that is stored at all its corners, or zero.
    flat: Vec3,
}

/// How a region's edges vote.
#[derive(Clone, Copy, Default)]
struct Votes {
    flat: u64,
    smooth: u64,
}

impl Walls<'_> {
    /// Which triangles have flat normals in place of a curved wall's; `None` if none has.
    pub(super) fn recognise(&self) -> Option<Vec<bool>> {
        let triangles = 0..self.corners.len();
        let planes: Vec<Plane> = triangles.into_par_iter().map(|t| self.plane(t)).collect();
        if !planes.iter().any(Plane::is_flat) {
            return None;
        }
        let mut regions = DisjointSets::new(self.corners.len());
        let mut cast: Vec<(u32, bool)> = Vec::new();
        self.for_joined(&planes, |a, b| {
            regions.unite(a as u32 / 3, b as u32 / 3);
            let [pa, pb] = [planes[a / 3], planes[b / 3]];
            if pa.is_flat() && pb.is_flat() {
                // No vote where both have the same normal: they are parts of one polygon or plane.
                if f64::from(pa.flat.distance(pb.flat)) > SAME_NORMAL_ANGLE {
                    cast.push((a as u32 / 3, false));
                }
            } else if self.agree(a, b) {
                cast.push((a as u32 / 3, true));
            }
        });
        let mut votes = vec![Votes::default(); self.corners.len()];
        for (triangle, smooth) in cast {
            let votes = &mut votes[regions.root(triangle) as usize];
            *(if smooth {
                &mut votes.smooth
            } else {
                &mut votes.flat
            }) += 1;
        }
        let stored_flat: Vec<bool> = (0..self.corners.len())
            .map(|t| planes[t].is_flat() && votes[regions.root(t as u32) as usize].is_flat())
            .collect();
        stored_flat.contains(&true).then_some(stored_flat)
    }

    fn plane(&self, triangle: usize) -> Plane {
        let places = self.corners[triangle].map(|v| self.places[v as usize].as_dvec3());
        let normal = plane_normal(places);
        let stored = self.normal_corners[triangle].map(|n| self.unit(n));
        let is_one = stored
            .iter()
            .all(|n| n.distance(stored[0]) < SAME_NORMAL_ANGLE);
        // A triangle may wind against its normals: then the two are opposite.
        let is_along = stored[0].dot(normal).abs() > COS_ALONG_PLANE;
        Plane {
            normal: normal.as_vec3(),
            flat: if is_one && is_along {
                stored[0].as_vec3()
            } else {
                Vec3::ZERO
            },
        }
    }

    fn unit(&self, normal: u32) -> DVec3 {
        if normal == NO_NORMAL {
            return DVec3::ZERO;
        }
        self.normals[normal as usize].normalize_or_zero()
    }

    /// Calls `pair` for each edge that two triangles share and at which they bend by no more than
    /// the crease angle, with the numbers of the corners that the edge starts from on both.
    fn for_joined(&self, planes: &[Plane], mut pair: impl FnMut(usize, usize)) {
        let ends = |edge: usize| {
            let t = self.corners[edge / 3];
            (t[edge % 3], t[(edge % 3 + 1) % 3])
        };
        let lower_ends = (0..3 * self.corners.len()).map(|edge| {
            let (from, to) = ends(edge);
            from.min(to)
        });
        let by_lower = Groups::new(lower_ends, self.places.len());
        let mut uses: Vec<(u32, bool, u32)> = Vec::new();
        for place in 0..self.places.len() {
            uses.clear();
            uses.extend(by_lower.of(place).iter().map(|&edge| {
                let (from, to) = ends(edge as usize);
                (from.max(to), from as usize == place, edge)
            }));
            uses.sort_unstable();
            for same in uses.chunk_by(|a, b| a.0 == b.0) {
                if same.len() > MAX_USES || same[0].0 as usize == place {
                    continue;
                }
                let (falling, rising) = same.split_at(same.partition_point(|s| !s.1));
                for a in falling {
                    for b in rising {
                        let [na, nb] = [a.2, b.2].map(|s| planes[s as usize / 3].normal);
                        if f64::from(na.dot(nb)) >= self.cos_crease {
                            pair(a.2 as usize, b.2 as usize);
                        }
                    }
                }
            }
        }
    }

    /// Whether two triangles have the same normals at both ends of an edge that runs in opposite
    /// directions on them.
    fn agree(&self, a: usize, b: usize) -> bool {
        let at_ends = |edge: usize| {
            let n = self.normal_corners[edge / 3];
            [n[edge % 3], n[(edge % 3 + 1) % 3]].map(|n| self.unit(n))
        };
        let ([a0, a1], [b0, b1]) = (at_ends(a), at_ends(b));
        a0.distance(b1) < SAME_NORMAL_ANGLE && a1.distance(b0) < SAME_NORMAL_ANGLE
    }
}

impl Plane {
    fn is_flat(&self) -> bool {
        self.flat != Vec3::ZERO
    }
}

impl Votes {
    fn is_flat(self) -> bool {
        self.flat >= LEAST_EDGES && self.flat as f64 > FLAT_SHARE * (self.flat + self.smooth) as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Mesh, NormalOptions, NormalsPolicy, NormalsReport, RawMesh, Topology};

    /// A closed prism over a regular polygon, whose walls have the normals that `wall` gives for
    /// the angles of the wall's middle and of the corner.
    fn prism(edges: u32, wall: impl Fn(f64, f64) -> f64) -> RawMesh {
        let angle = |k: f64| std::f64::consts::TAU * k / f64::from(edges);
        let around = |a: f64, z: f64| DVec3::new(a.cos(), a.sin(), z);
        let mut raw = RawMesh::default();
        let mut corners = Vec::new();
        let mut triangle = |places: [(f64, f64); 3], normals: [DVec3; 3]| {
            let first = raw.positions.len() as u32;
            for ((k, z), n) in places.into_iter().zip(normals) {
                let on_axis = k.is_nan();
                raw.positions.push(if on_axis {
                    DVec3::Z * z
                } else {
                    around(angle(k), z)
                });
                raw.normals.push(n);
            }
            corners.push([first, first + 1, first + 2]);
        };
        for k in 0..edges {
            // The last corner is the first.
            let (here, next) = (f64::from(k), f64::from((k + 1) % edges));
            let middle = f64::from(k) + 0.5;
            let at = |k: f64| around(wall(angle(middle), angle(k)), 0.0);
            let [a, b] = [here, f64::from(k + 1)].map(at);
            triangle([(here, 0.0), (next, 0.0), (next, 1.0)], [a, b, b]);
            triangle([(here, 0.0), (next, 1.0), (here, 1.0)], [a, b, a]);
            triangle([(f64::NAN, 1.0), (here, 1.0), (next, 1.0)], [DVec3::Z; 3]);
            triangle([(f64::NAN, 0.0), (next, 0.0), (here, 0.0)], [-DVec3::Z; 3]);
        }
        raw.normal_corners = Some(corners.clone());
        raw.corners = corners;
        raw
    }

    fn made(raw: RawMesh, policy: NormalsPolicy) -> (Mesh, NormalsReport) {
        let options = NormalOptions {
            policy,
            ..NormalOptions::default()
        };
        let (mesh, report) = raw.into_mesh(&options).unwrap();
        (mesh, report.normals)
    }

    fn hard(raw: RawMesh, normals: NormalsPolicy) -> (u64, u64) {
        let (mesh, report) = made(raw, normals);
        (Topology::new(&mesh).counts().hard, report.faceted)
    }

    fn flat(middle: f64, _: f64) -> f64 {
        middle
    }

    fn smooth(_: f64, corner: f64) -> f64 {
        corner
    }

    #[test]
    fn a_curved_wall_stored_flat_is_smoothed_and_its_rims_stay_hard() {
        // Edges that turn by 20 degrees; 18 of them, and two rims of as many.
        assert_eq!(hard(prism(18, flat), NormalsPolicy::Stored), (54, 0));
        assert_eq!(hard(prism(18, flat), NormalsPolicy::Auto), (36, 108));
        assert_eq!(hard(prism(18, flat), NormalsPolicy::Smooth), (36, 0));
        let (mesh, _) = made(prism(18, flat), NormalsPolicy::Auto);
        for (p, n) in mesh.positions().iter().zip(mesh.normals()) {
            let outward = if n.z.abs() > 0.5 {
                n.z * Vec3::Z
            } else {
                p.with_z(0.0)
            };
            assert!(n.distance(outward) < 1e-6, "{n} at {p}");
        }
    }

    #[test]
    fn sides_beyond_the_crease_angle_stay_hard() {
        assert_eq!(hard(prism(8, flat), NormalsPolicy::Auto), (24, 0));
    }

    #[test]
    fn a_single_bend_is_no_curved_wall() {
        let mut raw = prism(18, flat);
        // Two of the wall's edges, each two of the four triangles.
        raw.corners = [0, 1, 4, 5].map(|t| raw.corners[t]).to_vec();
        raw.normal_corners = Some(raw.corners.clone());
        assert_eq!(hard(raw, NormalsPolicy::Auto), (1, 0));
    }

    #[test]
    fn smooth_normals_are_kept() {
        assert_eq!(hard(prism(18, smooth), NormalsPolicy::Auto), (36, 0));
        let (stored, report) = made(prism(8, smooth), NormalsPolicy::Auto);
        assert_eq!((report.made, Topology::new(&stored).counts().hard), (0, 16));
    }

    #[test]
    fn a_file_that_tells_smooth_from_hard_is_believed() {
        // A third of the wall is smooth, the rest faceted.
        let half = |middle: f64, corner: f64| if middle < 2.0 { corner } else { middle };
        let (_, report) = made(prism(18, half), NormalsPolicy::Auto);
        assert_eq!((report.made, report.faceted), (0, 0));
    }

    #[test]
    fn walls_that_wind_against_their_normals_keep_their_front() {
        let mut raw = prism(18, flat);
        for corners in [&mut raw.corners, raw.normal_corners.as_mut().unwrap()] {
            corners.iter_mut().for_each(|t| t.reverse());
        }
        let (mesh, report) = made(raw, NormalsPolicy::Auto);
        assert_eq!(report.faceted, 108);
        for (p, n) in mesh.positions().iter().zip(mesh.normals()) {
            assert!(
                n.z.abs() > 0.5 || n.distance(p.with_z(0.0)) < 1e-6,
                "{n} at {p}"
            );
        }
    }

    #[test]
    fn bent_quads_with_one_normal_are_flat_too() {
        // A saddle of quads, each bent along its diagonal by a few degrees.
        let height = |x: u32, y: u32| 0.02 * f64::from(x * y);
        let mut raw = RawMesh::default();
        let mut corners = Vec::new();
        for (x, y) in (0..8).flat_map(|x| (0..8).map(move |y| (x, y))) {
            let at = |i: u32, j: u32| {
                DVec3::new(f64::from(x + i), f64::from(y + j), height(x + i, y + j))
            };
            let [a, b, c, d] = [at(0, 0), at(1, 0), at(1, 1), at(0, 1)];
            let first = raw.positions.len() as u32;
            raw.positions.extend([a, b, c, d]);
            raw.normals.extend([(c - a).cross(d - b).normalize(); 4]);
            corners.extend([[0, 1, 2], [0, 2, 3]].map(|t| t.map(|i| first + i)));
        }
        raw.normal_corners = Some(corners.clone());
        raw.corners = corners;
        let (mesh, report) = made(raw, NormalsPolicy::Auto);
        assert_eq!(report.faceted, 8 * 8 * 6);
        assert_eq!(Topology::new(&mesh).counts().hard, 0);
    }
}
