//! One hit on its way into a packet of any width, past the filters.

use super::packet::Valid;
use super::ray::SurfaceHit;
use super::sys::{CurvetriCall, CurvetriCandidate, LEVELS};
use super::table::Table;

/// How many four-byte fields a hit has at most. One without `instPrimID` lacks the last.
pub(super) const HIT_FIELDS: usize = 7 + 2 * LEVELS;

/// One lane of a hit packet, field by field, as bits.
pub(super) struct Record([u32; HIT_FIELDS]);

/// A hit packet of any width.
#[repr(C, align(64))]
struct Hits([u32; 16 * HIT_FIELDS]);

impl Record {
    /// # Safety
    /// `call` is that of a callback of this Embree, under way.
    pub(super) unsafe fn new(
        hit: &SurfaceHit,
        prim_id: u32,
        geom_id: u32,
        call: &CurvetriCall,
        embree: &Table,
    ) -> Self {
        let mut fields = [0; HIT_FIELDS];
        let [x, y, z] = hit.ng.to_array();
        fields[..5].copy_from_slice(&[x, y, z, hit.u, hit.v].map(f32::to_bits));
        fields[5] = prim_id;
        fields[6] = geom_id;
        // SAFETY: Embree passes a context to every callback, also where the query has none.
        let ids = unsafe { embree.instance_ids(call.context) };
        fields[7..].copy_from_slice(ids.as_flattened());
        Self(fields)
    }

    /// Writes the hit into a lane.
    ///
    /// # Safety
    /// `hits` is a hit packet of this Embree of `width` lanes, `lane` one of them.
    pub(super) unsafe fn write(&self, hits: *mut f32, width: usize, lane: usize, embree: &Table) {
        for (field, bits) in self.0[..embree.hit_fields()].iter().enumerate() {
            // SAFETY: as the caller promises.
            unsafe { *hits.cast::<u32>().add(field * width + lane) = *bits };
        }
    }

    /// Shows the hit to the filters; returns it as they left it unless one rejects it.
    ///
    /// # Safety
    /// `rays` is the call's ray packet of `width` lanes, `lane` one of them.
    pub(super) unsafe fn filtered(
        &self,
        rays: *mut f32,
        (width, lane): (usize, usize),
        call: &CurvetriCall,
        embree: &Table,
        filters: impl FnOnce(*const CurvetriCandidate),
    ) -> Option<Self> {
        debug_assert!(lane < width && width <= 16);
        let mut hits = Hits([0; 16 * HIT_FIELDS]);
        let mut valid = Valid::<16>::of(1 << lane);
        let packet = hits.0.as_mut_ptr();
        // SAFETY: the array has room for sixteen lanes.
        unsafe { self.write(packet.cast(), width, lane, embree) };
        let candidate = CurvetriCandidate {
            valid: valid.0.as_mut_ptr(),
            user: call.user,
            context: call.context,
            ray: rays.cast(),
            hit: packet.cast(),
            width: width as u32,
        };
        filters(&candidate);
        // SAFETY: read where the filters may have written, through the pointers they had.
        unsafe {
            if *candidate.valid.add(lane) == 0 {
                return None;
            }
            Some(Self(std::array::from_fn(|field| {
                *packet.add(field * width + lane)
            })))
        }
    }
}
