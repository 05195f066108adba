//! The Embree in use: a table of its functions, and what of it differs from version to version.

use std::ffi::c_void;
use std::mem::{offset_of, size_of};

use super::bindings::table::{CURVETRI_TABLE_VERSION, CurvetriEmbree};
use super::device::Version;
use super::record::HIT_FIELDS;
use super::sys::{INVALID_ID, LEVELS};

/// An Embree library, 3.13 or 4.3 and later: the table of its functions, with the layout of its hits.
///
/// `curvetri-embree-linked` has that of the library it links. A program with an Embree of its own fills one in C, by
/// `curvetri_embree.h`.
///
/// ```
/// let embree = curvetri_embree_linked::embree()?;
/// println!("compiled for Embree {}", embree.version());
/// # Ok::<(), curvetri_embree::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct Table {
    functions: CurvetriEmbree,
}

/// Why a table of Embree's functions cannot be used.
///
/// ```
/// use curvetri_embree::TableError;
///
/// let message = TableError::Levels(3).to_string();
/// assert!(message.contains("3 levels of nested instances"));
/// ```
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum TableError {
    /// The table was filled by another version of `curvetri_embree.h`.
    #[error(
        "the table of Embree's functions is of version {version} and {size} bytes, but curvetri expects version {} \
         and {} bytes: compile the program with the curvetri_embree.h of this curvetri",
        CURVETRI_TABLE_VERSION,
        size_of::<CurvetriEmbree>()
    )]
    Version {
        /// The table's version.
        version: u32,
        /// The table's size in bytes.
        size: u32,
    },
    /// This version of Embree is not supported.
    #[error("Embree {0} is not supported: curvetri needs Embree 3.13, or 4.3 and later")]
    Embree(Version),
    /// This Embree was built for another number of levels of nested instances than 1.
    #[error(
        "this Embree was built for {0} levels of nested instances, but curvetri takes {LEVELS}"
    )]
    Levels(u32),
    /// A packet of rays with hits is not as large as its fields.
    #[error(
        "a packet of {width} rays with hits has {size} bytes in this Embree, but its fields take {expected}"
    )]
    Layout {
        /// How many rays.
        width: usize,
        /// Its size in the table.
        size: u32,
        /// The size that its fields make.
        expected: usize,
    },
    /// The table lacks a function.
    #[error("the table of Embree's functions lacks number {0}")]
    Missing(usize),
}

impl Table {
    /// Reads and checks the table that `curvetri_embree.h` has filled.
    ///
    /// # Errors
    /// If it was filled by another version of that header, or for an Embree that is not supported.
    ///
    /// # Safety
    /// `table` points to a `struct CurvetriEmbree` of `curvetri_table.h`, of this version or another. Its functions do
    /// what that header says, for as long as this process runs.
    pub unsafe fn read(table: *const CurvetriEmbree) -> Result<Self, TableError> {
        // SAFETY: every version of the table begins with its version and its size.
        let (version, size) = unsafe { ((*table).table_version, (*table).table_size) };
        if version != CURVETRI_TABLE_VERSION || size as usize != size_of::<CurvetriEmbree>() {
            return Err(TableError::Version { version, size });
        }
        // SAFETY: the table is as large as this version's.
        let functions = unsafe { table.read() };
        let table = Self { functions };
        table.check()?;
        Ok(table)
    }

    fn check(&self) -> Result<(), TableError> {
        let table = &self.functions;
        if !matches!(table.headers_version, 31300..40000 | 40300..50000) {
            return Err(TableError::Embree(self.version()));
        }
        if table.instance_levels as usize != LEVELS {
            return Err(TableError::Levels(table.instance_levels));
        }
        for (width, size) in [1_usize, 4, 8, 16].into_iter().zip(table.rayhit_size) {
            let alignment = (4 * width).max(16);
            let expected = 48 * width + (4 * self.hit_fields() * width).next_multiple_of(alignment);
            if size as usize != expected {
                return Err(TableError::Layout {
                    width,
                    size,
                    expected,
                });
            }
        }
        self.missing()
            .map_or(Ok(()), |number| Err(TableError::Missing(number)))
    }

    /// The number of the first function that is null.
    fn missing(&self) -> Option<usize> {
        type Function = Option<unsafe extern "C" fn()>;
        let first = offset_of!(CurvetriEmbree, new_device);
        let count = (size_of::<CurvetriEmbree>() - first) / size_of::<Function>();
        let start = std::ptr::from_ref(&self.functions).cast::<u8>();
        // SAFETY: from its first function on the table is made of pointers to functions, which have one size, and are
        // only compared with null here.
        let functions =
            unsafe { std::slice::from_raw_parts(start.add(first).cast::<Function>(), count) };
        functions.iter().position(Option::is_none)
    }

    /// The version of Embree's headers that the table was filled with. The library may be a later one.
    pub fn version(&self) -> Version {
        Version::from_number(self.functions.headers_version)
    }

    pub(super) fn functions(&self) -> &CurvetriEmbree {
        &self.functions
    }

    /// Whether hits and contexts have `instPrimID`.
    pub(super) fn has_inst_prim_id(&self) -> bool {
        self.functions.inst_prim_id != 0
    }

    /// How many four-byte fields a hit of this Embree has.
    pub(super) fn hit_fields(&self) -> usize {
        if self.has_inst_prim_id() {
            HIT_FIELDS
        } else {
            HIT_FIELDS - LEVELS
        }
    }

    /// `instID` and `instPrimID` of the query that a callback belongs to.
    ///
    /// # Safety
    /// `context` is what Embree passes to a callback.
    pub(super) unsafe fn instance_ids(&self, context: *const c_void) -> [[u32; LEVELS]; 2] {
        let offset = self.functions.context_inst_id as usize;
        // SAFETY: the context has `instID` there, and `instPrimID` behind it if it has any.
        unsafe {
            let ids = context.byte_add(offset).cast::<[u32; LEVELS]>();
            let prim_ids = if self.has_inst_prim_id() {
                ids.add(1).read()
            } else {
                [INVALID_ID; LEVELS]
            };
            [ids.read(), prim_ids]
        }
    }
}

/// Calls one of Embree's functions, as in `embree!(table, release_scene(scene))`.
macro_rules! embree {
    ($table:expr, $function:ident($($argument:expr),* $(,)?)) => {
        ($table.functions().$function.expect("a table has every function"))($($argument),*)
    };
}
pub(super) use embree;
