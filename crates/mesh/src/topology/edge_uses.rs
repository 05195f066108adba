//! Which triangles use the edges at each place.

use std::sync::atomic::{AtomicU32, AtomicU64, Ordering::Relaxed};

use rayon::prelude::*;

/// One use of an edge by a triangle. Ordered by the edge's other end, then by the triangle.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct EdgeUse {
    /// The higher of its places.
    pub higher: u32,
    /// Triangle and edge in one.
    pub edge: u32,
    /// Whether the triangle has it run from the lower place to the higher.
    pub rises: bool,
    /// The place of the triangle's third corner.
    pub opposite: u32,
}

impl EdgeUse {
    /// Of edge `k` of a triangle with these places, with the lower of the edge's own.
    fn new(triangle: usize, corners: [u32; 3], k: usize) -> (u32, EdgeUse) {
        let (from, to) = (corners[k], corners[(k + 1) % 3]);
        let edge_use = EdgeUse {
            higher: from.max(to),
            edge: (3 * triangle + k) as u32,
            rises: from < to,
            opposite: corners[(k + 2) % 3],
        };
        (from.min(to), edge_use)
    }

    /// Edges are numbered below [`MAX_INDICES`](crate::MAX_INDICES), 2^31, which leaves one bit.
    fn pack(self) -> (u64, u32) {
        let edge = self.edge << 1 | u32::from(self.rises);
        (
            u64::from(self.higher) << 32 | u64::from(edge),
            self.opposite,
        )
    }

    fn unpack((packed, opposite): (u64, u32)) -> Self {
        Self {
            higher: (packed >> 32) as u32,
            edge: packed as u32 >> 1,
            rises: packed & 1 != 0,
            opposite,
        }
    }
}

/// Whether two corners are in one place.
fn is_collapsed([a, b, c]: [u32; 3]) -> bool {
    a == b || b == c || c == a
}

/// The uses of all edges, except those of collapsed triangles, grouped by the lower of their places.
pub(super) struct EdgesByPlace {
    /// Where each place's group ends.
    ends: Vec<u32>,
    /// [Packed](EdgeUse::pack).
    uses: Vec<(AtomicU64, AtomicU32)>,
}

/// Most parts in which triangles are counted: each takes four bytes a place.
const MOST_PARTS: usize = 8;

impl EdgesByPlace {
    /// Counting sort. Each part of the triangles has cursors of its own, so that they go on side by side
    /// and still keep the order.
    pub fn new(corners: &[[u32; 3]], places: usize) -> Self {
        let parts = rayon::current_num_threads().min(MOST_PARTS);
        let size = corners.len().div_ceil(parts).max(1);
        let mut cursors: Vec<Vec<u32>> = (corners.par_chunks(size))
            .map(|part| {
                let mut counts = vec![0; places];
                each_use(part, 0, |lower, _| counts[lower as usize] += 1);
                counts
            })
            .collect();
        let mut total = 0;
        let mut ends = Vec::with_capacity(places);
        for place in 0..places {
            for cursors in &mut cursors {
                total += std::mem::replace(&mut cursors[place], total);
            }
            ends.push(total);
        }
        let blank = |_| (AtomicU64::new(0), AtomicU32::new(0));
        let uses: Vec<_> = (0..total).into_par_iter().map(blank).collect();
        (corners.par_chunks(size).zip(&mut cursors).enumerate()).for_each(
            |(n, (part, cursors))| {
                each_use(part, n * size, |lower, edge_use| {
                    let cursor = &mut cursors[lower as usize];
                    let (packed, opposite) = edge_use.pack();
                    uses[*cursor as usize].0.store(packed, Relaxed);
                    uses[*cursor as usize].1.store(opposite, Relaxed);
                    *cursor += 1;
                });
            },
        );
        Self { ends, uses }
    }

    /// How many places there are.
    pub fn places(&self) -> usize {
        self.ends.len()
    }

    /// The uses of the edges of which a place is the lower end, in the order of the triangles.
    pub fn of(&self, place: usize) -> impl Iterator<Item = EdgeUse> {
        let start = place.checked_sub(1).map_or(0, |before| self.ends[before]);
        let uses = &self.uses[start as usize..self.ends[place] as usize];
        let load = |(packed, opposite): &(AtomicU64, AtomicU32)| {
            EdgeUse::unpack((packed.load(Relaxed), opposite.load(Relaxed)))
        };
        uses.iter().map(load)
    }
}

/// Calls `visit` with the lower end and the use of every edge of some triangles, the first of which
/// has this number.
fn each_use(corners: &[[u32; 3]], first: usize, mut visit: impl FnMut(u32, EdgeUse)) {
    for (n, &corners) in corners.iter().enumerate() {
        if !is_collapsed(corners) {
            for k in 0..3 {
                let (lower, edge_use) = EdgeUse::new(first + n, corners, k);
                visit(lower, edge_use);
            }
        }
    }
}
