//! Which vertices have the same position, bit for bit.

use glam::Vec3;
use rayon::prelude::*;

/// For each position the number of its place, and how many places there are.
///
/// Places are numbered in the order in which they first occur. Positions are the same if their
/// bits are; zeros have to be positive.
pub(crate) fn weld(positions: &[Vec3]) -> (Vec<u32>, usize) {
    let mut order: Vec<(u64, u32, u32)> = positions
        .par_iter()
        .enumerate()
        .map(|(i, p)| {
            let [x, y, z] = p.to_array().map(f32::to_bits);
            (u64::from(x) << 32 | u64::from(y), z, i as u32)
        })
        .collect();
    order.par_sort_unstable();
    let mut places = vec![0u32; positions.len()];
    // First the least index of each run, which comes first in it; then numbers in index order.
    for run in order.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)) {
        for &(_, _, i) in run {
            places[i as usize] = run[0].2;
        }
    }
    drop(order);
    let mut count = 0;
    for i in 0..places.len() {
        let first = places[i] as usize;
        places[i] = if first == i {
            count += 1;
            count - 1
        } else {
            places[first]
        };
    }
    (places, count as usize)
}

/// Items grouped by a small integer key: for each key a slice of the items' numbers in rising order.
pub(crate) struct Groups {
    starts: Vec<u32>,
    items: Vec<u32>,
}

impl Groups {
    /// Groups items `0..` by their keys, which are all below `count`.
    pub(crate) fn new(keys: impl Iterator<Item = u32> + Clone, count: usize) -> Groups {
        let mut starts = vec![0u32; count + 2];
        for key in keys.clone() {
            starts[key as usize + 2] += 1;
        }
        for i in 2..starts.len() {
            starts[i] += starts[i - 1];
        }
        let mut items = vec![0u32; starts[count + 1] as usize];
        // While filling, starts[key + 1] runs from the key's start to its end, which leaves it at
        // the start of the next.
        for (item, key) in keys.enumerate() {
            let at = &mut starts[key as usize + 1];
            items[*at as usize] = item as u32;
            *at += 1;
        }
        starts.pop();
        Groups { starts, items }
    }

    /// How many keys there are.
    pub(crate) fn len(&self) -> usize {
        self.starts.len() - 1
    }

    /// The items of a key.
    pub(crate) fn of(&self, key: usize) -> &[u32] {
        &self.items[self.starts[key] as usize..self.starts[key + 1] as usize]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_positions_share_a_place() {
        let (places, count) = weld(&[Vec3::Y, Vec3::X, Vec3::Y, Vec3::ZERO, Vec3::X]);
        assert_eq!(places, [0, 1, 0, 2, 1]);
        assert_eq!(count, 3);
    }

    #[test]
    fn neighbouring_floats_are_different_places() {
        let above = f32::from_bits(1f32.to_bits() + 1);
        let (places, count) = weld(&[Vec3::X, Vec3::new(above, 0.0, 0.0)]);
        assert_eq!(places, [0, 1]);
        assert_eq!(count, 2);
    }

    #[test]
    fn groups_list_items_by_key() {
        let groups = Groups::new([2, 0, 2, 3, 0].into_iter(), 4);
        assert_eq!(groups.len(), 4);
        assert_eq!(groups.of(0), [1, 4]);
        assert_eq!(groups.of(1), [] as [u32; 0]);
        assert_eq!(groups.of(2), [0, 2]);
        assert_eq!(groups.of(3), [3]);
    }
}
