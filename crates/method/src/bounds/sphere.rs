//! The paper's bound of a patch: the sphere of greatest curvature (sections 4.4 and 4.8).
//!
//! It is the sphere (3) on the triangle's circumscribed circle: of all through the three vertices the
//! one with the least radius. With the three edge planes (5) it closes the region of interpolation,
//! in which the paper looks for the roots of (44). Two cases are not the paper's:
//!
//! - **Enlarged.** Where the vertex normals lean so far that the surface leaves the sphere, or that
//!   bounds cannot tell that it does not, the sphere grows about its centre until it holds the bound.
//! - **Limited.** The circle of a needle or of a very obtuse triangle is many times as large as the
//!   triangle, without end as the triangle loses its area. Where its centre would lie more than twice
//!   the longest edge's length beyond that edge, it is moved up to there, along the edge's
//!   perpendicular bisector; the circle through the edge's ends still holds the third vertex.
//!
//! A flat triangle has no sphere: its box is its vertices', and the crossing of its plane decides.

use super::heights::HeightNet;
use crate::numbers::{Interval, Scalar, Vector, vector};
use crate::patch::{Enlargement, Patch, Sphere, TriangleFrame, next};

/// How far beyond the longest edge a centre may lie, in lengths of that edge. At this limit the
/// triangle's greatest angle is 166 degrees, and the radius 2.06 lengths.
const MAX_CENTRE: f64 = 2.0;

impl<S: Scalar> Sphere<S> {
    /// The sphere on the circumscribed circle, or the limited one.
    #[inline]
    fn on_circle(frame: &TriangleFrame<S>) -> Self {
        let longest = frame.longest;
        let edge_vector = longest.pick_vector(frame.edge_vectors);
        let length2 = longest.pick(frame.lengths2);
        let length = length2.sqrt();
        let [a, b, c] = frame.edge_vectors;
        let corner = longest.pick_vector([a * S::from_f64(0.0), a, -c]);
        let half = S::from_f64(0.5);
        let middle = corner + edge_vector * half;
        let inward = frame.cross.cross(edge_vector) * (S::from_f64(1.0) / (frame.area2 * length));
        let height = frame.area2 / length;
        let foot = -longest.pick_vector([c, a, b]).dot(edge_vector) / length2;
        // How far the centre lies inward of the middle: as far from the opposite vertex as from the
        // edge's ends.
        let beside = length2 * foot * (S::from_f64(1.0) - foot);
        let offset = (height - beside / height) * half;
        let limit = length * S::from_f64(-MAX_CENTRE);
        let limited = !(limit <= offset);
        let offset = if limited { limit } else { offset };
        Self {
            centre: middle + inward * offset,
            radius: (offset * offset + length2 * S::from_f64(0.25)).sqrt(),
            enlargement: Enlargement::default(),
            limited,
        }
    }

    /// The same, enlarged until it holds the surface whose heights are these.
    pub(crate) fn around(frame: &TriangleFrame<S>, patch: &Patch<S>, net: &HeightNet<S>) -> Self {
        let sphere = Self::on_circle(frame);
        let furthest = sphere.furthest(patch, net);
        let ratio = furthest.to_f64() / sphere.radius.to_f64();
        sphere.enlarged(Enlargement::at_least(ratio))
    }

    /// The sphere again, from its packed [enlargement](Self::enlargement).
    #[inline]
    pub(crate) fn unpacked(frame: &TriangleFrame<S>, enlargement: Enlargement) -> Self {
        Self::on_circle(frame).enlarged(enlargement)
    }

    #[inline]
    fn enlarged(self, by: Enlargement) -> Self {
        Self {
            radius: self.radius * by.factor(),
            enlargement: by,
            ..self
        }
    }

    /// The distance from the centre that no surface point exceeds, but for the vertices'; huge where
    /// nothing is known of the heights.
    ///
    /// The surface lies in the hull of its Bernstein form's control points, each raised along any
    /// guide of the patch by any height of its range. The corners of that hull are the points raised by
    /// the ends of their ranges along the guides that lean the most.
    fn furthest(&self, patch: &Patch<S>, net: &HeightNet<S>) -> S {
        let guides = Self::guides(patch);
        let mut furthest2 = S::from_f64(0.0);
        let mut reach = |point: Vector<S>, heights: Interval<S>| {
            for height in [heights.lo, heights.hi] {
                for guide in guides {
                    let away = point + guide * height - self.centre;
                    let distance2 = away.dot(away);
                    let known = distance2.is_finite();
                    furthest2 = furthest2.greater(if known { distance2 } else { S::HUGE });
                }
            }
        };
        let zero = S::from_f64(0.0);
        let points = [vector(zero, zero, zero), patch.spokes[0], patch.spokes[1]];
        let third = S::from_f64(1.0 / 3.0);
        for k in 0..3 {
            let (p, q) = (points[k], points[next(k)]);
            reach((p + p + q) * third, net.edges[k][0]);
            reach((p + q + q) * third, net.edges[k][1]);
        }
        reach((points[1] + points[2]) * third, net.centre);
        furthest2.sqrt()
    }

    /// The guides between which all others of the patch lie: upright on the medians, and each edge's.
    fn guides(patch: &Patch<S>) -> [Vector<S>; 4] {
        let leaning = three!(|k| {
            let edge = &patch.edges[k];
            patch.normal + patch.gradients[next(next(k))] * (edge.height * edge.lean)
        });
        let [a, b, c] = leaning;
        [patch.normal, a, b, c]
    }

    /// The sphere's box, in the units and axes of the positions.
    pub(crate) fn bounds(&self, patch: &Patch<S>) -> [Vector<S>; 2] {
        let axis = |of: fn(Vector<S>) -> S| {
            let centre = of(self.centre);
            let inside = Interval {
                lo: centre - self.radius,
                hi: centre + self.radius,
            };
            patch.in_space(inside, of)
        };
        let (x, y, z) = (axis(|v| v.x), axis(|v| v.y), axis(|v| v.z));
        [vector(x.lo, y.lo, z.lo), vector(x.hi, y.hi, z.hi)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::intersect::{Ray, Solver};
    use crate::patch::{BoundsKind, PatchFlags, PatchKind, Surface};
    use crate::tests::{Random, V, rounded};

    fn flags(surface: Surface) -> PatchFlags {
        PatchFlags::new(surface).with_bounds(BoundsKind::Sphere)
    }

    const UP: [V; 3] = [vector(0.0, 0.0, 1.0); 3];

    /// A triangle in the plane z = 0 with upright normals, which is flat but still curved by the rule.
    fn over(corners: [[f64; 2]; 3]) -> Patch<f64> {
        let p = corners.map(|[x, y]| vector(x, y, 0.0));
        Patch::new(p, UP, flags(Surface::Angular))
    }

    #[track_caller]
    fn assert_box(patch: &Patch<f64>, lower: [f64; 3], upper: [f64; 3]) {
        let [lo, hi] = patch.bounds().map(Vector::to_array);
        for axis in 0..3 {
            for (is, should) in [(lo[axis], lower[axis]), (hi[axis], upper[axis])] {
                assert!((is - should).abs() < 1e-12, "{lo:?} {hi:?}");
            }
        }
    }

    #[test]
    fn it_stands_on_the_circumscribed_circle() {
        // Over a right angle the circle's centre is the middle of the longest edge.
        let right = over([[0.0, 0.0], [6.0, 0.0], [0.0, 8.0]]);
        assert_box(&right, [-2.0, -1.0, -5.0], [8.0, 9.0, 5.0]);
        let h = 3f64.sqrt();
        let equilateral = over([[1.0, h], [-1.0, h], [0.0, 0.0]]);
        let radius = 2.0 / h;
        assert_box(
            &equilateral,
            [-radius, 0.0, -radius],
            [radius, 2.0 * radius, radius],
        );
        for patch in [right, equilateral] {
            let sphere = patch.sphere().unwrap();
            assert!(!sphere.is_enlarged() && !sphere.is_limited());
        }
    }

    #[test]
    fn a_needle_has_a_limited_one_that_holds_it() {
        for height in [0.3, 0.1, 1e-3] {
            let patch = over([[-1.0, 0.0], [1.0, 0.0], [0.2, height]]);
            let sphere = patch.sphere().unwrap();
            assert_eq!(sphere.is_limited(), height < 0.2, "{height}");
            assert!(!sphere.is_enlarged());
            let [lo, hi] = patch.bounds();
            let radius = (hi.x - lo.x) * 0.5;
            assert!(radius < 2.07 * 2.0);
            let centre = (lo + hi) * 0.5;
            for (x, y) in [(-1.0, 0.0), (1.0, 0.0), (0.2, height)] {
                let away = (vector(x, y, 0.0) - centre).length();
                assert!(away < radius + 1e-12);
                assert!(sphere.is_limited() || away > radius - 1e-12);
            }
        }
    }

    #[test]
    fn the_paper_s_own_is_enough_for_a_ball_and_steep_normals_enlarge_it() {
        let patch = |tilt: f64| {
            let turn = |k: usize| f64::from(k as u32) * std::f64::consts::TAU / 3.0;
            let p = [0, 1, 2].map(|k| vector(turn(k).cos(), turn(k).sin(), 0.0));
            let n = p.map(|p| p * tilt.sin() + vector(0.0, 0.0, tilt.cos()));
            Patch::new(p, n, flags(Surface::Smooth))
        };
        // Up to 90 degrees it would be enough; the bounds know it of less.
        for degrees in [0.0f64, 10.0, 20.0, 35.0] {
            let patch = patch(degrees.to_radians());
            assert_eq!(patch.kind(), PatchKind::Curved);
            assert!(!patch.sphere().unwrap().is_enlarged(), "{degrees}");
        }
        // One that leans over an edge pushes the surface out there.
        let mut random = Random(5);
        let steep = (0..500).filter(|_| {
            let (p, n) = random.triangle(60.0, 0.0);
            let patch = Patch::new(p, n, flags(Surface::Angular));
            patch.sphere().is_some_and(Sphere::is_enlarged)
        });
        let steep = steep.count();
        assert!((20..400).contains(&steep), "{steep}");
    }

    #[test]
    fn enlargements_are_rounded_up_and_by_little() {
        assert_eq!(Enlargement::at_least(0.5), Enlargement::default());
        assert_eq!(Enlargement::default().factor::<f32>(), 1.0);
        for ratio in [1.0000001, 1.01, 1.0625, 1.7, 3.0, 100.0, 5e4] {
            let factor: f64 = Enlargement::at_least(ratio).factor();
            assert!(ratio < factor && factor < ratio * 1.14, "{ratio} {factor}");
        }
        let most: f64 = Enlargement(u8::MAX).factor();
        for ratio in [1e6, 1e300, f64::INFINITY, f64::NAN] {
            assert_eq!(Enlargement::at_least(ratio).factor::<f64>(), most);
        }
    }

    #[test]
    fn no_surface_point_leaves_it() {
        let mut random = Random(6);
        for surface in Surface::ALL {
            let (mut curved, mut enlarged, mut limited) = (0, 0, 0);
            for (tilt, flatness) in [(10.0, 0.3), (30.0, 0.7), (45.0, 1.0), (60.0, 1.0)] {
                for turn in 0..500 {
                    let (mut p, n) = random.triangle(tilt, flatness);
                    if turn % 5 == 0 {
                        // A needle in the same plane.
                        let along = (p[1] - p[0]) * random.unit();
                        p[2] = p[0] + along + (p[2] - p[0]) * 0.03;
                    }
                    let patch = Patch::new(p, n, flags(surface));
                    let Some(sphere) = patch.sphere() else {
                        continue;
                    };
                    curved += 1;
                    enlarged += usize::from(sphere.is_enlarged());
                    limited += usize::from(sphere.is_limited());
                    let [lo, hi] = patch.bounds();
                    let [zmin, zmax] = patch.heights();
                    for _ in 0..100 {
                        let [u, v] = random.inside();
                        let r = patch.point(u, v).position;
                        let away = (r - p[0]) * (1.0 / patch.size()) - sphere.centre;
                        assert!(
                            away.length() <= sphere.radius + 1e-14,
                            "{surface:?} {tilt} {p:?} {n:?}"
                        );
                        let inside = lo.x <= r.x && r.x <= hi.x && lo.y <= r.y && r.y <= hi.y;
                        assert!(inside && lo.z <= r.z && r.z <= hi.z);
                        let z = (r - p[0]).dot(patch.plane_normal());
                        assert!(zmin - 1e-15 <= z && z <= zmax + 1e-15);
                    }
                }
            }
            println!("{surface:?}: {enlarged} of {curved} enlarged, {limited} limited");
            assert!(curved > 1000 && enlarged > 20 && limited > 20);
        }
    }

    #[test]
    fn it_comes_back_from_the_record() {
        let mut random = Random(7);
        for n in 0..200 {
            let (p, normals) = random.triangle(50.0, 1.0);
            let (p, normals) = (rounded(p), rounded(normals));
            let flags = flags(Surface::ALL[n % 3]);
            let patch = Patch::new(p, normals, flags);
            let again = Patch::unpack(p, normals, &patch.pack(flags));
            let numbers = |patch: &Patch<f32>| patch.sphere().map(|s| (s.centre, s.radius));
            assert_eq!(numbers(&patch), numbers(&again));
            assert_eq!(patch.bounds(), again.bounds());
            assert_eq!(
                patch.sphere().is_none(),
                matches!(patch.kind(), PatchKind::Flat(_))
            );
        }
    }

    #[test]
    fn chords_are_the_exact_ones_and_a_guard_more() {
        let mut random = Random(8);
        let (mut met, mut passed) = (0, 0);
        for n in 0..3000 {
            let (p, normals) = random.triangle(20.0, 0.9);
            let patch = Patch::new(rounded(p), rounded(normals), flags(Surface::Tensor));
            let Some(sphere) = patch.sphere() else {
                continue;
            };
            let centre = sphere.centre.to_f64();
            let beside = random.direction() * (1.5 * sphere.radius.to_f64() * random.unit());
            // Directions whose squares are out of the range of singles, too.
            let length = [1.0, 1e-25, 1e25][n % 3];
            let direction = random.direction();
            let away = random.between(0.0, 30.0);
            let from = Vector::<f32>::from_f64(centre + beside - direction * away);
            let along = Vector::<f32>::from_f64(direction * length);
            let (enter, leave, meets) = sphere.chord(from, along, from.max_abs());
            // The same in doubles, without a guard.
            let (m, d) = (from.to_f64() - centre, along.to_f64() * (1.0 / length));
            let nearest = -m.dot(d) / d.dot(d);
            let q = m + d * nearest;
            let square = sphere.radius.to_f64().powi(2) - q.dot(q);
            if square < 0.0 {
                passed += usize::from(!meets);
                continue;
            }
            met += 1;
            assert!(meets, "{from:?} {along:?}");
            let half = square.sqrt();
            let (enter, leave) = (f64::from(enter) * length, f64::from(leave) * length);
            assert!(enter <= nearest - half && nearest + half <= leave);
            let guard = 4e-5 + 4e-6 * away;
            let most = guard * (2.0 + 4.0 * sphere.radius.to_f64() / half.max(guard.sqrt()));
            assert!(leave - enter <= 2.0 * half + most, "{half} {enter} {leave}");
        }
        assert!(met > 1000 && passed > 300, "{met} {passed}");
    }

    #[test]
    fn rays_find_the_same_roots_within_it_as_within_the_slab() {
        let mut random = Random(9);
        let mut hits = 0;
        for n in 0..300 {
            let (p, normals) = random.triangle(30.0, 0.5);
            let flags = PatchFlags::new(Surface::ALL[n % 3]);
            let tight = Patch::new(p, normals, flags);
            let round = Patch::new(p, normals, flags.with_bounds(BoundsKind::Sphere));
            for _ in 0..30 {
                let [u, v] = random.inside();
                let target = tight.point(u, v).position;
                let direction = random.direction();
                if direction.dot(tight.plane_normal()).abs() < 0.5 {
                    continue; // grazing rays may have several roots
                }
                let ray = Ray {
                    origin: target - direction * random.between(0.0, 5.0),
                    direction,
                    tnear: -1e-6,
                    tfar: f64::INFINITY,
                };
                for solver in [Solver::default(), Solver::Ita { bits: 24, step: 3 }] {
                    let [a, b] = [&tight, &round].map(|patch| patch.intersect(&ray, solver));
                    assert!(a.found && b.found, "{solver:?} {p:?} {normals:?} {ray:?}");
                    assert!((a.t - b.t).abs() < 1e-9, "{solver:?} {a:?} {b:?}");
                    hits += 1;
                }
            }
        }
        assert!(hits > 5000, "{hits}");
    }
}
