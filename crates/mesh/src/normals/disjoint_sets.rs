//! Union-find over small integers.

/// Numbers in disjoint sets. The least number of a set is its root, so that the result does not
/// depend on the order in which sets were united.
#[derive(Default)]
pub(super) struct DisjointSets {
    /// A lower number of the same set; itself at the root.
    parents: Vec<u32>,
}

impl DisjointSets {
    /// The numbers below `count`, each in a set of its own.
    pub(super) fn new(count: usize) -> DisjointSets {
        let mut sets = DisjointSets::default();
        sets.reset(count);
        sets
    }

    /// As new, with the memory used again.
    pub(super) fn reset(&mut self, count: usize) {
        self.parents.clear();
        self.parents.extend(0..count as u32);
    }

    /// The least number of the set that a number is in.
    pub(super) fn root(&mut self, mut i: u32) -> u32 {
        while self.parents[i as usize] != i {
            let grandparent = self.parents[self.parents[i as usize] as usize];
            self.parents[i as usize] = grandparent;
            i = grandparent;
        }
        i
    }

    /// Makes the sets of two numbers one.
    pub(super) fn unite(&mut self, a: u32, b: u32) {
        let (a, b) = (self.root(a), self.root(b));
        self.parents[a.max(b) as usize] = a.min(b);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_least_number_is_the_root_in_any_order() {
        for pairs in [[(5, 3), (3, 1), (4, 2)], [(4, 2), (1, 3), (5, 1)]] {
            let mut sets = DisjointSets::new(6);
            pairs.iter().for_each(|&(a, b)| sets.unite(a, b));
            let roots: Vec<u32> = (0..6).map(|i| sets.root(i)).collect();
            assert_eq!(roots, [0, 1, 2, 1, 2, 1]);
        }
    }
}
