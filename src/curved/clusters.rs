//! Neighbouring triangles as one Embree primitive: a tree a level or three lower, fewer callbacks, and
//! the boxes of all its triangles in two cache lines.

use glam::Vec3;
use rayon::prelude::*;

use crate::embree::Bounds;

/// Most triangles of a cluster.
pub(super) const SIZE: usize = 8;
/// In place of a triangle's number where a cluster has fewer.
pub(super) const NONE: u32 = u32::MAX;
/// Steps along an axis of a cluster's box in which its triangles' boxes are given.
pub(super) const STEPS: f32 = 255.0;

/// Some neighbouring triangles and their boxes.
#[derive(Clone, Debug)]
#[repr(C)]
pub(super) struct Cluster {
    /// The lower corner of the common box.
    pub corner: [f32; 3],
    /// A step along each axis.
    pub step: [f32; 3],
    /// The boxes' lower corners, in steps, an axis each.
    pub lower: [[u8; SIZE]; 3],
    /// Their upper ones.
    pub upper: [[u8; SIZE]; 3],
    pub triangles: [u32; SIZE],
}

/// A triangle where its box's centre is, twice as far from the origin.
#[derive(Clone, Copy)]
struct Centre {
    at: [f32; 3],
    triangle: u32,
}

impl Centre {
    /// Orders centres along an axis; the numbers decide between equal ones, so that the same mesh gives the
    /// same clusters. One comparison of whole numbers, which is a third of the time.
    #[inline(always)]
    fn key<const AXIS: usize>(self) -> u64 {
        let bits = self.at[AXIS].to_bits();
        // As [`f32::total_cmp`] orders them.
        let ordered = bits ^ ((bits.cast_signed() >> 31).cast_unsigned() | 1 << 31);
        u64::from(ordered) << 32 | u64::from(self.triangle)
    }
}

/// Groups triangles by place. Triangles with an empty box are left out: nothing hits them.
pub(super) fn group(boxes: &[Bounds]) -> Box<[Cluster]> {
    let mut centres: Vec<Centre> = (0..boxes.len() as u32)
        .into_par_iter()
        .zip(boxes)
        .filter(|(_, bounds)| !bounds.is_empty())
        .map(|(triangle, bounds)| Centre {
            at: (bounds.lower + bounds.upper).to_array(),
            triangle,
        })
        .collect();
    split(&mut centres);
    centres
        .par_chunks(SIZE)
        .map(|members| Cluster::new(boxes, members))
        .collect()
}

/// Sorts triangles such that every run of [`SIZE`] from the first on is a compact one: by the boxes'
/// centres, halved along the longest axis again and again, at a multiple of the size.
fn split(centres: &mut [Centre]) {
    if centres.len() <= SIZE {
        return;
    }
    let half = (centres.len() / 2).next_multiple_of(SIZE);
    match longest_axis(centres) {
        0 => halve::<0>(centres, half),
        1 => halve::<1>(centres, half),
        _ => halve::<2>(centres, half),
    }
    let (left, right) = centres.split_at_mut(half);
    if left.len() > 1 << 12 {
        rayon::join(|| split(left), || split(right));
    } else {
        split(left);
        split(right);
    }
}

/// Moves what is lower along an axis before what is higher.
fn halve<const AXIS: usize>(centres: &mut [Centre], half: usize) {
    centres.select_nth_unstable_by(half, |a, b| a.key::<AXIS>().cmp(&b.key::<AXIS>()));
}

/// The axis along which centres lie furthest apart.
fn longest_axis(centres: &[Centre]) -> usize {
    let first = Vec3::from(centres[0].at);
    let (lower, upper) = centres
        .iter()
        .fold((first, first), |(lower, upper), centre| {
            let at = Vec3::from(centre.at);
            (lower.min(at), upper.max(at))
        });
    (upper - lower).max_position()
}

impl Cluster {
    fn new(boxes: &[Bounds], members: &[Centre]) -> Self {
        let mut all = Bounds::EMPTY;
        let mut bounds = [Bounds::EMPTY; SIZE];
        for (bounds, member) in bounds.iter_mut().zip(members) {
            *bounds = boxes[member.triangle as usize];
            all = all.union(*bounds);
        }
        let mut cluster = Self {
            corner: all.lower.to_array(),
            step: [0.0; 3],
            // An empty box: above its upper end.
            lower: [[u8::MAX; SIZE]; 3],
            upper: [[0; SIZE]; 3],
            triangles: [NONE; SIZE],
        };
        for axis in 0..3 {
            cluster.step[axis] = step(all.lower[axis], all.upper[axis]);
            let per_step = 1.0 / cluster.step[axis];
            for (n, bounds) in bounds[..members.len()].iter().enumerate() {
                let (lower, upper) = (bounds.lower[axis], bounds.upper[axis]);
                cluster.lower[axis][n] = cluster.step_below(axis, lower, per_step);
                cluster.upper[axis][n] = cluster.step_above(axis, upper, per_step);
            }
        }
        for (place, member) in cluster.triangles.iter_mut().zip(members) {
            *place = member.triangle;
        }
        cluster
    }

    /// The number of triangle `n`.
    pub fn triangle(&self, n: usize) -> u32 {
        self.triangles[n]
    }

    /// The box of all its triangles.
    pub fn bounds(&self) -> Bounds {
        let (corner, step) = (glam::Vec3::from(self.corner), glam::Vec3::from(self.step));
        let upper = corner + step * STEPS;
        Bounds {
            lower: corner,
            upper: upper.to_array().map(f32::next_up).into(),
        }
    }

    /// How far a number of steps leads. From the corner, not from the origin, whose distance may be
    /// large against the box, and rounding with it.
    fn way(&self, axis: usize, steps: u8) -> f32 {
        self.step[axis] * f32::from(steps)
    }

    /// The greatest number of steps, but for rounding, that leads no further than this.
    fn step_below(&self, axis: usize, to: f32, per_step: f32) -> u8 {
        let way = to - self.corner[axis];
        let mut steps = (way * per_step) as u8;
        while steps > 0 && self.way(axis, steps) > way {
            steps -= 1;
        }
        steps
    }

    /// The least number of steps, but for rounding, that leads as far as this.
    fn step_above(&self, axis: usize, to: f32, per_step: f32) -> u8 {
        let way = to - self.corner[axis];
        let mut steps = (way * per_step) as u8;
        while steps < u8::MAX && self.way(axis, steps) < way {
            steps += 1;
        }
        steps
    }

    /// The places that hold a triangle, one bit each.
    pub fn present(&self) -> u32 {
        let missing = self.triangles.iter().filter(|&&triangle| triangle == NONE);
        ALL >> missing.count()
    }
}

/// All places of a cluster, one bit each.
const ALL: u32 = u32::MAX >> (u32::BITS as usize - SIZE);

/// A step along an axis from the lower to the upper end of a cluster's box, such that all of them
/// reach the upper end whatever the rounding.
fn step(lower: f32, upper: f32) -> f32 {
    let mut step = (upper - lower) / STEPS;
    while step * STEPS < upper - lower {
        step = step.next_up();
    }
    step.max(f32::MIN_POSITIVE)
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use glam::vec3;
    use rand::{Rng, SeedableRng, rngs::SmallRng};

    pub fn boxes(random: &mut SmallRng, count: usize, size: f32, centre: Vec3) -> Vec<Bounds> {
        let mut point = |size: f32| vec3(random.random(), random.random(), random.random()) * size;
        (0..count)
            .map(|_| {
                let lower = centre + point(size);
                let upper = lower + point(size * 0.1);
                Bounds { lower, upper }
            })
            .collect()
    }

    #[test]
    fn every_triangle_with_a_box_is_in_one_cluster_that_holds_it() {
        let mut random = SmallRng::seed_from_u64(1);
        for count in [0, 1, 7, 8, 9, 1000, 20_001] {
            let mut boxes = boxes(&mut random, count, 2.0, Vec3::ZERO);
            for empty in boxes.iter_mut().step_by(11) {
                *empty = Bounds::EMPTY;
            }
            let clusters = group(&boxes);
            let mut seen: Vec<u32> = Vec::new();
            for cluster in &clusters {
                for (n, &triangle) in cluster.triangles.iter().enumerate() {
                    if triangle == NONE {
                        continue;
                    }
                    seen.push(triangle);
                    let wanted = &boxes[triangle as usize];
                    for axis in 0..3 {
                        // But for rounding of the box's size, which tests of rays make up for.
                        let at = |steps: u8| {
                            f64::from(cluster.corner[axis])
                                + f64::from(cluster.step[axis]) * f64::from(steps)
                        };
                        let room = f64::from(cluster.step[axis] * STEPS * f32::EPSILON);
                        let [lower, upper] =
                            [wanted.lower[axis], wanted.upper[axis]].map(f64::from);
                        assert!(at(cluster.lower[axis][n]) <= lower + room);
                        assert!(at(cluster.upper[axis][n]) >= upper - room);
                        assert!(cluster.bounds().lower[axis] <= wanted.lower[axis]);
                        assert!(cluster.bounds().upper[axis] >= wanted.upper[axis]);
                    }
                }
            }
            seen.sort_unstable();
            let expected = (0..count as u32).filter(|&n| n % 11 != 0);
            assert_eq!(seen, expected.collect::<Vec<_>>());
            assert_eq!(clusters.len(), seen.len().div_ceil(SIZE));
        }
    }
}
