//! Clusters laid out for rays, kept by each thread for the next rays that come by: the patches of a cluster
//! take longer to lay out than to trace, and a picture's rays meet the same ones many times.

use std::cell::RefCell;

use crate::method::{PairHits, PatchBlock};

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
struct Slot {
    mesh: u64,
    cluster: u32,
    block: PatchBlock,
}

impl Slot {
    fn holds(&self, mesh: u64, cluster: u32) -> bool {
        (self.mesh, self.cluster) == (mesh, cluster)
    }
}

/// The slot of a cluster: neighbouring ones have neighbouring numbers.
fn place(cluster: u32) -> usize {
    cluster as usize % SLOTS
}

thread_local! {
    static LAID: RefCell<Laid> = RefCell::new(Laid::new());
}

impl Laid {
    fn new() -> Self {
        let empty = Slot {
            mesh: NO_MESH,
            cluster: 0,
            block: PatchBlock::default(),
        };
        Self {
            slots: vec![empty; SLOTS],
            hits: None,
        }
    }

    /// Calls a function with a cluster of a mesh, which another lays out unless the calling thread did so
    /// before, and gives the hits. Neither must come here again; who reports the hits may, since a filter
    /// may trace rays.
    pub fn trace(
        mesh: u64,
        cluster: u32,
        lay: impl FnOnce(&mut PatchBlock),
        call: impl FnOnce(&PatchBlock, &mut PairHits),
    ) -> Box<PairHits> {
        LAID.with_borrow_mut(|laid| {
            let mut hits = laid.hits.take().unwrap_or_default();
            call(laid.cluster(mesh, cluster, lay), &mut hits);
            hits
        })
    }

    /// Whether the calling thread has a cluster of a mesh laid out.
    pub fn has(mesh: u64, cluster: u32) -> bool {
        LAID.with_borrow(|laid| laid.slots[place(cluster)].holds(mesh, cluster))
    }

    /// Keeps the room that hits take for the next ones.
    pub fn keep(hits: Box<PairHits>) {
        LAID.with_borrow_mut(|laid| laid.hits = Some(hits));
    }

    fn cluster(
        &mut self,
        mesh: u64,
        cluster: u32,
        lay: impl FnOnce(&mut PatchBlock),
    ) -> &PatchBlock {
        let slot = &mut self.slots[place(cluster)];
        if !slot.holds(mesh, cluster) {
            (slot.mesh, slot.cluster) = (mesh, cluster);
            slot.block.clear();
            lay(&mut slot.block);
        }
        &slot.block
    }
}
