//! The device: Embree itself, with its settings, threads and memory.

use std::ffi::{CString, c_void};
use std::fmt;
use std::sync::Arc;
use std::sync::atomic::{AtomicI64, Ordering};

use super::error::{Error, ErrorCode, keep_error};
use super::sys::{
    CurvetriDevice, RTC_DEVICE_PROPERTY_NATIVE_RAY4_SUPPORTED,
    RTC_DEVICE_PROPERTY_NATIVE_RAY8_SUPPORTED, RTC_DEVICE_PROPERTY_NATIVE_RAY16_SUPPORTED,
    RTC_DEVICE_PROPERTY_RAY_MASK_SUPPORTED, RTC_DEVICE_PROPERTY_VERSION,
};
use super::table::{Table, embree};

/// An Embree device. Clones are cheap and share one device, which lives as long as any of them or
/// anything made with them.
///
/// ```
/// use curvetri_embree::Device;
///
/// let device = Device::new(curvetri_embree_linked::embree()?)?;
/// println!("Embree {}, {} rays at once", device.version(), device.native_width());
/// # Ok::<(), curvetri_embree::Error>(())
/// ```
#[derive(Clone)]
pub struct Device(Arc<Shared>);

struct Shared {
    embree: &'static Table,
    handle: *mut CurvetriDevice,
    // in an allocation of its own: Embree keeps its address, also while the device is released
    memory: Box<MemoryCounters>,
    ray_masks: bool,
    native_width: usize,
    version: Version,
    limited_to: Option<String>,
}

// SAFETY: an RTCDevice is reference counted and may be used from any thread.
unsafe impl Send for Shared {}
// SAFETY: as above; Embree locks what its functions on a device change.
unsafe impl Sync for Shared {}

/// Bytes that Embree holds for a device: its trees and its own buffers.
///
/// ```
/// let memory = curvetri_embree_linked::device()?.memory();
/// assert!(memory.peak >= memory.current);
/// # Ok::<(), curvetri_embree::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Memory {
    /// Bytes held now.
    pub current: u64,
    /// The most bytes held at any time since the device was made.
    pub peak: u64,
}

#[derive(Default)]
struct MemoryCounters {
    current: AtomicI64,
    peak: AtomicI64,
}

/// A version of Embree.
///
/// ```
/// use curvetri_embree::Version;
///
/// let version = Version { major: 4, minor: 3, patch: 0 };
/// assert_eq!(version.to_string(), "4.3.0");
/// assert!(curvetri_embree_linked::device()?.version() >= Version { major: 3, minor: 13, patch: 0 });
/// # Ok::<(), curvetri_embree::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct Version {
    /// As the 4 in 4.3.0.
    pub major: u32,
    /// As the 3 in 4.3.0.
    pub minor: u32,
    /// As the 0 in 4.3.0.
    pub patch: u32,
}

impl Version {
    /// The first version whose hits carry `instPrimID`, and are larger for it.
    const LARGER_HIT: Self = Self {
        major: 4,
        minor: 3,
        patch: 0,
    };

    pub(super) fn from_number(number: u32) -> Self {
        Self {
            major: number / 10000,
            minor: number / 100 % 100,
            patch: number % 100,
        }
    }

    /// Whether a library of this version can be called with the other version's structures.
    fn fits(self, headers: Self) -> bool {
        self.major == headers.major && (self >= Self::LARGER_HIT) == (headers >= Self::LARGER_HIT)
    }
}

impl fmt::Display for Version {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "{}.{}.{}", self.major, self.minor, self.patch)
    }
}

impl Device {
    /// A device of an Embree, with Embree's own settings. All that is made with it uses that Embree.
    ///
    /// # Errors
    /// If Embree does not run on this processor, or its version is not the one this program was built
    /// for.
    pub fn new(embree: &'static Table) -> Result<Self, Error> {
        Self::with_config(embree, "")
    }

    /// A device with settings in Embree's own notation, as in `"threads=4,isa=avx2"`. Embree ignores
    /// settings it does not know.
    ///
    /// # Errors
    /// As [`new`](Self::new), and if the settings hold a NUL character or Embree refuses them.
    pub fn with_config(embree: &'static Table, config: &str) -> Result<Self, Error> {
        let text = CString::new(config).map_err(|_| Error::Configuration(config.to_owned()))?;
        // SAFETY: the string is NUL-terminated and outlives the call.
        let handle = unsafe { embree!(embree, new_device(text.as_ptr())) };
        if handle.is_null() {
            // SAFETY: a null device asks for the error of the device that could not be made.
            let code = unsafe { embree!(embree, get_device_error(handle)) };
            return Err(Error::Embree {
                doing: "make a device",
                code: ErrorCode::from_embree(code).unwrap_or(ErrorCode::Unknown),
                message: String::new(),
            });
        }
        let mut shared = Shared {
            embree,
            handle,
            memory: Box::default(),
            ray_masks: false,
            native_width: 1,
            version: Version::from_number(0),
            limited_to: limited_isa(config),
        };
        let device = {
            // SAFETY: the function is of the type asked for; it does not use its pointer.
            unsafe {
                embree!(
                    embree,
                    set_device_error_function(handle, Some(keep_error), std::ptr::null_mut())
                )
            };
            let version = shared.property(RTC_DEVICE_PROPERTY_VERSION);
            shared.version = Version::from_number(u32::try_from(version).unwrap_or(0));
            shared.ray_masks = shared.property(RTC_DEVICE_PROPERTY_RAY_MASK_SUPPORTED) != 0;
            shared.native_width = shared.widest_packet();
            let counters: *const MemoryCounters = &*shared.memory;
            // SAFETY: the counters outlive the device: `Shared` releases it before it drops them.
            unsafe {
                embree!(
                    embree,
                    set_device_memory_monitor(
                        handle,
                        Some(count_memory),
                        counters.cast_mut().cast::<c_void>()
                    )
                )
            };
            Self(Arc::new(shared))
        };
        device.check_version()?;
        Ok(device)
    }

    fn check_version(&self) -> Result<(), Error> {
        let (built, running) = (self.0.embree.version(), self.version());
        if running.fits(built) {
            Ok(())
        } else {
            Err(Error::Version { built, running })
        }
    }

    /// The version of the library in use.
    pub fn version(&self) -> Version {
        self.0.version
    }

    /// The instruction set that Embree's kernels use here, as in "AVX-512" or "SSE2", for people to
    /// read. Embree only tells the width of its packets: AVX2 is told from AVX by the processor.
    pub fn isa(&self) -> String {
        if let Some(isa) = &self.0.limited_to {
            return isa.clone();
        }
        match self.native_width() {
            16 => "AVX-512".to_owned(),
            8 if has_avx2() => "AVX2".to_owned(),
            8 => "AVX".to_owned(),
            4 if cfg!(target_arch = "aarch64") => "NEON".to_owned(),
            4 if has_sse42() => "SSE4.2".to_owned(),
            4 => "SSE2".to_owned(),
            _ => "single rays only".to_owned(),
        }
    }

    /// The widest packet (16, 8, 4 or 1 rays) that Embree traces as one on this processor; wider ones
    /// are split.
    pub fn native_width(&self) -> usize {
        self.0.native_width
    }

    /// Bytes that Embree holds for this device now, and the most it held.
    pub fn memory(&self) -> Memory {
        let read = |counter: &AtomicI64| counter.load(Ordering::Relaxed).max(0).unsigned_abs();
        let current = read(&self.0.memory.current);
        Memory {
            current,
            peak: read(&self.0.memory.peak).max(current),
        }
    }

    /// Whether Embree itself compares the masks of rays and geometries; where it was built without,
    /// user geometries compare them here, and triangles are seen by every ray.
    pub fn tests_ray_masks(&self) -> bool {
        self.0.ray_masks
    }

    pub(super) fn embree(&self) -> &'static Table {
        self.0.embree
    }

    pub(super) fn handle(&self) -> *mut CurvetriDevice {
        self.0.handle
    }

    pub(super) fn is(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.0, &other.0)
    }
}

impl fmt::Debug for Device {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            formatter,
            "Device(Embree {}, {})",
            self.version(),
            self.isa()
        )
    }
}

impl Shared {
    fn widest_packet(&self) -> usize {
        let widths = [
            (16, RTC_DEVICE_PROPERTY_NATIVE_RAY16_SUPPORTED),
            (8, RTC_DEVICE_PROPERTY_NATIVE_RAY8_SUPPORTED),
            (4, RTC_DEVICE_PROPERTY_NATIVE_RAY4_SUPPORTED),
        ];
        widths
            .iter()
            .find(|(_, property)| self.property(*property) != 0)
            .map_or(1, |found| found.0)
    }

    fn property(&self, property: u32) -> isize {
        // SAFETY: the handle is a live device.
        unsafe { embree!(self.embree, get_device_property(self.handle, property)) }
    }
}

impl Drop for Shared {
    fn drop(&mut self) {
        // SAFETY: the handle is a live device, not used after this; everything made with it holds a
        // clone of this and so is gone.
        unsafe { embree!(self.embree, release_device(self.handle)) };
    }
}

/// The memory monitor: counts, and lets every allocation happen.
unsafe extern "C" fn count_memory(user: *mut c_void, bytes: isize, _post: bool) -> bool {
    // SAFETY: the pointer is that of the device's counters, which outlive the device.
    let counters = unsafe { &*user.cast::<MemoryCounters>() };
    let bytes = bytes as i64;
    let current = counters.current.fetch_add(bytes, Ordering::Relaxed) + bytes;
    counters.peak.fetch_max(current, Ordering::Relaxed);
    true
}

/// The instruction set that a device's settings limit it to, in the way [`Device::isa`] writes it.
fn limited_isa(config: &str) -> Option<String> {
    let isa = config
        .split(',')
        .filter_map(|setting| setting.split_once('='))
        .find_map(|(name, value)| {
            (name.trim() == "isa").then(|| value.trim().to_ascii_lowercase())
        })?;
    Some(match isa.as_str() {
        "sse2" => "SSE2".to_owned(),
        "sse4.2" | "sse42" => "SSE4.2".to_owned(),
        "avx" => "AVX".to_owned(),
        "avx2" => "AVX2".to_owned(),
        "avx512" => "AVX-512".to_owned(),
        _ => return None,
    })
}

#[cfg(target_arch = "x86_64")]
fn has_avx2() -> bool {
    std::arch::is_x86_feature_detected!("avx2")
}

#[cfg(not(target_arch = "x86_64"))]
fn has_avx2() -> bool {
    false
}

#[cfg(target_arch = "x86_64")]
fn has_sse42() -> bool {
    std::arch::is_x86_feature_detected!("sse4.2")
}

#[cfg(not(target_arch = "x86_64"))]
fn has_sse42() -> bool {
    false
}
