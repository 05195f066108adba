//! Cutting polygons into triangles.

use std::collections::HashSet;

use earcut::Earcut;
use glam::{DVec2, DVec3};

use super::crossing::crosses_itself;

/// Polygons of more corners than this are looked at before their ears are cut, which takes long
/// where it fails.
const MANY_CORNERS: usize = 128;

/// Polygons of more corners than this become fans: ears may take a time quadratic in the corners.
const MAX_CORNERS: usize = 1 << 15;

/// Cuts polygons of any number of corners, convex or not. Keeps its buffers.
pub(super) struct PolygonCutter {
    earcut: Earcut<f64>,
    flat: Vec<[f64; 2]>,
    cut: Vec<u32>,
    triangles: Vec<[u32; 3]>,
}

impl PolygonCutter {
    pub(super) fn new() -> PolygonCutter {
        PolygonCutter {
            earcut: Earcut::new(),
            flat: Vec::new(),
            cut: Vec::new(),
            triangles: Vec::new(),
        }
    }

    /// The triangles of a polygon, as numbers of its corners: always two fewer than corners, wound
    /// as the polygon is, and with each edge of the polygon as the edge of a triangle, so that
    /// polygons that share edges stay joined.
    ///
    /// Quads and larger convex polygons become a fan around their first corner, a concave quad
    /// the fan around its concave corner; others are cut by ears. A polygon that crosses itself so
    /// that ears do not cut it becomes a fan, and so does a concave one of more than 32,768 corners.
    ///
    /// # Panics
    ///
    /// For fewer than three corners.
    pub(super) fn cut(&mut self, corners: &[DVec3]) -> &[[u32; 3]] {
        assert!(corners.len() >= 3, "a polygon has three corners or more");
        self.triangles.clear();
        if corners.len() > 3 && !self.flatten(corners) {
            match corners.len() {
                4 => self.fan(self.concave_corner(), 4),
                n => self.cut_ears(n as u32),
            }
        } else {
            self.fan(0, corners.len() as u32);
        }
        &self.triangles
    }

    /// Projects the corners along the main axis of the polygon's normal, so that the polygon runs
    /// counter-clockwise; whether it is convex there.
    fn flatten(&mut self, corners: &[DVec3]) -> bool {
        let first = corners[0];
        let normal: DVec3 = corners
            .windows(2)
            .map(|w| (w[0] - first).cross(w[1] - first))
            .sum();
        let size = normal.abs();
        let (i, j, up) = if size.z >= size.x && size.z >= size.y {
            (0, 1, normal.z)
        } else if size.x >= size.y {
            (1, 2, normal.x)
        } else {
            (2, 0, normal.y)
        };
        let (i, j) = if up < 0.0 { (j, i) } else { (i, j) };
        self.flat.clear();
        self.flat.extend(corners.iter().map(|p| {
            let p = *p - first;
            [p[i], p[j]]
        }));
        self.is_convex()
    }

    /// Whether no corner turns right or back and the outline goes around only once.
    fn is_convex(&self) -> bool {
        let n = self.flat.len();
        // A closed outline that never turns right goes around once exactly if its x coordinate
        // changes direction no more than twice.
        let mut direction = 0.0;
        let mut reversals = 0;
        for k in 0..n {
            let [before, after] = self.edges_at(k);
            let turn = before.perp_dot(after);
            // A corner on a straight line may stay; one that repeats or turns back may hide a
            // turn to the right.
            if turn < 0.0 || turn == 0.0 && before.dot(after) <= 0.0 {
                return false;
            }
            let dx = self.flat[(k + 1) % n][0] - self.flat[k][0];
            if dx * direction < 0.0 {
                reversals += 1;
            }
            if dx != 0.0 {
                direction = dx.signum();
            }
        }
        reversals <= 2
    }

    /// The outline's edges before and after corner `k`.
    fn edges_at(&self, k: usize) -> [DVec2; 2] {
        let n = self.flat.len();
        let [a, b, c] = [k + n - 1, k, k + 1].map(|k| DVec2::from(self.flat[k % n]));
        [b - a, c - b]
    }

    /// The corner of a quad that turns right, or the first.
    fn concave_corner(&self) -> u32 {
        let turns_right = |&k: &usize| {
            let [before, after] = self.edges_at(k);
            before.perp_dot(after) < 0.0
        };
        (0..4).find(turns_right).unwrap_or(0) as u32
    }

    fn fan(&mut self, around: u32, n: u32) {
        let corner = |k: u32| (around + k) % n;
        self.triangles
            .extend((1..n - 1).map(|k| [corner(0), corner(k), corner(k + 1)]));
    }

    fn cut_ears(&mut self, n: u32) {
        let corners = self.flat.len();
        if corners > MAX_CORNERS || corners > MANY_CORNERS && crosses_itself(&self.flat) {
            self.fan(0, n);
            return;
        }
        self.earcut
            .earcut(self.flat.iter().copied(), &[], &mut self.cut);
        let (cut, _) = self.cut.as_chunks_mut::<3>();
        let backward = cut.iter().any(|t| edges(*t).any(|(a, b)| a == (b + 1) % n));
        if backward {
            cut.iter_mut().for_each(|t| t.reverse());
        }
        restore_corners(cut, n, &mut self.triangles);
        if !is_whole(&self.triangles, n) {
            self.triangles.clear();
            self.fan(0, n);
        }
    }
}

fn edges([a, b, c]: [u32; 3]) -> impl Iterator<Item = (u32, u32)> {
    [(a, b), (b, c), (c, a)].into_iter()
}

/// Puts back the corners that ear cutting left out because they lie on a straight line: where a
/// triangle's edge skips corners and no other triangle lies beyond it, the triangle becomes a fan
/// over them.
fn restore_corners(cut: &[[u32; 3]], n: u32, out: &mut Vec<[u32; 3]>) {
    let have: HashSet<(u32, u32)> = cut.iter().copied().flat_map(edges).collect();
    let mut left: Vec<[u32; 3]> = cut.iter().rev().copied().collect();
    while let Some(t) = left.pop() {
        let skipping = (0..3).find(|&k| {
            let (a, b) = (t[k], t[(k + 1) % 3]);
            // Edges of the fans made here are no keys of `have`: those along the outline skip
            // nothing, and those inside lie between two triangles of one fan.
            b != (a + 1) % n && have.contains(&(a, b)) && !have.contains(&(b, a))
        });
        let Some(k) = skipping else {
            out.push(t);
            continue;
        };
        let (a, b, apex) = (t[k], t[(k + 1) % 3], t[(k + 2) % 3]);
        let skipped = (b + n - a) % n;
        let fan = (0..skipped).map(|i| [(a + i) % n, (a + i + 1) % n, apex]);
        if out.len() + left.len() + skipped as usize > n as usize {
            // More triangles than a whole cut has: the outline crosses itself.
            return;
        }
        left.extend(fan.rev());
    }
}

/// Whether there are as many triangles as a polygon needs, and each of its edges is in one.
fn is_whole(triangles: &[[u32; 3]], n: u32) -> bool {
    let outline = triangles.iter().copied().flat_map(edges);
    let outline: HashSet<_> = outline.filter(|&(a, b)| b == (a + 1) % n).collect();
    triangles.len() + 2 == n as usize && outline.len() == n as usize
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Cuts a polygon in the plane, seen from above or below and from each axis, checks what
    /// every cut promises and returns the triangles.
    fn cut(corners: &[[f64; 2]]) -> Vec<[u32; 3]> {
        let n = corners.len() as u32;
        let mut cutter = PolygonCutter::new();
        let mut result = Vec::new();
        for axis in 0..3 {
            let points: Vec<DVec3> = corners
                .iter()
                .map(|&[x, y]| {
                    let mut p = [x, y, 0.3 * x + 5.0];
                    p.rotate_right(axis);
                    DVec3::from(p)
                })
                .collect();
            result = cutter.cut(&points).to_vec();
            assert!(is_whole(&result, n), "{result:?}");
        }
        result
    }

    fn doubled_areas(corners: &[[f64; 2]], triangles: &[[u32; 3]]) -> Vec<f64> {
        let corner = |i: u32| DVec2::from(corners[i as usize]);
        triangles
            .iter()
            .map(|&[a, b, c]| (corner(b) - corner(a)).perp_dot(corner(c) - corner(a)))
            .collect()
    }

    fn check_area(corners: &[[f64; 2]], doubled: f64) {
        for turned in 0..corners.len() {
            let mut corners = corners.to_vec();
            corners.rotate_left(turned);
            let areas = doubled_areas(&corners, &cut(&corners));
            assert!(areas.iter().all(|&a| a >= 0.0), "{areas:?}");
            assert!((areas.iter().sum::<f64>() - doubled).abs() < 1e-9);
            corners.reverse();
            let areas = doubled_areas(&corners, &cut(&corners));
            assert!(areas.iter().all(|&a| a <= 0.0), "{areas:?}");
            assert!((areas.iter().sum::<f64>() + doubled).abs() < 1e-9);
        }
    }

    #[test]
    fn convex_polygons_become_fans_around_the_first_corner() {
        let square = [[0., 0.], [1., 0.], [1., 1.], [0., 1.]];
        assert_eq!(cut(&square), [[0, 1, 2], [0, 2, 3]]);
        let pentagon = [[0., 0.], [2., 0.], [3., 1.], [2., 2.], [0., 2.]];
        assert_eq!(cut(&pentagon), [[0, 1, 2], [0, 2, 3], [0, 3, 4]]);
    }

    #[test]
    fn a_concave_quad_is_cut_at_its_concave_corner() {
        let dart = [[0., 0.], [2., 1.], [0., 2.], [0.5, 1.]];
        assert_eq!(cut(&dart), [[3, 0, 1], [3, 1, 2]]);
        check_area(&dart, 3.0);
    }

    #[test]
    fn concave_polygons_are_cut_inside_only() {
        let l_shape = [[0., 0.], [2., 0.], [2., 1.], [1., 1.], [1., 2.], [0., 2.]];
        check_area(&l_shape, 6.0);
        let comb: Vec<[f64; 2]> = (0..20)
            .map(|i| [f64::from(i), if i % 2 == 0 { 3.0 } else { 0.5 }])
            .chain([[19.0, -1.0], [0.0, -1.0]])
            .collect();
        let area =
            |i: usize| comb[i][0] * comb[(i + 1) % 22][1] - comb[(i + 1) % 22][0] * comb[i][1];
        let doubled: f64 = (0..22).map(area).sum();
        let backward: Vec<_> = comb.iter().rev().copied().collect();
        check_area(&backward, -doubled);
    }

    #[test]
    fn corners_on_a_straight_side_stay_corners() {
        let l_shape = [
            [0., 0.],
            [1., 0.],
            [2., 0.],
            [2., 0.5],
            [2., 1.],
            [1., 1.],
            [1., 1.25],
            [1., 1.5],
            [1., 2.],
            [0., 2.],
            [0., 1.],
        ];
        check_area(&l_shape, 6.0);
    }

    #[test]
    fn repeated_corners_stay_corners() {
        let l_shape = [
            [0., 0.],
            [2., 0.],
            [2., 0.],
            [2., 1.],
            [1., 1.],
            [1., 1.],
            [1., 1.],
            [1., 2.],
            [0., 2.],
        ];
        check_area(&l_shape, 6.0);
    }

    #[test]
    fn polygons_that_cross_themselves_or_have_no_area_keep_their_edges() {
        let star: Vec<[f64; 2]> = (0..5)
            .map(|i| {
                (f64::from(i) * 2.0 * 0.4 * std::f64::consts::PI)
                    .sin_cos()
                    .into()
            })
            .collect();
        assert_eq!(cut(&star).len(), 3);
        let line: Vec<[f64; 2]> = (0..7).map(|i| [f64::from(i * i % 5), 0.0]).collect();
        assert_eq!(cut(&line).len(), 5);
        assert_eq!(cut(&[[1.0, 1.0]; 936]).len(), 934);
    }

    #[test]
    fn large_polygons_that_cross_themselves_take_no_time() {
        // By ears this one takes minutes.
        let star: Vec<[f64; 2]> = (0..30_001)
            .map(|i| (2.4 * f64::from(i)).sin_cos().into())
            .collect();
        assert_eq!(cut(&star).len(), 29_999);
    }
}
