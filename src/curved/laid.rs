//! Clusters laid out for rays, kept by each thread for the next rays that come by: the patches of a cluster
//! take longer to lay out than to trace, and a picture's rays meet the same ones many times.

use std::cell::RefCell;

use crate::surface::{KeptPatch, PairHits, PatchBlock};

/// How many clusters a thread keeps, about 4 kB each: as many as its processor's own cache holds.
const SLOTS: usize = 128;
/// In place of a mesh's number where a slot is empty.
const NO_MESH: u64 = 0;

/// Clusters that were laid out, and room for hits on them.
pub(super) struct Laid {
    slots: Vec<Slot>,
    /// Unless it is in use.
    hits: Option<Box<PairHits>>,
}

/// A cluster.
#[derive(Clone)]
pub(super) struct Slot {
    mesh: u64,
    cluster: u32,
    /// The triangles that were laid out, or found to be none for a block, one bit each.
    seen: u32,
    pub block: PatchBlock,
}

thread_local! {
    static LAID: RefCell<Laid> = RefCell::new(Laid::new());
}

impl Laid {
    fn new() -> Self {
        let empty = Slot {
            mesh: NO_MESH,
            cluster: 0,
            seen: 0,
            block: PatchBlock::default(),
        };
        Self {
            slots: vec![empty; SLOTS],
            hits: None,
        }
    }

    /// Calls a function with a cluster of a mesh, with what the calling thread laid out of it before, and
    /// gives the hits. The function must not come here again; who reports the hits may, since a filter may
    /// trace rays.
    pub fn trace(
        mesh: u64,
        cluster: u32,
        call: impl FnOnce(&mut Slot, &mut PairHits),
    ) -> Box<PairHits> {
        LAID.with_borrow_mut(|laid| {
            let mut hits = laid.hits.take().unwrap_or_default();
            call(laid.cluster(mesh, cluster), &mut hits);
            hits
        })
    }

    /// Keeps the room that hits take for the next ones.
    pub fn keep(hits: Box<PairHits>) {
        LAID.with_borrow_mut(|laid| laid.hits = Some(hits));
    }

    fn cluster(&mut self, mesh: u64, cluster: u32) -> &mut Slot {
        // Neighbouring clusters have neighbouring numbers.
        let slot = &mut self.slots[cluster as usize % SLOTS];
        if (slot.mesh, slot.cluster) != (mesh, cluster) {
            (slot.mesh, slot.cluster) = (mesh, cluster);
            slot.seen = 0;
            slot.block.clear();
        }
        slot
    }
}

impl Slot {
    /// Of some triangles, one bit each, those that are laid out, if they were not before.
    pub fn lay<'a>(&mut self, which: u32, of: impl Fn(usize) -> KeptPatch<'a>) -> u32 {
        let new = which & !self.seen;
        if new != 0 {
            let fit = (0..u32::BITS as usize)
                .filter(|n| new & 1 << n != 0 && of(*n).fits_block())
                .fold(0, |fit, n| fit | 1 << n);
            self.block.lay(fit, of);
            self.seen |= new;
        }
        which & self.block.laid()
    }
}
