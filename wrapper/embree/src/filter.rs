//! Filters: closures that decide which hits count.

use glam::Vec3;

use super::geometry::Callbacks;
use super::query::{Query, callback};
use super::ray::{Hit, Ray};
use super::sys::{CurvetriCandidate, INVALID_ID, LEVELS};
use super::table::Table;

/// Decides whether a hit counts. A rejected hit is as if the surface were not there.
///
/// ```
/// use curvetri_embree::{Candidate, Filter, QueryOptions};
///
/// let front: &Filter<'_> = &|candidate: &Candidate| {
///     candidate.hit.ng.dot(candidate.ray.direction) < 0.0
/// };
/// let options = QueryOptions::COHERENT.with_filter(front);
/// ```
pub type Filter<'a> = dyn Fn(&Candidate) -> bool + Send + Sync + 'a;

/// A hit to be accepted or rejected.
///
/// ```
/// use curvetri_embree::Candidate;
///
/// /// A hole in the middle of every triangle, as an alpha texture may cut it.
/// fn solid(candidate: &Candidate) -> bool {
///     let (u, v) = (candidate.hit.u, candidate.hit.v);
///     u.min(v).min(1.0 - u - v) < 0.2
/// }
/// ```
#[derive(Debug, Clone, Copy)]
pub struct Candidate {
    /// The ray, in the space of the geometry. Its `tfar` is the hit's t.
    pub ray: Ray,
    /// The hit.
    pub hit: Hit,
}

/// The intersect filter of a geometry.
pub(super) unsafe extern "C" fn intersect_filter(args: *const CurvetriCandidate) {
    // SAFETY: Embree passes arguments that live for the call, of a geometry of ours.
    unsafe { geometry_filter(args, |callbacks| callbacks.intersect_filter.as_deref()) }
}

/// The occluded filter of a geometry.
pub(super) unsafe extern "C" fn occluded_filter(args: *const CurvetriCandidate) {
    // SAFETY: Embree passes arguments that live for the call, of a geometry of ours.
    unsafe { geometry_filter(args, |callbacks| callbacks.occluded_filter.as_deref()) }
}

/// # Safety
/// `args` are Embree's, for a geometry whose user pointer is that of its [`Callbacks`].
unsafe fn geometry_filter(
    args: *const CurvetriCandidate,
    choose: impl Fn(&Callbacks) -> Option<&Filter<'static>>,
) {
    // SAFETY: the user pointer is that of the geometry's callbacks, which outlive the geometry.
    let callbacks = unsafe { &*(*args).user.cast::<Callbacks>() };
    if let Some(filter) = choose(callbacks) {
        // SAFETY: as the caller promises.
        unsafe { run(args, filter, callbacks.embree) };
    }
}

/// The filter of the query under way.
pub(super) unsafe extern "C" fn query_filter(args: *const CurvetriCandidate) {
    Query::with_current(|query| {
        if let Some(query) = query
            && let Some(filter) = query.filter()
        {
            // SAFETY: Embree passes arguments that live for the call.
            unsafe { run(args, filter, query.embree()) };
        }
    });
}

/// Asks the filter about every valid lane, and makes the rejected ones invalid.
///
/// # Safety
/// `args` are Embree's and live for the call.
unsafe fn run(args: *const CurvetriCandidate, filter: &Filter<'_>, embree: &Table) {
    // SAFETY: the struct lives for the call; the valid array holds N lanes.
    let (width, args) = unsafe { ((*args).width as usize, &*args) };
    for lane in 0..width {
        // SAFETY: the valid array holds N lanes.
        let valid = unsafe { &mut *args.valid.add(lane) };
        if *valid == 0 {
            continue;
        }
        // SAFETY: ray and hit are packets of N lanes, of the Embree that called.
        let candidate = unsafe {
            Candidate {
                ray: read_ray(args.ray.cast(), width, lane),
                hit: read_hit(args.ray.cast(), args.hit.cast(), (width, lane), embree),
            }
        };
        if callback(|_| filter(&candidate)) != Some(true) {
            *valid = 0;
        }
    }
}

/// Reads one lane of a ray packet of any width.
///
/// # Safety
/// `ray` is an Embree ray packet of `width` lanes, `lane` one of them.
pub(super) unsafe fn read_ray(ray: *const f32, width: usize, lane: usize) -> Ray {
    debug_assert!(lane < width);
    // SAFETY: the packet is twelve arrays of `width` four-byte fields.
    let float = |field: usize| unsafe { *ray.add(field * width + lane) };
    // SAFETY: as above.
    let integer = |field: usize| unsafe { *ray.cast::<u32>().add(field * width + lane) };
    Ray {
        origin: Vec3::new(float(0), float(1), float(2)),
        tnear: float(3),
        direction: Vec3::new(float(4), float(5), float(6)),
        time: float(7),
        tfar: float(8),
        mask: integer(9),
        id: integer(10),
        flags: integer(11),
    }
}

/// Reads one lane of a hit packet of any width, with t from the ray.
///
/// # Safety
/// `ray` and `hit` are packets of this Embree of `width` lanes, `lane` one of them.
unsafe fn read_hit(
    ray: *const f32,
    hit: *const f32,
    (width, lane): (usize, usize),
    embree: &Table,
) -> Hit {
    debug_assert!(lane < width);
    // SAFETY: the packet is seven arrays of `width` four-byte fields and those of the instances.
    let float = |field: usize| unsafe { *hit.add(field * width + lane) };
    // SAFETY: as above.
    let integer = |field: usize| unsafe { *hit.cast::<u32>().add(field * width + lane) };
    Hit {
        // SAFETY: tfar is the ray's ninth field.
        t: unsafe { *ray.add(8 * width + lane) },
        ng: Vec3::new(float(0), float(1), float(2)),
        u: float(3),
        v: float(4),
        prim_id: integer(5),
        geom_id: integer(6),
        inst_id: std::array::from_fn(|level| integer(7 + level)),
        inst_prim_id: if embree.has_inst_prim_id() {
            std::array::from_fn(|level| integer(7 + LEVELS + level))
        } else {
            [INVALID_ID; LEVELS]
        },
    }
}
