//! Which triangles use the sides at each place.

use std::sync::atomic::{AtomicU32, AtomicU64, Ordering::Relaxed};

use rayon::prelude::*;

/// One use of a side by a triangle. Ordered by the side's other end, then by the triangle.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Use {
    /// The higher of its places.
    pub higher: u32,
    /// Triangle and side in one.
    pub side: u32,
    /// Whether the triangle has it run from the lower place to the higher.
    pub rises: bool,
    /// The place of the triangle's third corner.
    pub opposite: u32,
}

impl Use {
    /// Of side `k` of a triangle with these places, with the lower of the side's own.
    fn new(triangle: usize, corners: [u32; 3], k: usize) -> (u32, Use) {
        let (from, to) = (corners[k], corners[(k + 1) % 3]);
        let of_side = Use {
            higher: from.max(to),
            side: (3 * triangle + k) as u32,
            rises: from < to,
            opposite: corners[(k + 2) % 3],
        };
        (from.min(to), of_side)
    }

    /// Sides are numbered below [`MAX_INDICES`](super::MAX_INDICES), 2^31, which leaves one bit.
    fn pack(self) -> (u64, u32) {
        let side = self.side << 1 | u32::from(self.rises);
        (
            u64::from(self.higher) << 32 | u64::from(side),
            self.opposite,
        )
    }

    fn unpack((packed, opposite): (u64, u32)) -> Self {
        Self {
            higher: (packed >> 32) as u32,
            side: packed as u32 >> 1,
            rises: packed & 1 != 0,
            opposite,
        }
    }
}

/// Whether two corners are in one place.
fn is_collapsed([a, b, c]: [u32; 3]) -> bool {
    a == b || b == c || c == a
}

/// The uses of all sides, except those of collapsed triangles, grouped by the lower of their places.
pub(super) struct SidesByPlace {
    /// Where each place's group ends.
    ends: Vec<u32>,
    /// [Packed](Use::pack).
    uses: Vec<(AtomicU64, AtomicU32)>,
}

/// Most parts in which triangles are counted: each takes four bytes a place.
const MOST_PARTS: usize = 8;

impl SidesByPlace {
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
                each_use(part, n * size, |lower, of_side| {
                    let cursor = &mut cursors[lower as usize];
                    let (packed, opposite) = of_side.pack();
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

    /// The uses of the sides of which a place is the lower end, in the order of the triangles.
    pub fn of(&self, place: usize) -> impl Iterator<Item = Use> {
        let start = place.checked_sub(1).map_or(0, |before| self.ends[before]);
        let uses = &self.uses[start as usize..self.ends[place] as usize];
        let load = |(packed, opposite): &(AtomicU64, AtomicU32)| {
            Use::unpack((packed.load(Relaxed), opposite.load(Relaxed)))
        };
        uses.iter().map(load)
    }
}

/// Tells the lower end and the use of every side of some triangles, the first of which has this number.
fn each_use(corners: &[[u32; 3]], first: usize, mut tell: impl FnMut(u32, Use)) {
    for (n, &corners) in corners.iter().enumerate() {
        if !is_collapsed(corners) {
            for k in 0..3 {
                let (lower, of_side) = Use::new(first + n, corners, k);
                tell(lower, of_side);
            }
        }
    }
}
