//! Makes a cluster of neighbouring triangles, all of them at once in SIMD lanes.

use std::array;

use fearless_simd::{Level, dispatch, f32x8, prelude::*};
use glam::Vec3;

use super::layout::{CUT, CUT_HALF, Cluster, DIGITS, DIRECTIONS, NONE, RoundedUp, SIZE};
use crate::embree::Bounds;
use curvetri_method::{
    DirectionalBounds, PackedTriangle, PatchMask, Patches, Real, Vector, in_columns, inlined,
    vector,
};

/// Most steps along each direction from the middle of a cluster to the furthest end of its triangles' boxes.
/// Rounded to whole numbers, what is counted in steps fits a byte then: middles and half widths along the
/// first three directions, and along the last the way from any end to beyond the cluster.
const STEPS: [f32; DIRECTIONS] = [126.0, 126.0, 126.0, 63.0];
/// Boxes do not lie across two edges whose angle has a greater cosine than this.
const MOST_COSINE: f32 = 0.9;
/// How far off its bounds a surface may come out, relative to the cluster's extents.
const ROUNDING: f32 = 64.0 * f32::EPSILON;

/// A cluster of up to [`SIZE`] triangles, at least one. `boxes` are those of the whole mesh, along the axes
/// of space.
pub(super) fn build<'a>(
    triangles: &[u32],
    boxes: &[Bounds],
    packed_triangle: impl Fn(u32) -> PackedTriangle<'a>,
) -> Cluster {
    // Something sound in the lanes without a triangle: the first one again.
    let at = |n: usize| triangles[if n < triangles.len() { n } else { 0 }];
    let boxes: [Bounds; SIZE] = array::from_fn(|n| boxes[at(n) as usize]);
    let patches: [PackedTriangle<'a>; SIZE] = array::from_fn(|n| packed_triangle(at(n)));
    dispatch!(Level::new(), simd => simd.vectorize(
        #[inline(always)]
        || build_in_lanes(simd, triangles, &boxes, &patches)
    ))
}

#[inline(always)]
fn build_in_lanes<S: Simd>(
    simd: S,
    triangles: &[u32],
    boxes: &[Bounds; SIZE],
    patches: &[PackedTriangle<'_>; SIZE],
) -> Cluster {
    let count = triangles.len();
    let shapes = Shapes::new(simd, boxes, patches);
    let mut cluster = empty(&boxes[..count]);
    for (axis, direction) in shapes.directions(count).into_iter().enumerate() {
        for (to, component) in cluster.directions.iter_mut().zip(direction.to_array()) {
            to[axis] = (component * (DIGITS - 1.0)).round() as i8;
        }
    }
    for (axis, steps) in STEPS.into_iter().enumerate() {
        let ranges = ranges(&cluster, axis, &shapes);
        let furthest = ranges[0].abs().greater(ranges[1].abs());
        let step = least_step(greatest(furthest), steps);
        cluster.step[axis] = step;
        let step = shapes.lower.x.constant(step.get().into());
        if axis == CUT {
            let direction = shapes.everywhere(cluster.direction(axis));
            let below = shapes.reach.has_edge_below(direction);
            cluster.middles[axis] = cut_off(ranges, below, step).map(|steps| steps as i8);
        } else {
            let [middles, halves] = in_steps(ranges, step);
            cluster.middles[axis] = middles.map(|steps| steps as i8);
            cluster.halves[axis] = halves.map(|steps| steps as u8);
        }
    }
    cluster.triangles[..count].copy_from_slice(triangles);
    cluster
}

/// A cluster with the common box of all, and nothing else yet.
#[inline(always)]
fn empty(boxes: &[Bounds]) -> Cluster {
    let all = boxes.iter().copied().fold(Bounds::EMPTY, Bounds::union);
    let middle = all.lower * 0.5 + all.upper * 0.5;
    let half = (all.upper - middle).max(middle - all.lower);
    Cluster {
        middle: middle.to_array(),
        // The next number, as differences are rounded.
        half: half.to_array().map(|half| RoundedUp::new(half.next_up())),
        step: [RoundedUp::default(); DIRECTIONS],
        directions: [[0; DIRECTIONS]; 3],
        middles: [[0; SIZE]; DIRECTIONS],
        halves: [[0; SIZE]; CUT],
        triangles: [NONE; SIZE],
    }
}

/// The least and the greatest value of each triangle along a direction, from the cluster's middle.
#[inline(always)]
fn ranges<S: Simd>(cluster: &Cluster, axis: usize, shapes: &Shapes<S>) -> [Patches<S>; 2] {
    let like = shapes.lower.x;
    let direction = shapes.everywhere(cluster.direction(axis));
    let middle = shapes.everywhere(cluster.middle());
    let (lower, upper) = (shapes.lower - middle, shapes.upper - middle);
    let x = [direction.x * lower.x, direction.x * upper.x];
    let y = [direction.y * lower.y, direction.y * upper.y];
    let z = [direction.z * lower.z, direction.z * upper.z];
    let least = x[0].lesser(x[1]) + y[0].lesser(y[1]) + z[0].lesser(z[1]);
    let most = x[0].greater(x[1]) + y[0].greater(y[1]) + z[0].greater(z[1]);
    // Both the box and the reach hold the surface, so the narrower of the two does.
    let [from, to] = shapes.reach.along(direction, middle);
    let tolerance = like.constant((cluster.extent() * ROUNDING).into());
    [from.greater(least) - tolerance, to.lesser(most) + tolerance]
}

/// The triangles of a cluster, one a lane.
struct Shapes<S: Simd> {
    reach: DirectionalBounds<Patches<S>>,
    /// The corners of their boxes along the axes of space.
    lower: Vector<Patches<S>>,
    upper: Vector<Patches<S>>,
}

impl<S: Simd> Shapes<S> {
    #[inline(always)]
    fn new(simd: S, boxes: &[Bounds; SIZE], patches: &[PackedTriangle<'_>; SIZE]) -> Self {
        let corners = inlined(
            #[inline(always)]
            |corner: fn(&Bounds) -> Vec3| {
                let columns = in_columns(
                    #[inline(always)]
                    |n| corner(&boxes[n]).to_array(),
                );
                let number = inlined(
                    #[inline(always)]
                    |axis: usize| Patches(f32x8::from_slice(simd, &columns[axis])),
                );
                vector(number(0), number(1), number(2))
            },
        );
        Self {
            reach: DirectionalBounds::of_patches(simd, |n| patches[n]),
            lower: corners(|bounds| bounds.lower),
            upper: corners(|bounds| bounds.upper),
        }
    }

    /// The same vector for every triangle.
    #[inline(always)]
    fn everywhere(&self, of: Vec3) -> Vector<Patches<S>> {
        let like = self.lower.x;
        let [x, y, z] = of.to_array().map(f64::from);
        vector(like.constant(x), like.constant(y), like.constant(z))
    }

    /// The directions of boxes, of unit length: across the first triangle's two shortest edges, along the mean
    /// of the first `count` normals, and across the longest edge.
    #[inline(always)]
    fn directions(&self, count: usize) -> [Vec3; DIRECTIONS] {
        let Vector { x, y, z } = self.reach.normal();
        let sum = |of: Patches<S>| of.numbers()[..count].iter().sum::<f32>();
        let up = Vec3::new(sum(x), sum(y), sum(z)).normalize_or(Vec3::Z);
        let mut edges = self.reach.edges().map(|Vector { x, y, z }| {
            let edge = Vec3::new(x.numbers()[0], y.numbers()[0], z.numbers()[0]);
            (edge.abs().max_element(), edge)
        });
        edges.sort_by(|a, b| a.0.total_cmp(&b.0));
        let any = up.any_orthonormal_vector();
        // Scaled first: its square may be too small a number.
        let [a, b, c] = edges.map(|(size, edge)| {
            up.cross(edge / size.max(f32::MIN_POSITIVE))
                .normalize_or(any)
        });
        // Two edges that are nearly parallel leave open how far a triangle reaches along them.
        let b = if a.dot(b).abs() < MOST_COSINE {
            b
        } else {
            up.cross(a)
        };
        [a, b, up, c]
    }
}

/// The greatest of numbers of 0 or more; in pairs, so that few wait for each other.
#[inline(always)]
fn greatest<S: Simd>(of: Patches<S>) -> f32 {
    let [a, b, c, d, e, f, g, h] = of.numbers();
    (a.max(b).max(c.max(d))).max(e.max(f).max(g.max(h)))
}

/// The least step such that so many of them reach this far, whatever the rounding.
fn least_step(furthest: f32, steps: f32) -> RoundedUp {
    let mut step = RoundedUp::new((furthest / steps).max(f32::MIN_POSITIVE));
    while step.get() * steps < furthest {
        step.0 += 1;
    }
    step
}

/// The middles of ranges in steps, and half their widths in half steps, both whole numbers. The ranges include
/// a tolerance for the rounding.
#[inline(always)]
fn in_steps<S: Simd>([from, to]: [Patches<S>; 2], step: Patches<S>) -> [[f32; SIZE]; 2] {
    let half = step.constant(0.5);
    let per_step = step.constant(1.0) / step;
    let middle = Patches(((from * half + to * half) * per_step + half).0.floor());
    let reach = (to - middle * step).greater(middle * step - from);
    let steps = Patches((reach * (per_step + per_step)).0.ceil());
    [middle.numbers(), steps.numbers()]
}

/// The middles, in steps, of ranges with one end only: the triangles in `below` keep their lower end and reach
/// beyond the cluster above it, the others keep their upper end and reach beyond the cluster below it.
#[inline(always)]
fn cut_off<S: Simd>(
    [from, to]: [Patches<S>; 2],
    below: PatchMask<S>,
    step: Patches<S>,
) -> [f32; SIZE] {
    let half = step.constant(0.5 * f64::from(CUT_HALF));
    // A range below the middle is one above turned round.
    let end = Patches::select(below, from, -to);
    let steps = Patches((end / step + half).0.floor());
    Patches::select(below, steps, -steps).numbers()
}

#[cfg(test)]
mod tests {
    use glam::vec3;
    use rand::{SeedableRng, rngs::SmallRng};

    use super::super::test_triangles::TestTriangles;
    use super::*;

    /// How many points of each triangle are looked at.
    const POINTS: usize = 20;

    #[test]
    fn a_surface_is_in_its_box() {
        let mut random = SmallRng::seed_from_u64(3);
        let (mut points, mut volume) = (0, 0.0);
        for (size, lower) in [
            (2.0, Vec3::ZERO),
            (1e-6, Vec3::splat(-3e-6)),
            (1e12, Vec3::ZERO),
            (1.0, Vec3::splat(1e4)),
        ] {
            let triangles = TestTriangles::new(5, 400, size, lower);
            for cluster in &triangles.clusters() {
                for n in crate::curved::bits::set_bits(cluster.present()) {
                    check_box(cluster, n, &triangles, &mut random);
                    points += POINTS;
                    let width = |axis: usize| {
                        let half = cluster.ranges_in_steps(axis)[1][n];
                        f64::from(half * cluster.step()[axis] / size)
                    };
                    volume += width(0) * width(1) * width(2);
                }
            }
        }
        println!("{points} points, {volume} of the cubes is in boxes");
        assert!(points > 30_000 && volume < 2.0, "{points} {volume}");
    }

    /// Points of the triangle at a place of a cluster are in the cluster's box and in its own.
    fn check_box(cluster: &Cluster, n: usize, triangles: &TestTriangles, random: &mut SmallRng) {
        let bounds = cluster.bounds();
        // But for rounding, which tests of rays make up for.
        let tolerance = 1e-5 * (cluster.extent() + bounds.upper.abs().max_element() * 0.01);
        for _ in 0..POINTS {
            let point = triangles.point(cluster.triangle(n), random);
            assert!(bounds.lower.cmple(point + tolerance).all(), "{point}");
            assert!(bounds.upper.cmpge(point - tolerance).all(), "{point}");
            for axis in 0..DIRECTIONS {
                let [middle, half] = cluster.ranges_in_steps(axis);
                let at = cluster.direction(axis).dot(point - cluster.middle());
                let step = cluster.step()[axis];
                let off = (at - middle[n] * step).abs();
                assert!(off <= 0.5 * half[n] * step + tolerance, "{axis} {point}");
            }
        }
    }

    #[test]
    fn neighbours_in_a_plane_have_thin_boxes() {
        let up = vec3(0.48, 0.6, 0.64);
        let (along, across) = (vec3(0.8, 0.0, -0.6), up.cross(vec3(0.8, 0.0, -0.6)));
        let corner =
            |triangle: usize| along * (triangle / 2) as f32 + across * (triangle % 2) as f32;
        let triangles = (0..SIZE).map(|triangle| {
            let at = corner(triangle);
            ([at, at + along, at + across], [up; 3])
        });
        let cluster = &TestTriangles::of(triangles).clusters()[0];
        for n in 0..SIZE {
            let [a, b, height] =
                [0, 1, 2].map(|axis| cluster.ranges_in_steps(axis)[1][n] * cluster.step()[axis]);
            // no larger than the digits of directions and steps make them
            assert!(a < 1.1 && b < 1.1 && height < 0.03, "{a} {b} {height}");
            // What the triangle leaves of a rectangle is cut off.
            let at = corner(cluster.triangle(n) as usize);
            let is_in = |u: f32, v: f32| {
                let from_middle = at + along * u + across * v - cluster.middle();
                let [middle, half] = cluster.ranges_in_steps(CUT);
                let steps = cluster.direction(CUT).dot(from_middle) / cluster.step()[CUT];
                (steps - middle[n]).abs() <= 0.5 * half[n]
            };
            assert!(is_in(0.5, 0.5) && is_in(0.0, 0.0) && !is_in(0.55, 0.55));
        }
    }
}
