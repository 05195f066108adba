//! Geometries: what a scene is made of.

use std::ffi::c_void;
use std::fmt;
use std::sync::Arc;

use super::device::Device;
use super::error::{Error, attempt};
use super::filter::{self, Filter};
use super::query::BuildPanics;
use super::ray::LARGEST_COMPONENT;
use super::scene::Scene;
use super::sys::{
    CurvetriGeometry, RTC_BUILD_QUALITY_HIGH, RTC_BUILD_QUALITY_LOW, RTC_BUILD_QUALITY_MEDIUM,
    RTC_GEOMETRY_TYPE_USER, TIME_STEPS,
};
use super::table::{Table, embree};
use super::user::{self, UserGeometry};

/// A committed geometry, to be attached to scenes. Clones are cheap and share it.
///
/// ```
/// use curvetri_embree::{Geometry, SceneBuilder};
/// use glam::Vec3;
///
/// let device = curvetri_embree_linked::device()?;
/// let triangle = Geometry::triangles(&device, &[Vec3::ZERO, Vec3::X, Vec3::Y], &[[0, 1, 2]])?.commit()?;
/// let mut builder = SceneBuilder::new(&device)?;
/// let [first, second] = [builder.attach(&triangle), builder.attach(&triangle)];
/// assert_eq!((first, second), (0, 1));
/// # Ok::<(), curvetri_embree::Error>(())
/// ```
#[derive(Clone)]
pub struct Geometry(Arc<Shared>);

/// A geometry in the making; it ends with [`commit`](Self::commit).
///
/// ```
/// use curvetri_embree::{BuildQuality, Geometry};
/// use glam::Vec3;
///
/// let device = curvetri_embree_linked::device()?;
/// let geometry = Geometry::triangles(&device, &[Vec3::ZERO, Vec3::X, Vec3::Y], &[[0, 1, 2]])?
///     .mask(0b01)
///     .build_quality(BuildQuality::High)
///     .intersect_filter(|candidate| candidate.hit.u < 0.5)
///     .commit()?;
/// # Ok::<(), curvetri_embree::Error>(())
/// ```
pub struct GeometryBuilder {
    shared: Shared,
    quality: BuildQuality,
    /// What Embree refused so far: an error of [`commit`](Self::commit).
    refused: Option<Error>,
}

pub(super) struct Shared {
    handle: *mut CurvetriGeometry,
    // in an allocation of its own: it is the geometry's user pointer
    callbacks: Box<Callbacks>,
    instanced: Option<Instanced>,
    device: Device,
}

/// The scene of an instance.
struct Instanced {
    scene: Scene,
    /// The largest component of a ray that the transform keeps within what Embree computes with.
    reach: f32,
}

// SAFETY: an RTCGeometry is reference counted; once committed it is not changed any more, and all that
// its callbacks reach is `Send + Sync`.
unsafe impl Send for Shared {}
// SAFETY: as above.
unsafe impl Sync for Shared {}

/// What a geometry's callbacks need, behind its user pointer.
pub(super) struct Callbacks {
    pub(super) embree: &'static Table,
    shape: Option<Arc<dyn UserGeometry>>,
    pub(super) intersect_filter: Option<Box<Filter<'static>>>,
    pub(super) occluded_filter: Option<Box<Filter<'static>>>,
    /// Panics of the bounds callback.
    pub(super) build_panics: BuildPanics,
    /// To be compared with the rays' here, if Embree does not do it.
    mask: Option<u32>,
}

/// How much work goes into a tree.
///
/// ```
/// use curvetri_embree::{BuildQuality, SceneBuilder};
///
/// let device = curvetri_embree_linked::device()?;
/// let preview = SceneBuilder::new(&device)?.build_quality(BuildQuality::Low).commit()?;
/// # Ok::<(), curvetri_embree::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum BuildQuality {
    /// Fast to build, slower to trace.
    Low,
    /// Embree's default.
    #[default]
    Medium,
    /// Slower to build, faster to trace; splits primitives.
    High,
}

impl BuildQuality {
    pub(super) fn to_embree(self) -> u32 {
        match self {
            Self::Low => RTC_BUILD_QUALITY_LOW,
            Self::Medium => RTC_BUILD_QUALITY_MEDIUM,
            Self::High => RTC_BUILD_QUALITY_HIGH,
        }
    }
}

impl Geometry {
    /// A geometry whose primitives Rust code bounds and intersects.
    ///
    /// # Errors
    /// If its number of time steps is not 1 to 129, or Embree cannot make it.
    pub fn user(device: &Device, shape: Arc<dyn UserGeometry>) -> Result<GeometryBuilder, Error> {
        let (primitives, time_steps) = (shape.primitives(), shape.time_steps());
        if !(1..=TIME_STEPS).contains(&time_steps) {
            return Err(Error::TimeSteps(time_steps));
        }
        let builder = GeometryBuilder::new(device, RTC_GEOMETRY_TYPE_USER, Some(shape))?;
        let (embree, handle) = (device.embree(), builder.shared.handle);
        // SAFETY: the handle is a live user geometry; the callbacks behind the user pointer outlive it.
        attempt("make a user geometry", || unsafe {
            embree!(embree, set_geometry_primitive_count(handle, primitives));
            embree!(embree, set_geometry_time_step_count(handle, time_steps));
            embree!(
                embree,
                set_geometry_bounds_function(handle, Some(user::bounds))
            );
            embree!(
                embree,
                set_geometry_intersect_function(handle, Some(user::intersect))
            );
            embree!(
                embree,
                set_geometry_occluded_function(handle, Some(user::occluded))
            );
        })?;
        Ok(builder)
    }

    pub(super) fn handle(&self) -> *mut CurvetriGeometry {
        self.0.handle
    }

    /// The device it was made with.
    pub fn device(&self) -> &Device {
        &self.0.device
    }

    /// The scene it is an instance of.
    pub fn instanced_scene(&self) -> Option<&Scene> {
        self.0.instanced.as_ref().map(|instanced| &instanced.scene)
    }

    /// The largest component that a ray of a scene with this geometry may have.
    pub(super) fn reach(&self) -> f32 {
        self.0
            .instanced
            .as_ref()
            .map_or(LARGEST_COMPONENT, |instanced| instanced.reach)
    }

    pub(super) fn build_panics(&self) -> &BuildPanics {
        &self.0.callbacks.build_panics
    }
}

impl fmt::Debug for Geometry {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let kind = match (&self.0.callbacks.shape, &self.0.instanced) {
            (Some(_), _) => "user",
            (None, Some(_)) => "instance",
            (None, None) => "mesh",
        };
        write!(formatter, "Geometry({kind})")
    }
}

impl GeometryBuilder {
    pub(super) fn new(
        device: &Device,
        kind: u32,
        shape: Option<Arc<dyn UserGeometry>>,
    ) -> Result<Self, Error> {
        // SAFETY: the device is live.
        let handle = attempt("make a geometry", || unsafe {
            embree!(device.embree(), new_geometry(device.handle(), kind))
        })?;
        let callbacks = Callbacks {
            embree: device.embree(),
            shape,
            intersect_filter: None,
            occluded_filter: None,
            build_panics: BuildPanics::default(),
            mask: None,
        };
        let callbacks = Box::new(callbacks);
        let shared = Shared {
            handle,
            callbacks,
            instanced: None,
            device: device.clone(),
        };
        // SAFETY: the handle is live; the callbacks outlive it.
        unsafe {
            embree!(
                device.embree(),
                set_geometry_user_data(handle, shared.user_pointer())
            )
        };
        // the versions' defaults differ
        Ok(Self {
            shared,
            quality: BuildQuality::Medium,
            refused: None,
        }
        .mask(!0))
    }

    /// An instance whose scene and transform are still to be given to Embree.
    pub(super) fn of_instance(
        device: &Device,
        kind: u32,
        scene: Scene,
        reach: f32,
    ) -> Result<Self, Error> {
        let mut builder = Self::new(device, kind, None)?;
        builder.shared.instanced = Some(Instanced { scene, reach });
        Ok(builder)
    }

    pub(super) fn handle(&self) -> *mut CurvetriGeometry {
        self.shared.handle
    }

    /// The mask that a ray's must have a bit in common with to see this geometry; all bits if never
    /// set, in every version of Embree.
    pub fn mask(mut self, mask: u32) -> Self {
        let (embree, handle) = (self.shared.embree(), self.shared.handle);
        // SAFETY: the handle is a live geometry.
        self.set("set a geometry's mask", || unsafe {
            embree!(embree, set_geometry_mask(handle, mask))
        });
        self.shared.callbacks.mask = (!self.shared.device.tests_ray_masks()).then_some(mask);
        self
    }

    /// How much work goes into its tree.
    pub fn build_quality(mut self, quality: BuildQuality) -> Self {
        self.quality = quality;
        self
    }

    /// A filter for the hits of [`Scene::intersect`]. It may be called from several threads at once,
    /// and several times for one hit.
    pub fn intersect_filter(
        mut self,
        filter: impl Fn(&filter::Candidate) -> bool + Send + Sync + 'static,
    ) -> Self {
        self.shared.callbacks.intersect_filter = Some(Box::new(filter));
        let (embree, handle) = (self.shared.embree(), self.shared.handle);
        // SAFETY: the handle is a live geometry, whose user pointer is that of its callbacks.
        self.set("set a geometry's filter", || unsafe {
            embree!(
                embree,
                set_geometry_intersect_filter(handle, Some(filter::intersect_filter))
            )
        });
        self
    }

    /// A filter for the hits of [`Scene::occluded`], as [`intersect_filter`](Self::intersect_filter).
    pub fn occluded_filter(
        mut self,
        filter: impl Fn(&filter::Candidate) -> bool + Send + Sync + 'static,
    ) -> Self {
        self.shared.callbacks.occluded_filter = Some(Box::new(filter));
        let (embree, handle) = (self.shared.embree(), self.shared.handle);
        // SAFETY: the handle is a live geometry, whose user pointer is that of its callbacks.
        self.set("set a geometry's filter", || unsafe {
            embree!(
                embree,
                set_geometry_occluded_filter(handle, Some(filter::occluded_filter))
            )
        });
        self
    }

    /// Runs calls to Embree, whose first error is one of [`commit`](Self::commit).
    fn set(&mut self, doing: &'static str, calls: impl FnOnce()) {
        if let Err(error) = attempt(doing, calls) {
            self.refused.get_or_insert(error);
        }
    }

    /// The geometry, not to be changed any more.
    ///
    /// # Errors
    /// If Embree refuses it, or one of its settings.
    pub fn commit(self) -> Result<Geometry, Error> {
        if let Some(error) = self.refused {
            return Err(error);
        }
        let (embree, handle) = (self.shared.embree(), self.shared.handle);
        // SAFETY: the handle is a live geometry.
        attempt("commit a geometry", || unsafe {
            embree!(
                embree,
                set_geometry_build_quality(handle, self.quality.to_embree())
            );
            embree!(embree, commit_geometry(handle));
        })?;
        Ok(Geometry(Arc::new(self.shared)))
    }

    /// Copies items into a buffer that Embree allocates, with the padding its loads need. An item is
    /// what the format says, of four-byte alignment at most.
    pub(super) fn fill<T: Copy>(&self, kind: u32, format: u32, items: &[T]) -> Result<(), Error> {
        let handle = self.shared.handle;
        // SAFETY: the handle is a live geometry of Embree's own.
        let buffer = attempt("allocate a buffer", || unsafe {
            embree!(
                self.shared.embree(),
                set_new_geometry_buffer(handle, kind, 0, format, size_of::<T>(), items.len())
            )
        })?;
        if !items.is_empty() {
            // SAFETY: without an error Embree returns a buffer of that many items of that size,
            // aligned to 16 bytes.
            unsafe {
                std::ptr::copy_nonoverlapping(items.as_ptr(), buffer.cast::<T>(), items.len())
            };
        }
        Ok(())
    }
}

impl Shared {
    fn embree(&self) -> &'static Table {
        self.device.embree()
    }

    fn user_pointer(&self) -> *mut c_void {
        std::ptr::from_ref::<Callbacks>(&self.callbacks)
            .cast_mut()
            .cast()
    }
}

impl Drop for Shared {
    fn drop(&mut self) {
        // SAFETY: the handle is live and not used after this; a scene that also holds it holds a clone
        // of this, so Embree's geometry ends here, before its callbacks.
        unsafe { embree!(self.embree(), release_geometry(self.handle)) };
    }
}

impl Callbacks {
    /// The user geometry behind the callbacks.
    pub(super) fn shape(&self) -> &dyn UserGeometry {
        self.shape
            .as_deref()
            .expect("only user geometries have these callbacks")
    }

    /// Whether the geometry has a filter of its own.
    pub(super) fn filtered(&self) -> bool {
        self.intersect_filter.is_some() || self.occluded_filter.is_some()
    }

    /// Those of the lanes whose rays see the geometry.
    ///
    /// # Safety
    /// `rays` is a ray packet of `width` lanes.
    pub(super) unsafe fn seen(&self, rays: *const f32, width: usize, lanes: u32) -> u32 {
        let Some(mask) = self.mask else {
            return lanes; // Embree has compared them
        };
        (0..width)
            .filter(|lane| lanes & 1 << lane != 0)
            // SAFETY: as the caller promises.
            .filter(|lane| unsafe { filter::read_ray(rays, width, *lane) }.mask & mask != 0)
            .fold(0, |seen, lane| seen | 1 << lane)
    }
}
