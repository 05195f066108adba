//! Groups a mesh's triangles into clusters of neighbours.

use glam::Vec3;
use rayon::prelude::*;

use super::build::build;
use super::layout::{Cluster, NONE, SIZE};
use crate::embree::Bounds;
use curvetri_method::PackedTriangle;

/// The centre of a triangle's box, times two.
#[derive(Clone, Copy)]
struct Centre {
    /// Whole numbers that are ordered like the coordinates: comparing them takes a third of the time.
    at: [u32; 3],
    triangle: u32,
}

impl Centre {
    fn new(triangle: u32, bounds: &Bounds) -> Self {
        Self {
            at: (bounds.lower + bounds.upper).to_array().map(ordered),
            triangle,
        }
    }

    /// Orders centres along an axis. Between equal ones the triangles' numbers decide, so that the same mesh
    /// always gives the same clusters.
    #[inline(always)]
    fn key<const AXIS: usize>(self) -> u64 {
        u64::from(self.at[AXIS]) << 32 | u64::from(self.triangle)
    }
}

const SIGN: u32 = 1 << 31;

/// A whole number for each `f32`, ordered as [`f32::total_cmp`] orders those.
#[inline(always)]
fn ordered(number: f32) -> u32 {
    let bits = number.to_bits();
    bits ^ ((bits.cast_signed() >> 31).cast_unsigned() | SIGN)
}

/// The `f32` of which this is the [whole number](ordered).
fn number(ordered: u32) -> f32 {
    f32::from_bits(if ordered & SIGN == 0 {
        !ordered
    } else {
        ordered ^ SIGN
    })
}

/// Groups the triangles of a mesh by place. Triangles with an empty box are left out: nothing hits them.
pub(in crate::curved) fn group<'a>(
    boxes: &[Bounds],
    packed_triangle: impl Fn(u32) -> PackedTriangle<'a> + Sync,
) -> Box<[Cluster]> {
    let mut centres: Vec<Centre> = (0..boxes.len() as u32)
        .into_par_iter()
        .zip(boxes)
        .filter(|(_, bounds)| !bounds.is_empty())
        .map(|(triangle, bounds)| Centre::new(triangle, bounds))
        .collect();
    split(&mut centres);
    centres
        .par_chunks(SIZE)
        .map(|centres| {
            let mut triangles = [NONE; SIZE];
            for (triangle, centre) in triangles.iter_mut().zip(centres) {
                *triangle = centre.triangle;
            }
            build(&triangles[..centres.len()], boxes, &packed_triangle)
        })
        .collect()
}

/// Sorts centres such that every [`SIZE`] of them, from the first on, lie close together: halves them along
/// their longest axis, at a multiple of the size, and each half again.
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

/// Moves the lower ones along an axis before the higher ones.
fn halve<const AXIS: usize>(centres: &mut [Centre], half: usize) {
    centres.select_nth_unstable_by(half, |a, b| a.key::<AXIS>().cmp(&b.key::<AXIS>()));
}

/// The axis along which centres lie furthest apart.
fn longest_axis(centres: &[Centre]) -> usize {
    let (mut lower, mut upper) = (centres[0].at, centres[0].at);
    for centre in centres {
        for axis in 0..3 {
            lower[axis] = lower[axis].min(centre.at[axis]);
            upper[axis] = upper[axis].max(centre.at[axis]);
        }
    }
    let [lower, upper] = [lower, upper].map(|at| Vec3::from(at.map(number)));
    (upper - lower).max_position()
}

#[cfg(test)]
mod tests {
    use super::super::test_triangles::TestTriangles;
    use super::*;

    #[test]
    fn whole_numbers_are_ordered_like_others_and_come_back() {
        let numbers = [-3e38, -2.0, -1e-40, -0.0, 0.0, 1e-40, 1.5, f32::INFINITY];
        for pair in numbers.windows(2) {
            assert!(ordered(pair[0]) < ordered(pair[1]), "{pair:?}");
        }
        for at in numbers {
            assert_eq!(number(ordered(at)).to_bits(), at.to_bits());
        }
    }

    #[test]
    fn every_triangle_with_a_box_is_in_one_cluster() {
        for count in [0, 1, 7, 8, 9, 1000, 20_001] {
            let triangles = TestTriangles::new(1, count, 2.0, Vec3::ZERO);
            let mut boxes = triangles.boxes();
            for empty in boxes.iter_mut().step_by(11) {
                *empty = Bounds::EMPTY;
            }
            let clusters = group(&boxes, |triangle| triangles.packed_triangle(triangle));
            let all = clusters.iter().flat_map(|cluster| cluster.triangles);
            let mut seen: Vec<u32> = all.filter(|&triangle| triangle != NONE).collect();
            assert_eq!(clusters.len(), seen.len().div_ceil(SIZE));
            seen.sort_unstable();
            let expected = (0..count as u32).filter(|&n| n % 11 != 0);
            assert_eq!(seen, expected.collect::<Vec<_>>());
        }
    }
}
