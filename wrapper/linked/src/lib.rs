//! The installed Embree, 3.13 or 4.3 and later, for [`curvetri_embree`], which links none itself.
//!
//! A program that depends on this package links Embree. The build script looks for the system's; the environment
//! variable `EMBREE_DIR`, a prefix with `include/` and `lib/`, goes before it.
//!
//! ```
//! let device = curvetri_embree_linked::device()?;
//! println!("Embree {} ({})", device.version(), device.isa());
//! # Ok::<(), curvetri_embree::Error>(())
//! ```

use std::sync::OnceLock;

use curvetri_embree::{CurvetriEmbree, Device, Error, Table, TableError};

unsafe extern "C" {
    fn curvetri_linked_embree() -> *const CurvetriEmbree;
}

/// The table of the Embree that this program is linked with.
///
/// # Errors
/// If this package does not fit the version of `curvetri-embree` that it was built with.
///
/// ```
/// use curvetri_embree::Device;
///
/// let embree = curvetri_embree_linked::embree()?;
/// let device = Device::new(embree)?;
/// assert_eq!(device.version().major, embree.version().major);
/// # Ok::<(), curvetri_embree::Error>(())
/// ```
pub fn embree() -> Result<&'static Table, Error> {
    static EMBREE: OnceLock<Result<Table, TableError>> = OnceLock::new();
    let table = EMBREE.get_or_init(|| {
        // SAFETY: the function is called once; it returns a table that is never changed after that, filled by
        // curvetri_embree.h with the functions of the Embree it was compiled for.
        unsafe { Table::read(curvetri_linked_embree()) }
    });
    table.as_ref().map_err(|error| Error::Table(error.clone()))
}

/// A device of that Embree with its own settings.
///
/// # Errors
/// As [`Device::new`].
///
/// ```
/// let device = curvetri_embree_linked::device()?;
/// assert!(device.native_width() >= 1);
/// # Ok::<(), curvetri_embree::Error>(())
/// ```
pub fn device() -> Result<Device, Error> {
    Device::new(embree()?)
}

/// A device of that Embree with settings in Embree's own notation, as in `"threads=4,isa=avx2"`.
///
/// # Errors
/// As [`Device::with_config`].
///
/// ```
/// let device = curvetri_embree_linked::device_with_config("threads=1")?;
/// # Ok::<(), curvetri_embree::Error>(())
/// ```
pub fn device_with_config(config: &str) -> Result<Device, Error> {
    Device::with_config(embree()?, config)
}
