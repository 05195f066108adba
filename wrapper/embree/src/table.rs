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

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    unsafe extern "C" fn never() {
        unreachable!("these tests call nothing of Embree's")
    }

    /// What `curvetri_embree.h` makes of Embree 3.13.5 or of 4.3.3, with functions that must not be called.
    fn filled(version: u32) -> CurvetriEmbree {
        let inst_prim_id = version >= 40300;
        let fields = if inst_prim_id { 9 } else { 8 };
        let size =
            |width: usize| 48 * width + (4 * fields * width).next_multiple_of((4 * width).max(16));
        // SAFETY: numbers and pointers to functions that may be null.
        let mut table: CurvetriEmbree = unsafe { std::mem::zeroed() };
        table.table_version = CURVETRI_TABLE_VERSION;
        table.table_size = size_of::<CurvetriEmbree>() as u32;
        table.headers_version = version;
        table.instance_levels = 1;
        table.inst_prim_id = u32::from(inst_prim_id);
        table.rayhit_size = [1, 4, 8, 16].map(|width| size(width) as u32);
        table.context_inst_id = if version < 40000 { 16 } else { 0 };
        let first = offset_of!(CurvetriEmbree, new_device);
        for offset in (first..size_of::<CurvetriEmbree>()).step_by(size_of::<usize>()) {
            let function: unsafe extern "C" fn() = never;
            let start = std::ptr::from_mut(&mut table).cast::<u8>();
            // SAFETY: there is a pointer to a function; none of these is called.
            unsafe {
                start
                    .add(offset)
                    .cast::<unsafe extern "C" fn()>()
                    .write(function)
            };
        }
        table
    }

    fn read(table: &CurvetriEmbree) -> Result<Table, TableError> {
        // SAFETY: the table is one of this version; its functions are not called.
        unsafe { Table::read(table) }
    }

    /// A table of Embree 3.13.5 or of 4.3.3 that calls nothing.
    pub(crate) fn table(version: u32) -> Table {
        read(&filled(version)).unwrap()
    }

    #[test]
    fn tables_of_both_generations_are_taken() {
        let (three, four) = (table(31305), table(40303));
        assert_eq!(three.version().to_string(), "3.13.5");
        assert_eq!(four.version().to_string(), "4.3.3");
        assert_eq!((three.hit_fields(), four.hit_fields()), (8, 9));
    }

    #[test]
    fn sizes_are_those_that_embree_documents() {
        assert_eq!(filled(31305).rayhit_size, [80, 320, 640, 1280]);
        assert_eq!(filled(40303).rayhit_size, [96, 336, 672, 1344]);
    }

    fn refused(change: impl Fn(&mut CurvetriEmbree)) -> TableError {
        let mut table = filled(40303);
        change(&mut table);
        read(&table).unwrap_err()
    }

    #[test]
    fn a_table_of_another_version_or_size_is_refused() {
        let size = size_of::<CurvetriEmbree>() as u32;
        let (version, other) = (CURVETRI_TABLE_VERSION, CURVETRI_TABLE_VERSION + 1);
        assert_eq!(
            refused(|table| table.table_version = other),
            TableError::Version {
                version: other,
                size
            }
        );
        let size = size - 8;
        assert_eq!(
            refused(|table| table.table_size = size),
            TableError::Version { version, size }
        );
    }

    #[test]
    fn an_embree_of_another_layout_is_refused() {
        for version in [31299, 40000, 40299, 50000] {
            let error = refused(|table| table.headers_version = version);
            assert_eq!(error, TableError::Embree(Version::from_number(version)));
        }
        assert_eq!(
            refused(|table| table.instance_levels = 2),
            TableError::Levels(2)
        );
        let error = refused(|table| table.inst_prim_id = 0);
        assert!(
            matches!(
                error,
                TableError::Layout {
                    width: 1,
                    size: 96,
                    expected: 80
                }
            ),
            "{error}"
        );
        let error = refused(|table| table.rayhit_size[3] = 1280);
        assert!(
            matches!(
                error,
                TableError::Layout {
                    width: 16,
                    expected: 1344,
                    ..
                }
            ),
            "{error}"
        );
    }

    #[test]
    fn a_table_without_one_of_its_functions_is_refused() {
        assert_eq!(
            refused(|table| table.new_device = None),
            TableError::Missing(0)
        );
        let TableError::Missing(last) = refused(|table| table.filter_occluded = None) else {
            panic!("it is taken");
        };
        assert!(last > 30, "{last}");
    }

    #[test]
    fn instance_ids_are_read_where_the_context_has_them() {
        // flags, filter, instID
        let three: [u32; 6] = [9, 9, 9, 9, 5, 9];
        // instID, instPrimID
        let four: [u32; 2] = [5, 6];
        // SAFETY: the arrays are laid out as the contexts of the two generations.
        let (three, four) = unsafe {
            (
                table(31305).instance_ids(three.as_ptr().cast()),
                table(40303).instance_ids(four.as_ptr().cast()),
            )
        };
        assert_eq!(three, [[5], [INVALID_ID]]);
        assert_eq!(four, [[5], [6]]);
    }
}
