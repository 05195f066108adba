//! Neighbouring triangles as one Embree primitive: a tree a level or three lower, fewer callbacks, and
//! the boxes of all its triangles in two cache lines.
//!
//! The boxes are the cluster's own: along the sum of its triangles' normals, where neighbours are thin, and
//! across two sides of one of them. Boxes along the axes of space let half as many more rays through. A box is
//! what lies between two values along each of three directions, which need not be perpendicular. Along a
//! fourth, across the longest side, one of the ends cuts off the half of the box that the triangle leaves
//! empty; the other, where there is but a corner, would cut off next to nothing.

use fearless_simd::{Level, dispatch, f32x8, prelude::*};
use glam::Vec3;

use crate::embree::Bounds;
use crate::method::{
    DirectionalBounds, PATCHES, PackedTriangle, PatchMask, Patches, Real, Vector, in_columns,
    inlined, vector,
};

/// Most triangles of a cluster.
pub(super) const SIZE: usize = 8;
/// In place of a triangle's number where a cluster has fewer.
pub(super) const NONE: u32 = u32::MAX;
/// Steps from the middle of a cluster to the furthest end of its triangles' boxes along each direction, at the
/// most: what is rounded to whole ones still fits a byte then, along the last from any end to beyond the cluster.
const STEPS: [f32; DIRECTIONS] = [126.0, 126.0, 126.0, 63.0];
/// A direction's components are kept in units of one over this.
const DIGITS: f32 = 128.0;
/// The cosine of the angle between two sides, above which boxes do not lie across both.
const MOST_COSINE: f32 = 0.9;
/// How far off its bounds a surface may come out, in units of epsilon of the cluster's extents.
const ROUNDING: f32 = 64.0 * f32::EPSILON;

/// Directions along which boxes have ends.
pub(super) const DIRECTIONS: usize = 4;
/// The one along which boxes have but one: the other is beyond the cluster.
const CUT: usize = DIRECTIONS - 1;
/// Half of what a box takes up there, in half steps.
const CUT_HALF: u8 = 127;

/// Some neighbouring triangles and their boxes.
#[derive(Clone, Debug)]
#[repr(C, align(64))]
pub(super) struct Cluster {
    /// Of the common box, along the axes of space.
    middle: [f32; 3],
    /// Half the extents of the common box.
    half: [Above; 3],
    /// A step along each direction.
    step: [Above; DIRECTIONS],
    /// The first components of the directions, their second and their third ones.
    directions: [[i8; DIRECTIONS]; 3],
    /// The boxes' middles along each direction, in steps from the middle.
    middles: [[i8; SIZE]; DIRECTIONS],
    /// Half of what they take up along each but the last, in half steps; along that, all take up as much.
    halves: [[u8; SIZE]; CUT],
    pub triangles: [u32; SIZE],
}

const _: () = assert!(size_of::<Cluster>() == 128 && SIZE == PATCHES);

/// A number from zero in half the bits, rounded up.
#[derive(Clone, Copy, Debug, Default)]
struct Above(u16);

impl Above {
    fn new(number: f32) -> Self {
        let bits = number.to_bits();
        // Beyond the greatest number it is infinite, as it should be.
        Self(bits.div_ceil(1 << 16) as u16)
    }

    #[inline(always)]
    fn get(self) -> f32 {
        f32::from_bits(u32::from(self.0) << 16)
    }
}

/// A triangle of a cluster.
#[derive(Clone, Copy)]
pub(super) struct Member<'a> {
    pub triangle: u32,
    /// Its box along the axes of space.
    pub bounds: Bounds,
    pub kept: PackedTriangle<'a>,
}

/// The triangles of a cluster, one a lane.
struct Shapes<S: Simd> {
    reach: DirectionalBounds<Patches<S>>,
    /// The corners of their boxes along the axes of space.
    lower: Vector<Patches<S>>,
    upper: Vector<Patches<S>>,
}

impl Cluster {
    /// A cluster of up to [`SIZE`] triangles, at least one.
    pub fn new(members: &[Member<'_>]) -> Self {
        dispatch!(Level::new(), simd => simd.vectorize(
            #[inline(always)]
            || Self::of(simd, members)
        ))
    }

    #[inline(always)]
    fn of<S: Simd>(simd: S, members: &[Member<'_>]) -> Self {
        let shapes = Shapes::new(simd, members);
        let boxes = members.iter().map(|member| member.bounds);
        let all = boxes.fold(Bounds::EMPTY, Bounds::union);
        let middle = all.lower * 0.5 + all.upper * 0.5;
        let half = (all.upper - middle).max(middle - all.lower);
        let mut cluster = Self {
            middle: middle.to_array(),
            // The next number, as differences are rounded.
            half: half.to_array().map(|half| Above::new(half.next_up())),
            step: [Above::default(); DIRECTIONS],
            directions: [[0; DIRECTIONS]; 3],
            middles: [[0; SIZE]; DIRECTIONS],
            halves: [[0; SIZE]; CUT],
            triangles: [NONE; SIZE],
        };
        for (axis, direction) in shapes.directions(members.len()).into_iter().enumerate() {
            for (to, component) in cluster.directions.iter_mut().zip(direction.to_array()) {
                to[axis] = (component * (DIGITS - 1.0)).round() as i8;
            }
        }
        for (axis, steps) in STEPS.into_iter().enumerate() {
            let ranges = cluster.ranges(axis, &shapes);
            let furthest = ranges[0].abs().greater(ranges[1].abs());
            let kept = step(greatest(furthest), steps);
            cluster.step[axis] = kept;
            let step = shapes.lower.x.constant(kept.get().into());
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
        for (place, member) in cluster.triangles.iter_mut().zip(members) {
            *place = member.triangle;
        }
        cluster
    }

    /// What each triangle takes up along a direction, from the middle.
    #[inline(always)]
    fn ranges<S: Simd>(&self, axis: usize, shapes: &Shapes<S>) -> [Patches<S>; 2] {
        let like = shapes.lower.x;
        let direction = shapes.everywhere(self.direction(axis));
        let middle = shapes.everywhere(self.middle());
        let (lower, upper) = (shapes.lower - middle, shapes.upper - middle);
        let x = [direction.x * lower.x, direction.x * upper.x];
        let y = [direction.y * lower.y, direction.y * upper.y];
        let z = [direction.z * lower.z, direction.z * upper.z];
        let least = x[0].lesser(x[1]) + y[0].lesser(y[1]) + z[0].lesser(z[1]);
        let most = x[0].greater(x[1]) + y[0].greater(y[1]) + z[0].greater(z[1]);
        // Both are right.
        let [from, to] = shapes.reach.along(direction, middle);
        let room = like.constant((self.extent() * ROUNDING).into());
        [from.greater(least) - room, to.lesser(most) + room]
    }

    /// The common box's middle, from which steps are counted.
    #[inline(always)]
    pub fn middle(&self) -> Vec3 {
        self.middle.into()
    }

    /// Half the common box's extents.
    #[inline(always)]
    fn half(&self) -> Vec3 {
        let [x, y, z] = self.half;
        Vec3::new(x.get(), y.get(), z.get())
    }

    /// How far, along any direction, it is from the middle to where a triangle may be at the most.
    #[inline(always)]
    pub fn extent(&self) -> f32 {
        self.half().element_sum()
    }

    /// One of the directions, in size about one.
    #[inline(always)]
    pub fn direction(&self, axis: usize) -> Vec3 {
        let [x, y, z] = self.directions.map(|component| f32::from(component[axis]));
        Vec3::new(x, y, z) * (1.0 / DIGITS)
    }

    /// A component of all directions.
    #[inline(always)]
    pub fn components(&self, component: usize) -> [f32; DIRECTIONS] {
        self.directions[component].map(|digits| f32::from(digits) * (1.0 / DIGITS))
    }

    /// A step along each of the directions.
    #[inline(always)]
    pub fn step(&self) -> [f32; DIRECTIONS] {
        let [a, b, c, d] = self.step;
        [a.get(), b.get(), c.get(), d.get()]
    }

    /// The boxes' middles along a direction, in steps from the cluster's, and half of what they take up, in half
    /// steps.
    #[inline(always)]
    pub fn ranges_in_steps(&self, axis: usize) -> [[f32; SIZE]; 2] {
        let halves = self.halves.get(axis).unwrap_or(&[CUT_HALF; SIZE]);
        let [mut middle, mut half] = [[0.0; SIZE]; 2];
        for n in 0..SIZE {
            (middle[n], half[n]) = (self.middles[axis][n].into(), halves[n].into());
        }
        [middle, half]
    }

    /// The box of all its triangles.
    pub fn bounds(&self) -> Bounds {
        let (middle, half) = (self.middle(), self.half());
        let (lower, upper) = (middle - half, middle + half);
        Bounds {
            // The next numbers, as the ends are rounded.
            lower: lower.to_array().map(f32::next_down).into(),
            upper: upper.to_array().map(f32::next_up).into(),
        }
    }

    /// The number of triangle `n`.
    pub fn triangle(&self, n: usize) -> u32 {
        self.triangles[n]
    }

    /// The places that hold a triangle, one bit each.
    pub fn present(&self) -> u32 {
        let missing = self.triangles.iter().filter(|&&triangle| triangle == NONE);
        ALL >> missing.count()
    }
}

/// All places of a cluster, one bit each.
const ALL: u32 = u32::MAX >> (u32::BITS as usize - SIZE);

impl<S: Simd> Shapes<S> {
    #[inline(always)]
    fn new(simd: S, members: &[Member<'_>]) -> Self {
        // Something sound in the lanes without a triangle.
        let member = |n: usize| &members[if n < members.len() { n } else { 0 }];
        let corners = inlined(
            #[inline(always)]
            |corner: fn(&Bounds) -> Vec3| {
                let columns = in_columns(
                    #[inline(always)]
                    |n| corner(&member(n).bounds).to_array(),
                );
                let number = inlined(
                    #[inline(always)]
                    |axis: usize| Patches(f32x8::from_slice(simd, &columns[axis])),
                );
                vector(number(0), number(1), number(2))
            },
        );
        Self {
            reach: DirectionalBounds::of_patches(simd, |n| member(n).kept),
            lower: corners(|bounds| bounds.lower),
            upper: corners(|bounds| bounds.upper),
        }
    }

    /// The same for every triangle.
    #[inline(always)]
    fn everywhere(&self, of: Vec3) -> Vector<Patches<S>> {
        let like = self.lower.x;
        let [x, y, z] = of.to_array().map(f64::from);
        vector(like.constant(x), like.constant(y), like.constant(z))
    }

    /// Across the first triangle's shortest sides, along the mean of the first so many normals, and across the
    /// longest side: of unit length.
    #[inline(always)]
    fn directions(&self, count: usize) -> [Vec3; DIRECTIONS] {
        let Vector { x, y, z } = self.reach.normal();
        let sum = |of: Patches<S>| of.numbers()[..count].iter().sum::<f32>();
        let up = Vec3::new(sum(x), sum(y), sum(z)).normalize_or(Vec3::Z);
        let mut sides = self.reach.edges().map(|Vector { x, y, z }| {
            let side = Vec3::new(x.numbers()[0], y.numbers()[0], z.numbers()[0]);
            (side.abs().max_element(), side)
        });
        sides.sort_by(|a, b| a.0.total_cmp(&b.0));
        let any = up.any_orthonormal_vector();
        // Scaled first: its square may be too small a number.
        let [a, b, c] = sides.map(|(size, side)| {
            up.cross(side / size.max(f32::MIN_POSITIVE))
                .normalize_or(any)
        });
        // Sides that run side by side leave open how far a triangle reaches along them.
        let b = if a.dot(b).abs() < MOST_COSINE {
            b
        } else {
            up.cross(a)
        };
        [a, b, up, c]
    }
}

/// The greatest of numbers from zero; in pairs, so that few wait for each other.
#[inline(always)]
fn greatest<S: Simd>(of: Patches<S>) -> f32 {
    let [a, b, c, d, e, f, g, h] = of.numbers();
    (a.max(b).max(c.max(d))).max(e.max(f).max(g.max(h)))
}

/// The least step such that so many of them lead this far, whatever the rounding.
fn step(furthest: f32, steps: f32) -> Above {
    let mut step = Above::new((furthest / steps).max(f32::MIN_POSITIVE));
    while step.get() * steps < furthest {
        step.0 += 1;
    }
    step
}

/// The middles of ranges in steps and half of what they take up in half steps, both whole numbers. Ranges have
/// room for the rounding.
#[inline(always)]
fn in_steps<S: Simd>([from, to]: [Patches<S>; 2], step: Patches<S>) -> [[f32; SIZE]; 2] {
    let half = step.constant(0.5);
    let per_step = step.constant(1.0) / step;
    let middle = Patches(((from * half + to * half) * per_step + half).0.floor());
    let reach = (to - middle * step).greater(middle * step - from);
    let steps = Patches((reach * (per_step + per_step)).0.ceil());
    [middle.numbers(), steps.numbers()]
}

/// The middles, in steps, of the ranges from the lower ends of those in `below` to anywhere beyond the cluster,
/// and from there to the upper ends of the others.
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
pub(super) mod tests {
    use super::super::clusters::group;
    use super::*;
    use crate::method::{BuiltPatch, PackedPatch, PackedTriangle, PatchFlags, TriangleVertices};
    use glam::vec3;
    use rand::{Rng, SeedableRng, rngs::SmallRng};

    /// Curved triangles here and there.
    pub struct Triangles(Vec<(TriangleVertices, BuiltPatch)>);

    impl Triangles {
        /// Some in a cube of this size, each a tenth as large.
        pub fn new(seed: u64, count: usize, size: f32, lower: Vec3) -> Self {
            let mut random = SmallRng::seed_from_u64(seed);
            let mut point = || vec3(random.random(), random.random(), random.random());
            let mut triangle = || {
                let first = lower + point() * size;
                let corners = [
                    first,
                    first + point() * 0.1 * size,
                    first + point() * 0.1 * size,
                ];
                let upright = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
                let upright = upright.normalize_or(Vec3::X);
                let normals = [(); 3].map(|()| (upright + (point() - 0.5) * 0.5).normalize());
                let corners = TriangleVertices {
                    positions: corners.map(Into::into),
                    normals: normals.map(Into::into),
                };
                (corners, BuiltPatch::new(&corners, PatchFlags::default()))
            };
            Self((0..count).map(|_| triangle()).collect())
        }

        pub fn boxes(&self) -> Vec<Bounds> {
            let bounds = self
                .0
                .iter()
                .map(|(_, prepared)| prepared.bounds.map(Vec3::from));
            bounds
                .map(|[lower, upper]| Bounds { lower, upper })
                .collect()
        }

        pub fn clusters(&self) -> Box<[Cluster]> {
            group(&self.boxes(), |triangle| self.kept(triangle))
        }

        /// Some point of a triangle's surface.
        pub fn point(&self, triangle: u32, random: &mut SmallRng) -> Vec3 {
            let [mut u, mut v]: [f32; 2] = random.random();
            if u + v > 1.0 {
                (u, v) = (1.0 - u, 1.0 - v);
            }
            self.kept(triangle).unpack().point(u, v).position.into()
        }

        pub fn kept(&self, triangle: u32) -> PackedTriangle<'_> {
            let (corners, BuiltPatch { packed: record, .. }) = &self.0[triangle as usize];
            let record: &PackedPatch = record;
            PackedTriangle::new(*corners, record)
        }
    }

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
            let triangles = Triangles::new(5, 400, size, lower);
            for cluster in &triangles.clusters() {
                let bounds = cluster.bounds();
                for (n, &triangle) in cluster.triangles.iter().enumerate() {
                    if triangle == NONE {
                        continue;
                    }
                    // but for rounding, which tests of rays make up for
                    let room = 1e-5 * (cluster.extent() + bounds.upper.abs().max_element() * 0.01);
                    for _ in 0..20 {
                        let point = triangles.point(triangle, &mut random);
                        assert!(bounds.lower.cmple(point + room).all(), "{point}");
                        assert!(bounds.upper.cmpge(point - room).all(), "{point}");
                        for axis in 0..DIRECTIONS {
                            let [middle, half] = cluster.ranges_in_steps(axis);
                            let at = cluster.direction(axis).dot(point - cluster.middle());
                            let step = cluster.step()[axis];
                            let off = (at - middle[n] * step).abs();
                            assert!(off <= 0.5 * half[n] * step + room, "{axis} {point}");
                        }
                        points += 1;
                    }
                    let way = |axis: usize| {
                        let half = cluster.ranges_in_steps(axis)[1][n];
                        f64::from(half * cluster.step()[axis] / size)
                    };
                    volume += way(0) * way(1) * way(2);
                }
            }
        }
        println!("{points} points, {volume} of the cubes is in boxes");
        assert!(points > 30_000 && volume < 2.0, "{points} {volume}");
    }

    #[test]
    fn neighbours_in_a_plane_have_thin_boxes() {
        let up = vec3(0.48, 0.6, 0.64);
        let (along, across) = (vec3(0.8, 0.0, -0.6), up.cross(vec3(0.8, 0.0, -0.6)));
        let shapes: Vec<(TriangleVertices, BuiltPatch)> = (0..SIZE)
            .map(|triangle| {
                let at = along * (triangle / 2) as f32 + across * (triangle % 2) as f32;
                let positions = [at, at + along, at + across].map(Into::into);
                let corners = TriangleVertices {
                    positions,
                    normals: [up.into(); 3],
                };
                (corners, BuiltPatch::new(&corners, PatchFlags::default()))
            })
            .collect();
        let cluster = &Triangles(shapes).clusters()[0];
        for n in 0..SIZE {
            let [a, b, height] =
                [0, 1, 2].map(|axis| cluster.ranges_in_steps(axis)[1][n] * cluster.step()[axis]);
            // no larger than the digits of directions and steps make them
            assert!(a < 1.1 && b < 1.1 && height < 0.03, "{a} {b} {height}");
            // What the triangle leaves of a rectangle is cut off.
            let triangle = cluster.triangles[n];
            let at = along * (triangle / 2) as f32 + across * (triangle % 2) as f32;
            let is_in = |u: f32, v: f32| {
                let way = at + along * u + across * v - cluster.middle();
                let [middle, half] = cluster.ranges_in_steps(CUT);
                let steps = cluster.direction(CUT).dot(way) / cluster.step()[CUT];
                (steps - middle[n]).abs() <= 0.5 * half[n]
            };
            assert!(is_in(0.5, 0.5) && is_in(0.0, 0.0) && !is_in(0.55, 0.55));
        }
    }
}
