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

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::super::table::tests::table;
    use super::*;

    /// What a hit writes into the lane 2 of a packet of 4 rays, where it leaves 77 elsewhere.
    fn written(version: u32, context: &[u32]) -> [u32; 4 * HIT_FIELDS] {
        let embree = table(version);
        let call = CurvetriCall {
            valid: std::ptr::null_mut(),
            user: std::ptr::null_mut(),
            prim_id: 0,
            context: context.as_ptr().cast_mut().cast(),
            rays: std::ptr::null_mut(),
            width: 4,
            geom_id: 0,
        };
        let (t, u, v, ng) = (1.0, 0.25, 0.5, Vec3::new(1.0, 2.0, 3.0));
        let hit = SurfaceHit { t, u, v, ng };
        let mut packet = [77; 4 * HIT_FIELDS];
        // SAFETY: the context is laid out as this Embree's; the packet has room for four lanes of its hits.
        unsafe {
            Record::new(&hit, 8, 9, &call, &embree).write(
                packet.as_mut_ptr().cast(),
                4,
                2,
                &embree,
            );
        }
        packet
    }

    #[test]
    fn a_hit_is_written_field_by_field_and_no_further() {
        let bits = [1.0_f32, 2.0, 3.0, 0.25, 0.5].map(f32::to_bits);
        let [x, y, z, u, v] = bits;
        for (version, context, fields) in [
            (
                31305,
                &[0, 0, 0, 0, 5, 0][..],
                &[x, y, z, u, v, 8, 9, 5][..],
            ),
            (40303, &[5, 6], &[x, y, z, u, v, 8, 9, 5, 6]),
        ] {
            for (place, word) in written(version, context).into_iter().enumerate() {
                let expected = match (place / 4, place % 4) {
                    (field, 2) if field < fields.len() => fields[field],
                    _ => 77,
                };
                assert_eq!(word, expected, "{version}, {place}");
            }
        }
    }
}
