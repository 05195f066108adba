//! User geometry: surfaces that Rust code intersects.

use std::marker::PhantomData;
use std::ops::{Deref, DerefMut};

use super::bounds::Bounds;
use super::filter::{query_filter, read_ray};
use super::geometry::Callbacks;
use super::packet::{read_valid, write_valid};
use super::query::{Query, callback};
use super::ray::{Ray, SurfaceHit};
use super::record::Record;
use super::sys::{
    CurvetriBoundsCall, CurvetriCall, CurvetriCandidate, CurvetriFilterFunction, INVALID_ID, LEVELS,
};
use super::table::{Table, embree};

/// A surface made of numbered primitives that Rust code bounds and intersects.
///
/// Embree calls it from several threads at once. A panic in any of the functions resumes in the caller
/// of [`SceneBuilder::commit`](super::SceneBuilder::commit), [`Scene::intersect`](super::Scene::intersect)
/// or [`Scene::occluded`](super::Scene::occluded).
///
/// ```
/// use std::sync::Arc;
///
/// use curvetri_embree::*;
/// use glam::Vec3;
///
/// /// The square from 0 to 1 in the plane z = 0.
/// struct Square;
///
/// impl Square {
///     fn hit(&self, ray: &Ray) -> Option<SurfaceHit> {
///         let t = -ray.origin.z / ray.direction.z;
///         let (u, v) = (ray.at(t).x, ray.at(t).y);
///         let inside = (0.0..=1.0).contains(&u) && (0.0..=1.0).contains(&v);
///         inside.then_some(SurfaceHit { t, u, v, ng: Vec3::Z })
///     }
/// }
///
/// impl UserGeometry for Square {
///     fn primitives(&self) -> u32 {
///         1
///     }
///
///     fn bounds(&self, _: u32, _: u32) -> Bounds {
///         let padding = Vec3::splat(1e-6);
///         Bounds { lower: -padding, upper: Vec3::new(1.0, 1.0, 0.0) + padding }
///     }
///
///     fn intersect(&self, query: &mut IntersectQuery<'_>) {
///         for lane in query.lanes() {
///             if let Some(hit) = self.hit(&query.ray(lane)) {
///                 query.report(lane, hit);
///             }
///         }
///     }
///
///     fn occluded(&self, query: &mut OccludedQuery<'_>) {
///         for lane in query.lanes() {
///             if let Some(hit) = self.hit(&query.ray(lane)) {
///                 query.report(lane, hit);
///             }
///         }
///     }
/// }
///
/// let device = curvetri_embree_linked::device()?;
/// let mut builder = SceneBuilder::new(&device)?;
/// builder.attach(&Geometry::user(&device, Arc::new(Square))?.commit()?);
/// let scene = builder.commit()?;
/// let ray = Ray::new(Vec3::new(0.25, 0.5, 2.0), -Vec3::Z);
/// assert_eq!(scene.intersect1(&ray, &QueryOptions::default()).map(|hit| hit.t), Some(2.0));
/// # Ok::<(), curvetri_embree::Error>(())
/// ```
pub trait UserGeometry: Send + Sync {
    /// How many primitives there are. Asked once, when the geometry is made.
    fn primitives(&self) -> u32;

    /// How many time steps there are, 1 to 129, spread evenly over [0, 1]. Asked once.
    fn time_steps(&self) -> u32 {
        1
    }

    /// A box that holds the primitive at a time step. Embree intersects it with its ordinary (not
    /// robust) arithmetic, so it should be padded by some units in the last place of the coordinates.
    /// A primitive whose box is empty or not finite is never hit.
    fn bounds(&self, prim: u32, time_step: u32) -> Bounds;

    /// Finds the hits of the query's rays with its primitive, and
    /// [reports](IntersectQuery::report) each ray's nearest, or where that is rejected the next.
    fn intersect(&self, query: &mut IntersectQuery<'_>);

    /// Finds out which of the query's rays the primitive occludes, and
    /// [reports](OccludedQuery::report) a hit of each.
    fn occluded(&self, query: &mut OccludedQuery<'_>);
}

/// The rays of a query and the primitive to test them against.
///
/// A lane is valid if it holds a ray that is still looking for a hit and that sees the geometry
/// (Embree has compared their masks). Rays of other lanes may hold anything. In packets a valid ray
/// need not meet the primitive's box.
///
/// ```
/// use curvetri_embree::QueryRays;
///
/// /// The lanes whose rays may meet anything in front of a plane of constant z.
/// fn leads_up(rays: &QueryRays<'_>, z: f32) -> u32 {
///     let up = |lane: &usize| rays.org_z()[*lane] < z && rays.dir_z()[*lane] > 0.0;
///     rays.lanes().filter(up).fold(0, |lanes, lane| lanes | 1 << lane)
/// }
/// ```
pub struct QueryRays<'a> {
    embree: &'static Table,
    // Embree's own, never a copy
    call: *const CurvetriCall,
    rays: *mut f32,
    width: usize,
    valid: u32,
    prim_id: u32,
    geom_id: u32,
    filtered: Filtered,
    accepted: u32,
    packet: PhantomData<&'a mut f32>,
}

/// A query for the nearest hit.
///
/// ```
/// use curvetri_embree::{IntersectQuery, SurfaceHit};
///
/// /// Offers two hits of a ray: the second where filters reject the first.
/// fn report(query: &mut IntersectQuery<'_>, lane: usize, hits: [SurfaceHit; 2]) {
///     for hit in hits {
///         if query.report(lane, hit) {
///             break;
///         }
///     }
/// }
/// ```
pub struct IntersectQuery<'a>(QueryRays<'a>);

/// A query for any hit.
///
/// ```
/// use curvetri_embree::{OccludedQuery, SurfaceHit};
/// use glam::Vec3;
///
/// /// A primitive that no ray passes.
/// fn occlude(query: &mut OccludedQuery<'_>) {
///     for lane in query.lanes() {
///         let t = query.tnear()[lane];
///         query.report(lane, SurfaceHit { t, u: 0.0, v: 0.0, ng: Vec3::Z });
///     }
/// }
/// ```
pub struct OccludedQuery<'a>(QueryRays<'a>);

/// Whether hits need to be shown to filters.
#[derive(Clone, Copy)]
struct Filtered {
    any: bool,
    by_query: bool,
}

impl QueryRays<'_> {
    /// The primitive's number in its geometry, or what [`set_prim_id`](Self::set_prim_id) made it.
    pub fn prim_id(&self) -> u32 {
        self.prim_id
    }

    /// Gives the hits reported from now on this number: for a primitive of Embree's that stands for
    /// several of the geometry's own.
    pub fn set_prim_id(&mut self, prim_id: u32) {
        self.prim_id = prim_id;
    }

    /// Whether hits are shown to filters, which may reject them. Else of an occlusion's hit only `t` is looked
    /// at.
    pub fn has_filters(&self) -> bool {
        self.filtered.any
    }

    /// The geometry's number in its scene.
    pub fn geom_id(&self) -> u32 {
        self.geom_id
    }

    /// How many lanes there are: 1, 4, 8 or 16.
    pub fn width(&self) -> usize {
        self.width
    }

    /// The valid lanes, one bit a lane.
    pub fn valid(&self) -> u32 {
        self.valid
    }

    /// The valid lanes' numbers.
    pub fn lanes(&self) -> impl Iterator<Item = usize> + use<> {
        let mut left = self.valid;
        std::iter::from_fn(move || {
            let lane = left.trailing_zeros();
            left &= left.wrapping_sub(1);
            (lane < u32::BITS).then_some(lane as usize)
        })
    }

    /// A lane's ray, in the geometry's space. Its `tfar` is the nearest hit so far.
    ///
    /// # Panics
    /// If there is no such lane.
    pub fn ray(&self, lane: usize) -> Ray {
        assert!(lane < self.width);
        // SAFETY: the packet has `width` lanes and lives as long as `self`.
        unsafe { read_ray(self.rays, self.width, lane) }
    }

    /// The ray's n-th field in every lane.
    fn field(&self, field: usize) -> &[f32] {
        // SAFETY: a ray packet is twelve arrays of `width` four-byte numbers; the borrow of `self`
        // keeps `report`, which writes to them, away.
        unsafe { std::slice::from_raw_parts(self.rays.add(field * self.width), self.width) }
    }

    /// Origins' x, one a lane.
    pub fn org_x(&self) -> &[f32] {
        self.field(0)
    }

    /// Origins' y, one a lane.
    pub fn org_y(&self) -> &[f32] {
        self.field(1)
    }

    /// Origins' z, one a lane.
    pub fn org_z(&self) -> &[f32] {
        self.field(2)
    }

    /// Where the rays begin, one a lane.
    pub fn tnear(&self) -> &[f32] {
        self.field(3)
    }

    /// Directions' x, one a lane.
    pub fn dir_x(&self) -> &[f32] {
        self.field(4)
    }

    /// Directions' y, one a lane.
    pub fn dir_y(&self) -> &[f32] {
        self.field(5)
    }

    /// Directions' z, one a lane.
    pub fn dir_z(&self) -> &[f32] {
        self.field(6)
    }

    /// Times in [0, 1], one a lane.
    pub fn time(&self) -> &[f32] {
        self.field(7)
    }

    /// Where the rays end: the nearest hits so far, one a lane.
    pub fn tfar(&self) -> &[f32] {
        self.field(8)
    }

    /// Shortens the lane's ray to a hit and shows that to the filters, if there are any. Returns the hit to write if
    /// it counts; otherwise the ray is as before.
    ///
    /// # Panics
    /// If there is no such lane.
    fn offer(
        &mut self,
        lane: usize,
        hit: &SurfaceHit,
        filters: impl FnOnce(*const CurvetriCandidate),
    ) -> Option<Record> {
        let (tnear, tfar) = (self.tnear()[lane], self.tfar()[lane]);
        let on_ray = hit.t >= tnear && hit.t <= tfar && hit.t < f32::INFINITY;
        if self.valid & 1 << lane == 0 || !on_ray {
            return None;
        }
        // SAFETY: Embree's arguments live as long as `self`.
        let call = unsafe { &*self.call };
        // SAFETY: the call is that of a callback of this Embree.
        let record = unsafe { Record::new(hit, self.prim_id, self.geom_id, call, self.embree) };
        self.set_tfar(lane, hit.t);
        let accepted = if self.filtered.any {
            // SAFETY: the rays are the call's packet of `width` lanes, `lane` one of them.
            unsafe { record.filtered(self.rays, (self.width, lane), call, self.embree, filters) }
        } else {
            Some(record)
        };
        if accepted.is_some() {
            self.accepted |= 1 << lane;
        } else {
            self.set_tfar(lane, tfar);
        }
        accepted
    }

    /// The query's own filter, if it has one.
    fn query_filter(&self) -> CurvetriFilterFunction {
        self.filtered.by_query.then_some(query_filter as _)
    }

    fn set_tfar(&mut self, lane: usize, t: f32) {
        debug_assert!(lane < self.width);
        // SAFETY: tfar is the packet's ninth array of `width` numbers; `self` is borrowed mutably.
        unsafe { *self.rays.add(8 * self.width + lane) = t };
    }
}

impl<'a> Deref for IntersectQuery<'a> {
    type Target = QueryRays<'a>;

    fn deref(&self) -> &QueryRays<'a> {
        &self.0
    }
}

impl DerefMut for IntersectQuery<'_> {
    fn deref_mut(&mut self) -> &mut Self::Target {
        &mut self.0
    }
}

impl<'a> Deref for OccludedQuery<'a> {
    type Target = QueryRays<'a>;

    fn deref(&self) -> &QueryRays<'a> {
        &self.0
    }
}

impl DerefMut for OccludedQuery<'_> {
    fn deref_mut(&mut self) -> &mut Self::Target {
        &mut self.0
    }
}

impl IntersectQuery<'_> {
    /// Offers a hit of a lane's ray. Returns whether it counts; it does not where the lane is not
    /// valid, t is outside of the ray, or the geometry's or the query's filter rejects it, and the next
    /// hit along the ray should be offered then. An accepted hit shortens the ray to it.
    ///
    /// Of hits at the same t the one with the lesser numbers (of the instance, then of the geometry,
    /// then of the primitive) counts, in whichever order Embree comes by them.
    ///
    /// # Panics
    /// If there is no such lane.
    pub fn report(&mut self, lane: usize, hit: SurfaceHit) -> bool {
        if hit.t == self.tfar()[lane] && self.comes_after_its_hit(lane) {
            return false;
        }
        let (embree, call, query_filter) = (self.embree, self.call, self.query_filter());
        let filters = |candidate: *const CurvetriCandidate| {
            // SAFETY: `call` is Embree's own struct and the candidate is complete.
            unsafe { embree!(embree, filter_intersect(call, candidate, query_filter)) }
        };
        let Some(record) = self.0.offer(lane, &hit, filters) else {
            return false;
        };
        let width = self.width;
        // SAFETY: the hits of an intersect query lie behind the twelve fields of its rays, and have `width` lanes, of
        // which `lane` is one: `offer` checked.
        unsafe { record.write(self.rays.add(12 * width), width, lane, embree) };
        true
    }

    /// Whether the lane has a hit already, of a primitive with lesser numbers than this one.
    fn comes_after_its_hit(&self, lane: usize) -> bool {
        let width = self.width;
        assert!(lane < width);
        let field = |field: usize| {
            // SAFETY: the hits of an intersect query lie behind the twelve fields of its rays, and
            // have `width` lanes, of which `lane` is one.
            unsafe { *self.rays.cast::<u32>().add((12 + field) * width + lane) }
        };
        let (prim_id, geom_id) = (field(5), field(6));
        if geom_id == INVALID_ID {
            return false;
        }
        // SAFETY: Embree passes a context to every callback, also where the query has none.
        let [inst_id, _] = unsafe { self.embree.instance_ids((*self.call).context) };
        let old_inst_id: [u32; LEVELS] = std::array::from_fn(|level| field(7 + level));
        (old_inst_id, geom_id, prim_id) < (inst_id, self.geom_id, self.prim_id)
    }
}

impl OccludedQuery<'_> {
    /// Offers a hit of a lane's ray. Returns whether it counts, as in [`IntersectQuery::report`]; the
    /// ray is done then, and its lane no longer valid.
    ///
    /// # Panics
    /// If there is no such lane.
    pub fn report(&mut self, lane: usize, hit: SurfaceHit) -> bool {
        let (embree, call, query_filter) = (self.embree, self.call, self.query_filter());
        let filters = |candidate: *const CurvetriCandidate| {
            // SAFETY: `call` is Embree's own struct and the candidate is complete.
            unsafe { embree!(embree, filter_occluded(call, candidate, query_filter)) }
        };
        if self.0.offer(lane, &hit, filters).is_none() {
            return false;
        }
        self.set_tfar(lane, f32::NEG_INFINITY);
        self.valid &= !(1 << lane);
        true
    }
}

impl Filtered {
    fn new(callbacks: &Callbacks, query: Option<&Query<'_>>) -> Self {
        let by_query = query.is_some_and(|query| query.filter().is_some());
        // another program's query may bring filters that only Embree knows of
        Self {
            any: by_query || query.is_none() || callbacks.filtered(),
            by_query,
        }
    }
}

/// The bounds function of every user geometry.
pub(super) unsafe extern "C" fn bounds(call: *const CurvetriBoundsCall) {
    // SAFETY: Embree's arguments live for the call.
    let call = unsafe { &*call };
    // SAFETY: the callbacks live as long as the geometry.
    let callbacks = unsafe { &*call.user.cast::<Callbacks>() };
    let bounds = callbacks
        .build_panics
        .callback(|| callbacks.shape().bounds(call.prim_id, call.time_step))
        .unwrap_or(Bounds::EMPTY);
    // SAFETY: Embree passes where to write the box.
    unsafe { *call.bounds = bounds.to_embree() };
}

/// The intersect function of every user geometry.
pub(super) unsafe extern "C" fn intersect(call: *const CurvetriCall) {
    // SAFETY: as this function's caller promises.
    unsafe {
        answer(call, |shape, rays| {
            let mut query = IntersectQuery(rays);
            shape.intersect(&mut query);
            query.accepted
        })
    }
}

/// The occluded function of every user geometry.
pub(super) unsafe extern "C" fn occluded(call: *const CurvetriCall) {
    // SAFETY: as this function's caller promises.
    unsafe {
        answer(call, |shape, rays| {
            let mut query = OccludedQuery(rays);
            shape.occluded(&mut query);
            query.accepted
        })
    }
}

/// Runs a callback of either kind: asks for the lanes that a hit was found for, and says so to Embree.
///
/// # Safety
/// `call` is what Embree passes to a callback of a geometry of ours.
unsafe fn answer(
    call: *const CurvetriCall,
    ask: impl FnOnce(&dyn UserGeometry, QueryRays<'_>) -> u32,
) {
    // SAFETY: Embree's arguments live for the call.
    let args = unsafe { &*call };
    // SAFETY: the callbacks live as long as the geometry.
    let callbacks = unsafe { &*args.user.cast::<Callbacks>() };
    let (rays, width) = (args.rays.cast::<f32>(), args.width as usize);
    let accepted = callback(|query| {
        // SAFETY: the mask has `width` lanes and lives for the call.
        let valid = unsafe { read_valid(args.valid, width) };
        // SAFETY: the packet has `width` lanes and lives for the call.
        let valid = unsafe { callbacks.seen(rays, width, valid) };
        let rays = QueryRays {
            embree: callbacks.embree,
            call,
            rays,
            width,
            valid,
            prim_id: args.prim_id,
            geom_id: args.geom_id,
            filtered: Filtered::new(callbacks, query),
            accepted: 0,
            packet: PhantomData,
        };
        ask(callbacks.shape(), rays)
    });
    // Embree 4's contract: the callback says which lanes it found a hit for. Embree 3.13 does not look.
    // SAFETY: the mask has room for `width` lanes.
    unsafe { write_valid(args.valid, width, accepted.unwrap_or(0)) };
}
