//! Scenes: geometries under one tree, to be traced.

use std::fmt;
use std::sync::Arc;

use super::bounds::Bounds;
use super::device::Device;
use super::error::{Error, attempt};
use super::filter::query_filter;
use super::geometry::{BuildQuality, Geometry};
use super::packet::{RayPacket, Traced, Valid, Width};
use super::query::{QueryOptions, run};
use super::ray::{Hit, LARGEST_COMPONENT, Ray};
use super::sys::{
    CurvetriQuery, CurvetriScene, RTC_SCENE_FLAG_COMPACT, RTC_SCENE_FLAG_DYNAMIC,
    RTC_SCENE_FLAG_NONE, RTC_SCENE_FLAG_ROBUST,
};
use super::table::{Table, embree};

/// The number of a geometry in its scene, as in [`Hit::geom_id`](super::Hit::geom_id).
///
/// ```
/// use curvetri_embree::{GeometryId, Hit};
///
/// fn is_of(hit: &Hit, geometry: GeometryId) -> bool {
///     hit.geom_id == geometry
/// }
/// ```
pub type GeometryId = u32;

/// A committed scene: immutable, and traced from any number of threads at once. Clones are cheap and
/// share it. It owns its geometries.
///
/// ```
/// use curvetri_embree::{Geometry, QueryOptions, Ray, SceneBuilder};
/// use glam::Vec3;
///
/// let device = curvetri_embree_linked::device()?;
/// let corners = [Vec3::ZERO, Vec3::X, Vec3::Y];
/// let mut builder = SceneBuilder::new(&device)?;
/// builder.attach(&Geometry::triangles(&device, &corners, &[[0, 1, 2]])?.commit()?);
/// let scene = builder.commit()?;
///
/// let down = Ray::new(Vec3::new(0.2, 0.3, 1.0), -Vec3::Z);
/// assert!(scene.occluded1(&down, &QueryOptions::default()));
/// assert!(!scene.occluded1(&down.between(0.0, 0.5), &QueryOptions::default()));
/// # Ok::<(), curvetri_embree::Error>(())
/// ```
#[derive(Clone)]
pub struct Scene(Arc<Shared>);

/// A scene in the making; it ends with [`commit`](Self::commit).
///
/// ```
/// use curvetri_embree::{Geometry, SceneBuilder};
/// use glam::{Affine3A, Vec3};
///
/// let device = curvetri_embree_linked::device()?;
/// let triangle = Geometry::triangles(&device, &[Vec3::ZERO, Vec3::X, Vec3::Y], &[[0, 1, 2]])?;
/// let mut builder = SceneBuilder::new(&device)?.robust(true);
/// builder.attach(&triangle.commit()?);
/// let scene = builder.commit()?;
///
/// let mut builder = SceneBuilder::new(&device)?;
/// for z in [0.0, 1.0, 2.0] {
///     let moved = Affine3A::from_translation(Vec3::new(0.0, 0.0, z));
///     builder.attach(&Geometry::instance(&device, &scene, moved)?.commit()?);
/// }
/// assert_eq!(builder.commit()?.bounds().upper, Vec3::new(1.0, 1.0, 2.0));
/// # Ok::<(), curvetri_embree::Error>(())
/// ```
pub struct SceneBuilder {
    shared: Shared,
    flags: u32,
    quality: BuildQuality,
    failed: Option<Error>,
}

struct Shared {
    handle: *mut CurvetriScene,
    geometries: Vec<Geometry>,
    bounds: Bounds,
    query_filters: bool,
    /// Levels of instances below.
    depth: usize,
    /// The largest component a ray may have so that no instance takes it out of Embree's range.
    reach: f32,
    /// The widest packets of coherent rays to ask Embree about occlusion.
    coherent_shadow_width: usize,
    device: Device,
}

// SAFETY: an RTCScene is reference counted, and once committed only read.
unsafe impl Send for Shared {}
// SAFETY: as above.
unsafe impl Sync for Shared {}

/// The table's `intersect` or `occluded`.
type QueryFunction = unsafe extern "C" fn(
    u32,
    *const i32,
    *mut CurvetriScene,
    *mut std::ffi::c_void,
    *const CurvetriQuery,
);

impl SceneBuilder {
    /// An empty scene.
    ///
    /// # Errors
    /// If Embree cannot make one.
    pub fn new(device: &Device) -> Result<Self, Error> {
        // SAFETY: the device is live.
        let handle = attempt("make a scene", || unsafe {
            embree!(device.embree(), new_scene(device.handle()))
        })?;
        let shared = Shared {
            handle,
            geometries: Vec::new(),
            bounds: Bounds::EMPTY,
            query_filters: false,
            depth: 0,
            reach: LARGEST_COMPONENT,
            coherent_shadow_width: 16,
            device: device.clone(),
        };
        let flags = RTC_SCENE_FLAG_NONE;
        Ok(Self {
            shared,
            flags,
            quality: BuildQuality::Medium,
            failed: None,
        })
    }

    /// Triangles without gaps at their sides, a little slower. User geometry is not affected.
    pub fn robust(self, on: bool) -> Self {
        self.flag(RTC_SCENE_FLAG_ROBUST, on)
    }

    /// A smaller tree, a little slower.
    pub fn compact(self, on: bool) -> Self {
        self.flag(RTC_SCENE_FLAG_COMPACT, on)
    }

    /// A tree that is quicker to build and slower to trace, for scenes made anew every frame.
    pub fn dynamic(self, on: bool) -> Self {
        self.flag(RTC_SCENE_FLAG_DYNAMIC, on)
    }

    /// Allows queries to bring a [filter](QueryOptions::filter), which costs triangles a little.
    pub fn query_filters(mut self, on: bool) -> Self {
        self.shared.query_filters = on;
        let flag = self.shared.embree().functions().query_filter_scene_flag;
        self.flag(flag, on)
    }

    fn flag(mut self, flag: u32, on: bool) -> Self {
        self.flags = if on {
            self.flags | flag
        } else {
            self.flags & !flag
        };
        self
    }

    /// How much work goes into the tree.
    pub fn build_quality(mut self, quality: BuildQuality) -> Self {
        self.quality = quality;
        self
    }

    /// Adds a geometry and returns its number: 0, 1, 2, ... in the order they are attached. One that
    /// Embree refuses is an error of [`commit`](Self::commit).
    pub fn attach(&mut self, geometry: &Geometry) -> GeometryId {
        let id = u32::try_from(self.shared.geometries.len()).unwrap_or(u32::MAX);
        self.shared.geometries.push(geometry.clone());
        if !geometry.device().is(&self.shared.device) {
            self.failed.get_or_insert(Error::OtherDevice("geometry"));
            return id;
        }
        let (scene, handle) = (self.shared.handle, geometry.handle());
        // SAFETY: both are live and of the same device.
        let attached = attempt("attach a geometry", || unsafe {
            embree!(self.shared.embree(), attach_geometry(scene, handle))
        });
        match attached {
            Ok(number) => debug_assert_eq!(number, id),
            Err(error) => {
                self.failed.get_or_insert(error);
            }
        }
        id
    }

    /// Builds the tree, on all threads of the device.
    ///
    /// # Errors
    /// If a geometry could not be attached, or there is not enough memory.
    ///
    /// # Panics
    /// With the panic of a geometry's [`bounds`](super::UserGeometry::bounds), if there is one.
    pub fn commit(self) -> Result<Scene, Error> {
        if let Some(error) = self.failed {
            return Err(error);
        }
        let mut shared = self.shared;
        let (embree, handle) = (shared.embree(), shared.handle);
        if shared.query_filters && !shared.instanced().all(|scene| scene.0.query_filters) {
            return Err(Error::QueryFilters);
        }
        shared.depth = shared
            .instanced()
            .map(|scene| scene.depth() + 1)
            .max()
            .unwrap_or(0);
        shared.reach = shared
            .geometries
            .iter()
            .map(Geometry::reach)
            .fold(LARGEST_COMPONENT, f32::min);
        let before: Vec<u64> = shared
            .geometries
            .iter()
            .map(|geometry| geometry.build_panics().count())
            .collect();
        // Debian 12's 3.13.5 was miscompiled there: on processors with AVX-512, rtcOccluded16 of
        // coherent rays may never return from instances, nor from compact robust triangles.
        let compact = self.flags & RTC_SCENE_FLAG_COMPACT != 0;
        if shared.device.version().major == 3 && (shared.depth > 0 || compact) {
            shared.coherent_shadow_width = 8;
        }
        // SAFETY: the handle is a live scene that nobody else has.
        let built = attempt("commit the scene", || unsafe {
            embree!(embree, set_scene_flags(handle, self.flags));
            embree!(
                embree,
                set_scene_build_quality(handle, self.quality.to_embree())
            );
            embree!(embree, commit_scene(handle));
        });
        for (geometry, before) in shared.geometries.iter().zip(before) {
            geometry.build_panics().resume(before);
        }
        built?;
        let mut bounds = Bounds::EMPTY.to_embree();
        // SAFETY: the scene is committed.
        attempt("bound the scene", || unsafe {
            embree!(embree, get_scene_bounds(handle, &mut bounds))
        })?;
        shared.bounds = Bounds::from_embree(&bounds);
        Ok(Scene(Arc::new(shared)))
    }
}

impl Scene {
    /// The box around all geometries, at all times.
    pub fn bounds(&self) -> Bounds {
        self.0.bounds
    }

    /// The device it was made with.
    pub fn device(&self) -> &Device {
        &self.0.device
    }

    /// The largest component of a ray's origin or direction that can be traced here: a ray with a
    /// larger one misses. [`LARGEST_COMPONENT`], or less where the scene has instances whose transform
    /// makes rays longer.
    pub fn reach(&self) -> f32 {
        self.0.reach
    }

    pub(super) fn depth(&self) -> usize {
        self.0.depth
    }

    pub(super) fn handle(&self) -> *mut CurvetriScene {
        self.0.handle
    }

    /// The geometry of a number.
    pub fn geometry(&self, id: GeometryId) -> Option<&Geometry> {
        self.0.geometries.get(id as usize)
    }

    /// Finds the nearest hit of every ray in a packet: an active lane's `tfar` is shortened to its
    /// hit, and [`RayPacket::hit`] has it. A hit that the packet brings along, from another scene,
    /// stays where this one has none nearer.
    ///
    /// A ray that is not [traceable](super::Ray::is_traceable) misses.
    ///
    /// # Panics
    /// With the panic of a callback, if there is one; the packet's hits are undefined then. If the
    /// options have a filter and the scene was not made for
    /// [query filters](SceneBuilder::query_filters).
    pub fn intersect<const N: usize>(&self, packet: &mut RayPacket<N>, options: &QueryOptions<'_>)
    where
        Width<N>: Traced,
    {
        self.trace(
            packet,
            options,
            self.0.embree().functions().intersect,
            self.0.device.native_width(),
        );
    }

    /// Finds out which rays of a packet hit anything; returns their lanes, one bit a lane. The `tfar`
    /// of those is -infinity after it.
    ///
    /// A ray that is not [traceable](super::Ray::is_traceable) hits nothing.
    ///
    /// # Panics
    /// As [`intersect`](Self::intersect).
    pub fn occluded<const N: usize>(
        &self,
        packet: &mut RayPacket<N>,
        options: &QueryOptions<'_>,
    ) -> u32
    where
        Width<N>: Traced,
    {
        let native = self.0.device.native_width();
        let width = if options.coherent {
            native.min(self.0.coherent_shadow_width)
        } else {
            native
        };
        let traced = self.trace(packet, options, self.0.embree().functions().occluded, width);
        (0..N)
            .filter(|&lane| packet.rays.tfar[lane] == f32::NEG_INFINITY)
            .fold(0, |occluded, lane| occluded | 1 << lane)
            & traced
    }

    /// The nearest hit of one ray, as [`intersect`](Self::intersect).
    ///
    /// # Panics
    /// As [`intersect`](Self::intersect).
    pub fn intersect1(&self, ray: &Ray, options: &QueryOptions<'_>) -> Option<Hit> {
        let mut packet = RayPacket::<1>::from_rays([ray]);
        self.intersect(&mut packet, options);
        packet.hit(0)
    }

    /// Whether one ray hits anything, as [`occluded`](Self::occluded).
    ///
    /// # Panics
    /// As [`intersect`](Self::intersect).
    pub fn occluded1(&self, ray: &Ray, options: &QueryOptions<'_>) -> bool {
        self.occluded(&mut RayPacket::<1>::from_rays([ray]), options) != 0
    }

    /// Runs a query on the lanes that can be traced, in packets of at most `widest` rays, and returns
    /// those.
    fn trace<const N: usize>(
        &self,
        packet: &mut RayPacket<N>,
        options: &QueryOptions<'_>,
        function: Option<QueryFunction>,
        widest: usize,
    ) -> u32
    where
        Width<N>: Traced,
    {
        assert!(
            options.filter.is_none() || self.0.query_filters,
            "a query filter needs a scene made with SceneBuilder::query_filters"
        );
        let lanes = packet.traceable(self.0.reach);
        if lanes == 0 {
            return 0;
        }
        let function = function.expect("a table has every function");
        let query = CurvetriQuery {
            coherent: u32::from(options.coherent && !packet.leads_hardly_back()),
            filter: options.filter.map(|_| query_filter as _),
        };
        // Embree's packets miss what lies at the end of a ray without length, its single rays do not.
        let points = packet.points() & lanes;
        let longer = lanes & !points;
        run(self.0.embree(), options.filter, || {
            self.call_in_parts::<N, 1>(packet, points, &query, function);
            match widest {
                _ if longer == 0 => (),
                widest if N <= widest => self.call(packet, longer, &query, function),
                8 => self.call_in_parts::<N, 8>(packet, longer, &query, function),
                4 => self.call_in_parts::<N, 4>(packet, longer, &query, function),
                _ => self.call_in_parts::<N, 1>(packet, longer, &query, function),
            }
        });
        lanes
    }

    /// Traces a packet that is wider than the processor's, which Embree does not do well: 3.13 traces
    /// lanes that are not valid and may never come back from instances, 4.3 goes ray by ray and writes
    /// hits behind the rays of occlusion queries.
    fn call_in_parts<const N: usize, const M: usize>(
        &self,
        packet: &mut RayPacket<N>,
        lanes: u32,
        query: &CurvetriQuery,
        function: QueryFunction,
    ) {
        if lanes == 0 {
            return;
        }
        for first in (0..N).step_by(M) {
            let mut part = packet.part::<M>(first, lanes);
            if part.active() != 0 {
                let lanes = part.active();
                self.call(&mut part, lanes, query, function);
                packet.put_part(first, &part);
            }
        }
    }

    fn call<const N: usize>(
        &self,
        packet: &mut RayPacket<N>,
        lanes: u32,
        query: &CurvetriQuery,
        function: QueryFunction,
    ) {
        let valid = Valid::<N>::of(lanes);
        let (mask, pointer) = (valid.0.as_ptr(), std::ptr::from_mut(packet).cast());
        // SAFETY: the scene is committed; the packet and the mask are of width N, in Embree's layout,
        // and aligned to 64 bytes; every traced ray is one that Embree computes with.
        unsafe { function(N as u32, mask, self.0.handle, pointer, query) }
    }
}

impl fmt::Debug for Scene {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter
            .debug_struct("Scene")
            .field("geometries", &self.0.geometries)
            .field("bounds", &self.0.bounds)
            .finish_non_exhaustive()
    }
}

impl Shared {
    fn embree(&self) -> &'static Table {
        self.device.embree()
    }

    fn instanced(&self) -> impl Iterator<Item = &Scene> {
        self.geometries.iter().filter_map(Geometry::instanced_scene)
    }
}

impl Drop for Shared {
    fn drop(&mut self) {
        // SAFETY: the handle is live and not used after this. An instance of the scene holds a clone
        // of this, so Embree's scene ends here, before its geometries.
        unsafe { embree!(self.embree(), release_scene(self.handle)) };
    }
}
