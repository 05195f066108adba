//! Neighbouring triangles as one Embree primitive: a tree a level or three lower, fewer callbacks, and
//! the boxes of all its triangles in two cache lines.
//!
//! The boxes are the cluster's own: along the sum of its triangles' normals, where neighbours are thin, and
//! along a side of one of them. Boxes along the axes of space let half as many more rays through. As the
//! directions are kept in a few digits they are not quite perpendicular, which nothing depends on: a box is
//! what lies between two values along each of three directions.

use fearless_simd::{Level, dispatch, f32x8, prelude::*};
use glam::Vec3;

use crate::embree::Bounds;
use crate::surface::{KeptPatch, PATCHES, Patches, Reach, Real, Vector, inlined, vector};

/// Most triangles of a cluster.
pub(super) const SIZE: usize = 8;
/// In place of a triangle's number where a cluster has fewer.
pub(super) const NONE: u32 = u32::MAX;
/// Steps from the middle of a cluster to the furthest end of its triangles' boxes along a direction.
const STEPS: f32 = 127.0;
/// A direction's components are kept in units of one over this.
const DIGITS: f32 = 128.0;
/// How far off its bounds a surface may come out, in units of epsilon of the cluster's extents.
const ROUNDING: f32 = 64.0 * f32::EPSILON;

/// Some neighbouring triangles and their boxes.
#[derive(Clone, Debug)]
#[repr(C, align(64))]
pub(super) struct Cluster {
    /// The corners of the common box, along the axes of space.
    lower: [f32; 3],
    upper: [f32; 3],
    /// The first components of the three directions, their second and their third ones.
    directions: [[i8; 4]; 3],
    /// A step along each direction.
    step: [f32; 3],
    /// Where the boxes begin along each direction, in steps from the middle.
    pub from: [[i8; SIZE]; 3],
    /// And where they end.
    pub to: [[i8; SIZE]; 3],
    pub triangles: [u32; SIZE],
}

const _: () = assert!(size_of::<Cluster>() == 128 && SIZE == PATCHES);

/// A triangle of a cluster.
#[derive(Clone, Copy)]
pub(super) struct Member<'a> {
    pub triangle: u32,
    /// Its box along the axes of space.
    pub bounds: Bounds,
    pub kept: KeptPatch<'a>,
}

/// The triangles of a cluster, one a lane.
struct Shapes<S: Simd> {
    reach: Reach<Patches<S>>,
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
        let mut cluster = Self {
            lower: all.lower.to_array(),
            upper: all.upper.to_array(),
            directions: [[0; 4]; 3],
            step: [0.0; 3],
            from: [[0; SIZE]; 3],
            to: [[0; SIZE]; 3],
            triangles: [NONE; SIZE],
        };
        for (axis, direction) in shapes.directions(members.len()).into_iter().enumerate() {
            for (to, component) in cluster.directions.iter_mut().zip(direction.to_array()) {
                to[axis] = (component * STEPS).round() as i8;
            }
        }
        for axis in 0..3 {
            let [from, to] = cluster.ranges(axis, &shapes);
            let step = step(furthest(from).max(furthest(to)));
            cluster.step[axis] = step;
            cluster.from[axis] = steps_below(from, step).map(|steps| steps as i8);
            cluster.to[axis] = steps_below(-to, step).map(|steps| -steps as i8);
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
        let all = inlined(
            #[inline(always)]
            |of: Vec3| {
                let [x, y, z] = of.to_array().map(f64::from);
                vector(like.constant(x), like.constant(y), like.constant(z))
            },
        );
        let (direction, middle) = (all(self.direction(axis)), all(self.middle()));
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
        Vec3::from(self.lower) * 0.5 + Vec3::from(self.upper) * 0.5
    }

    /// How far, along any direction, it is from the middle to where a triangle may be at the most.
    #[inline(always)]
    pub fn extent(&self) -> f32 {
        (Vec3::from(self.upper) * 0.5 - Vec3::from(self.lower) * 0.5).element_sum()
    }

    /// One of the three directions, in size about one.
    #[inline(always)]
    pub fn direction(&self, axis: usize) -> Vec3 {
        let [x, y, z] = self.directions.map(|component| f32::from(component[axis]));
        Vec3::new(x, y, z) * (1.0 / DIGITS)
    }

    /// A component of all three directions; zero behind them.
    #[inline(always)]
    pub fn components(&self, component: usize) -> [f32; 4] {
        self.directions[component].map(|digits| f32::from(digits) * (1.0 / DIGITS))
    }

    /// A step along each of the three directions.
    #[inline(always)]
    pub fn step(&self) -> [f32; 3] {
        self.step
    }

    /// The box of all its triangles.
    pub fn bounds(&self) -> Bounds {
        Bounds {
            lower: self.lower.into(),
            upper: self.upper.into(),
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
                let mut columns = [[0.0; SIZE]; 3];
                for n in 0..SIZE {
                    for (column, number) in
                        columns.iter_mut().zip(corner(&member(n).bounds).to_array())
                    {
                        column[n] = number;
                    }
                }
                let number = inlined(
                    #[inline(always)]
                    |axis: usize| Patches(f32x8::from_slice(simd, &columns[axis])),
                );
                vector(number(0), number(1), number(2))
            },
        );
        Self {
            reach: Reach::of_patches(simd, |n| member(n).kept),
            lower: corners(|bounds| bounds.lower),
            upper: corners(|bounds| bounds.upper),
        }
    }

    /// Along the first triangle's first side, across it, and along the mean of the first so many normals: of
    /// unit length.
    #[inline(always)]
    fn directions(&self, count: usize) -> [Vec3; 3] {
        let Vector { x, y, z } = self.reach.normal();
        let sum = |of: Patches<S>| of.numbers()[..count].iter().sum::<f32>();
        let up = Vec3::new(sum(x), sum(y), sum(z)).normalize_or(Vec3::Z);
        let Vector { x, y, z } = self.reach.side();
        let side = Vec3::new(x.numbers()[0], y.numbers()[0], z.numbers()[0]);
        // Scaled first: its square may be too small a number.
        let side = side / side.abs().max_element().max(f32::MIN_POSITIVE);
        let across = up.cross(side);
        let across = across.normalize_or(up.any_orthonormal_vector());
        [across.cross(up), across, up]
    }
}

/// The greatest absolute value.
#[inline(always)]
fn furthest<S: Simd>(of: Patches<S>) -> f32 {
    of.abs().numbers().into_iter().fold(0.0, f32::max)
}

/// The least step such that [`STEPS`] of them lead this far, whatever the rounding.
fn step(furthest: f32) -> f32 {
    let mut step = furthest / STEPS;
    while step * STEPS < furthest {
        step = step.next_up();
    }
    step.max(f32::MIN_POSITIVE)
}

/// The greatest numbers of steps that lead no further than these.
#[inline(always)]
fn steps_below<S: Simd>(to: Patches<S>, step: f32) -> [f32; SIZE] {
    let (step, one) = (to.constant(step.into()), to.constant(1.0));
    let steps = Patches((to / step).0.floor());
    // Where the quotient was rounded up.
    let steps = Patches::select(to.less(steps * step), steps - one, steps);
    steps.greater(to.constant((-STEPS).into())).numbers()
}

#[cfg(test)]
pub(super) mod tests {
    use super::super::clusters::group;
    use super::*;
    use crate::surface::{Corners, KeptPatch, PatchFlags, PatchRecord, Prepared};
    use glam::vec3;
    use rand::{Rng, SeedableRng, rngs::SmallRng};

    /// Curved triangles here and there.
    pub struct Triangles(Vec<(Corners, Prepared)>);

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
                let corners = Corners {
                    positions: corners.map(Into::into),
                    normals: normals.map(Into::into),
                };
                (corners, Prepared::new(&corners, PatchFlags::default()))
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
            self.kept(triangle).patch().point(u, v).position.into()
        }

        pub fn kept(&self, triangle: u32) -> KeptPatch<'_> {
            let (corners, Prepared { record, .. }) = &self.0[triangle as usize];
            let record: &PatchRecord = record;
            KeptPatch::new(*corners, record)
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
                        for axis in 0..3 {
                            let at = cluster.direction(axis).dot(point - cluster.middle());
                            let end = |steps: i8| f32::from(steps) * cluster.step()[axis];
                            assert!(end(cluster.from[axis][n]) <= at + room, "{axis} {point}");
                            assert!(end(cluster.to[axis][n]) >= at - room, "{axis} {point}");
                        }
                        points += 1;
                    }
                    let way = |axis: usize| {
                        let [from, to] = [cluster.from, cluster.to].map(|end| end[axis][n]);
                        f64::from((f32::from(to) - f32::from(from)) * cluster.step()[axis] / size)
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
        let shapes: Vec<(Corners, Prepared)> = (0..SIZE)
            .map(|triangle| {
                let at = along * (triangle / 2) as f32 + across * (triangle % 2) as f32;
                let positions = [at, at + along, at + across].map(Into::into);
                let corners = Corners {
                    positions,
                    normals: [up.into(); 3],
                };
                (corners, Prepared::new(&corners, PatchFlags::default()))
            })
            .collect();
        let cluster = &Triangles(shapes).clusters()[0];
        for n in 0..SIZE {
            let [a, b, height] = [0, 1, 2].map(|axis| {
                let steps = f32::from(cluster.to[axis][n]) - f32::from(cluster.from[axis][n]);
                steps * cluster.step()[axis]
            });
            // no larger than the digits of directions and steps make them
            assert!(a < 1.1 && b < 1.1 && height < 0.03, "{a} {b} {height}");
        }
    }
}
