//! Which vertices have the same position, bit for bit.

use glam::Vec3;
use hashbrown::hash_table::{Entry, HashTable};

/// For each position the number of its place, and how many places there are.
///
/// Places are numbered in the order in which they first occur. Positions are the same if their
/// bits are; zeros have to be positive.
pub fn weld(positions: &[Vec3]) -> (Vec<u32>, usize) {
    let bits = |i: u32| positions[i as usize].to_array().map(f32::to_bits);
    // Of each place the number and the first position.
    let mut places = HashTable::<(u32, u32)>::with_capacity(positions.len());
    let mut place_of = Vec::with_capacity(positions.len());
    for i in 0..positions.len() as u32 {
        let count = places.len() as u32;
        let own = bits(i);
        let same = |&(_, first): &(u32, u32)| bits(first) == own;
        let place = match places.entry(hash(own), same, |&(_, first)| hash(bits(first))) {
            Entry::Occupied(place) => place.get().0,
            Entry::Vacant(free) => free.insert((count, i)).get().0,
        };
        place_of.push(place);
    }
    (place_of, places.len())
}

/// Mixes a position's bits: the two halves of a product of all of them.
fn hash([x, y, z]: [u32; 3]) -> u64 {
    // Of the digits of pi, so that zeros do not make the product zero.
    let a = (u64::from(x) << 32 | u64::from(y)) ^ 0x243f_6a88_85a3_08d3;
    let b = u64::from(z) ^ 0x1319_8a2e_0370_7344;
    let product = u128::from(a) * u128::from(b);
    product as u64 ^ (product >> 64) as u64
}

/// Items grouped by a small integer key: for each key a slice of the items' numbers in rising order.
pub struct Groups {
    starts: Vec<u32>,
    items: Vec<u32>,
}

impl Groups {
    /// Groups items `0..` by their keys, which are all below `count`.
    pub fn new(keys: impl Iterator<Item = u32> + Clone, count: usize) -> Groups {
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
    pub fn len(&self) -> usize {
        self.starts.len() - 1
    }

    /// The items of a key.
    pub fn of(&self, key: usize) -> &[u32] {
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
