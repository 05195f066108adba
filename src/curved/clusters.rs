//! Grouping a mesh's triangles into clusters of neighbours.

use glam::Vec3;
use rayon::prelude::*;

use super::cluster::{Cluster, Member, SIZE};
use crate::embree::Bounds;
use crate::method::PackedTriangle;

/// A triangle where its box's centre is, twice as far from the origin.
#[derive(Clone, Copy)]
struct Centre {
    /// As whole numbers that are ordered like the coordinates: comparing them is a third of the time.
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

    /// Orders centres along an axis; the numbers decide between equal ones, so that the same mesh gives the
    /// same clusters.
    #[inline(always)]
    fn key<const AXIS: usize>(self) -> u64 {
        u64::from(self.at[AXIS]) << 32 | u64::from(self.triangle)
    }
}

const SIGN: u32 = 1 << 31;

/// A whole number for each of the others, ordered as [`f32::total_cmp`] orders those.
#[inline(always)]
fn ordered(number: f32) -> u32 {
    let bits = number.to_bits();
    bits ^ ((bits.cast_signed() >> 31).cast_unsigned() | SIGN)
}

/// Whose whole number this is.
fn number(ordered: u32) -> f32 {
    f32::from_bits(if ordered & SIGN == 0 {
        !ordered
    } else {
        ordered ^ SIGN
    })
}

/// Groups triangles by place, each with its box and what is kept of it. Triangles with an empty box are left
/// out: nothing hits them.
pub(super) fn group<'a>(
    boxes: &[Bounds],
    kept: impl Fn(u32) -> PackedTriangle<'a> + Sync,
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
        .map(|members| {
            let member = |&Centre { triangle, .. }: &Centre| Member {
                triangle,
                bounds: boxes[triangle as usize],
                kept: kept(triangle),
            };
            let mut list = [member(&members[0]); SIZE];
            for (place, centre) in list.iter_mut().zip(members).skip(1) {
                *place = member(centre);
            }
            Cluster::new(&list[..members.len()])
        })
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
    use super::super::cluster::NONE;
    use super::super::cluster::tests::Triangles;
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
            let triangles = Triangles::new(1, count, 2.0, Vec3::ZERO);
            let mut boxes = triangles.boxes();
            for empty in boxes.iter_mut().step_by(11) {
                *empty = Bounds::EMPTY;
            }
            let clusters = group(&boxes, |triangle| triangles.kept(triangle));
            let all = clusters.iter().flat_map(|cluster| cluster.triangles);
            let mut seen: Vec<u32> = all.filter(|&triangle| triangle != NONE).collect();
            assert_eq!(clusters.len(), seen.len().div_ceil(SIZE));
            seen.sort_unstable();
            let expected = (0..count as u32).filter(|&n| n % 11 != 0);
            assert_eq!(seen, expected.collect::<Vec<_>>());
        }
    }
}
