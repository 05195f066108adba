//! One hit on its way into a packet of any width, past the filters.

use std::ffi::c_void;

use super::packet::Valid;
use super::ray::SurfaceHit;
use super::sys::{self, LEVELS};

/// How many four-byte fields a hit has.
pub(super) const HIT_FIELDS: usize = if cfg!(inst_prim_id) {
    7 + 2 * LEVELS
} else {
    7 + LEVELS
};

#[cfg(embree3)]
type Context = sys::RTCIntersectContext;
#[cfg(embree4)]
type Context = sys::RTCRayQueryContext;

/// What both kinds of callbacks are passed beside their rays.
#[derive(Clone, Copy)]
pub(super) struct Call {
    pub(super) context: *mut Context,
    pub(super) user: *mut c_void,
}

/// One lane of a hit packet, field by field, as bits.
pub(super) struct Record([u32; HIT_FIELDS]);

/// A hit packet of any width.
#[repr(C, align(64))]
struct Hits([u32; 16 * HIT_FIELDS]);

impl Record {
    /// # Safety
    /// `call` is that of a callback under way.
    pub(super) unsafe fn new(hit: &SurfaceHit, prim_id: u32, geom_id: u32, call: Call) -> Self {
        let mut fields = [0; HIT_FIELDS];
        let [x, y, z] = hit.ng.to_array();
        fields[..5].copy_from_slice(&[x, y, z, hit.u, hit.v].map(f32::to_bits));
        fields[5] = prim_id;
        fields[6] = geom_id;
        // SAFETY: Embree passes a context to every callback, also where the query has none.
        let context = unsafe { &*call.context };
        fields[7..7 + LEVELS].copy_from_slice(&context.instID);
        #[cfg(inst_prim_id)]
        fields[7 + LEVELS..].copy_from_slice(&context.instPrimID);
        Self(fields)
    }

    /// Writes the hit into a lane.
    ///
    /// # Safety
    /// `hits` is a hit packet of `width` lanes, `lane` one of them.
    pub(super) unsafe fn write(&self, hits: *mut f32, width: usize, lane: usize) {
        for (field, bits) in self.0.iter().enumerate() {
            // SAFETY: as the caller promises.
            unsafe { *hits.cast::<u32>().add(field * width + lane) = *bits };
        }
    }

    /// Shows the hit to the filters; returns it as they left it unless one rejects it.
    ///
    /// # Safety
    /// `rays` is a ray packet of `width` lanes, `lane` one of them, and the call's.
    pub(super) unsafe fn filtered(
        &self,
        rays: *mut f32,
        width: usize,
        lane: usize,
        call: Call,
        filters: impl FnOnce(*const sys::RTCFilterFunctionNArguments),
    ) -> Option<Self> {
        debug_assert!(lane < width && width <= 16);
        let mut hits = Hits([0; 16 * HIT_FIELDS]);
        let mut valid = Valid::<16>::of(1 << lane);
        let packet = hits.0.as_mut_ptr();
        // SAFETY: the array has room for sixteen lanes.
        unsafe { self.write(packet.cast(), width, lane) };
        let candidate = sys::RTCFilterFunctionNArguments {
            valid: valid.0.as_mut_ptr(),
            geometryUserPtr: call.user,
            context: call.context,
            ray: rays.cast(),
            hit: packet.cast(),
            N: width as u32,
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
