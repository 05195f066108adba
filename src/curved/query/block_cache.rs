//! A cache of unpacked clusters, one for each thread: unpacking the patches of a cluster takes longer than
//! tracing rays against them, and a picture's rays come to the same clusters many times.

use std::cell::RefCell;

use curvetri_method::{PairHits, PatchBlock};

/// How many clusters a thread caches, about 4 kB each: as many as the processor's own cache of a core holds.
const SLOTS: usize = 128;
/// In place of a mesh's id where a slot is empty.
const NO_MESH: u64 = 0;

/// A cluster: the mesh's id and the cluster's number.
type Key = (u64, u32);

/// Clusters whose patches are unpacked, and a buffer for hits on them.
pub(super) struct BlockCache {
    slots: Vec<Slot>,
    /// Unless it is in use.
    hits: Option<Box<PairHits>>,
}

/// A cached cluster.
#[derive(Clone)]
struct Slot {
    key: Key,
    block: PatchBlock,
}

thread_local! {
    static CACHE: RefCell<BlockCache> = RefCell::new(BlockCache::new());
}

impl BlockCache {
    fn new() -> Self {
        let empty = Slot {
            key: (NO_MESH, 0),
            block: PatchBlock::default(),
        };
        Self {
            slots: vec![empty; SLOTS],
            hits: None,
        }
    }

    /// Calls `trace` with a cluster, which `unpack` unpacks unless the calling thread has it, and returns the
    /// hits.
    ///
    /// Neither function may use the cache. Who reports the hits may, since a filter may trace rays.
    pub fn trace(
        key: Key,
        unpack: impl FnOnce(&mut PatchBlock),
        trace: impl FnOnce(&PatchBlock, &mut PairHits),
    ) -> Box<PairHits> {
        CACHE.with_borrow_mut(|cache| {
            let mut hits = cache.hits.take().unwrap_or_default();
            trace(cache.block(key, unpack), &mut hits);
            hits
        })
    }

    /// Whether the calling thread has a cluster of a mesh.
    pub fn contains(key: Key) -> bool {
        CACHE.with_borrow(|cache| cache.slots[slot_of(key.1)].key == key)
    }

    /// Returns the buffer of hits that have been reported, for the next ones.
    pub fn give_back(hits: Box<PairHits>) {
        CACHE.with_borrow_mut(|cache| cache.hits = Some(hits));
    }

    fn block(&mut self, key: Key, unpack: impl FnOnce(&mut PatchBlock)) -> &PatchBlock {
        let slot = &mut self.slots[slot_of(key.1)];
        if slot.key != key {
            slot.key = key;
            slot.block.clear();
            unpack(&mut slot.block);
        }
        &slot.block
    }
}

/// The slot of a cluster. Neighbouring clusters have neighbouring numbers.
fn slot_of(cluster: u32) -> usize {
    cluster as usize % SLOTS
}
