//! Embree's errors as Rust errors.

use std::cell::RefCell;
use std::ffi::{CStr, c_char, c_void};
use std::fmt;

use super::device::Version;
use super::geometry::Geometry;
use super::meshes::Grid;
use super::sys;
use super::table::TableError;

/// What Embree or this wrapper over it refuses.
///
/// ```
/// use curvetri_embree::{Error, Geometry};
/// use glam::Vec3;
///
/// let device = curvetri_embree_linked::device()?;
/// let refused = Geometry::triangles(&device, &[Vec3::ZERO], &[[0, 0, 1]]).err();
/// let Some(Error::Index { triangle: 0, index: 1, .. }) = refused else { panic!() };
/// # Ok::<(), curvetri_embree::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// Embree reported an error.
    #[error("Embree cannot {doing}: {}", described(*.code, .message))]
    Embree {
        /// What it was asked to do, as in "commit the scene".
        doing: &'static str,
        /// Its error code.
        code: ErrorCode,
        /// Its message; may be empty.
        message: String,
    },
    /// The table of Embree's functions cannot be used.
    #[error(transparent)]
    Table(TableError),
    /// The Embree library in use does not fit the headers this program was built with.
    #[error(
        "this program was built for Embree {built} but runs with Embree {running}: build it again, \
         or run it with the library it was built for"
    )]
    Version {
        /// The headers' version.
        built: Version,
        /// The library's version.
        running: Version,
    },
    /// The device's configuration holds a NUL character.
    #[error("the device's configuration {0:?} holds a NUL character")]
    Configuration(String),
    /// A triangle names a vertex that does not exist.
    #[error("triangle {triangle} names vertex {index}, but there are {vertices} vertices")]
    Index {
        /// The triangle's number, from 0.
        triangle: usize,
        /// The index it holds.
        index: u32,
        /// How many vertices there are.
        vertices: usize,
    },
    /// More elements than Embree can number.
    #[error("{count} {what} are more than Embree takes ({limit})")]
    TooMany {
        /// Of what, as in "triangles".
        what: &'static str,
        /// How many there are.
        count: usize,
        /// How many there may be.
        limit: usize,
    },
    /// A grid has too few or too many vertices along a side, or names vertices that do not exist.
    #[error(
        "grid {number} has {} by {} vertices from {} on, {} apart by row: a side has 2 to {}, and \
         there are {vertices} vertices",
        .grid.width, .grid.height, .grid.first, .grid.stride, Grid::MOST
    )]
    Grid {
        /// The grid's number, from 0.
        number: usize,
        /// The grid.
        grid: Grid,
        /// How many vertices there are.
        vertices: usize,
    },
    /// A level of subdivision out of range.
    #[error("a subdivision level is 1 to {limit}, not {0}", limit = Geometry::FINEST_LEVEL)]
    Level(u32),
    /// A geometry has no or more than 129 time steps.
    #[error("a geometry has 1 to {limit} time steps, not {0}", limit = sys::TIME_STEPS)]
    TimeSteps(u32),
    /// A geometry, scene or instance belongs to another device.
    #[error("the {0} belongs to another Embree device")]
    OtherDevice(&'static str),
    /// Instances are nested deeper than the library was built for.
    #[error(
        "instances nested {depth} deep: this Embree was built for {}",
        sys::LEVELS
    )]
    Nesting {
        /// How deep they would be nested.
        depth: usize,
    },
    /// A scene for queries with filters has an instance of a scene that is not.
    #[error("a scene made for query filters instances one that was made without")]
    QueryFilters,
    /// An instance's transform is not finite, cannot be inverted, or would put its scene out of the
    /// range of Embree's arithmetic.
    #[error("the instance's transform is not finite, not invertible or out of range: {0}")]
    Transform(String),
}

fn described(code: ErrorCode, message: &str) -> String {
    if message.is_empty() {
        code.to_string()
    } else {
        format!("{message} ({code})")
    }
}

/// Embree's error codes.
///
/// ```
/// use curvetri_embree::{Error, ErrorCode};
///
/// /// Whether it may work with less in the scene.
/// fn is_out_of_memory(error: &Error) -> bool {
///     matches!(error, Error::Embree { code: ErrorCode::OutOfMemory, .. })
/// }
/// # assert!(!is_out_of_memory(&Error::QueryFilters));
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum ErrorCode {
    /// An error of no other kind.
    Unknown,
    /// An argument is wrong.
    InvalidArgument,
    /// The operation is not allowed in this state.
    InvalidOperation,
    /// There is not enough memory.
    OutOfMemory,
    /// The processor lacks what Embree needs (SSE2 at least).
    UnsupportedCpu,
    /// The user cancelled it.
    Cancelled,
    /// A code this crate does not know, of a newer Embree.
    Other(u32),
}

impl fmt::Display for ErrorCode {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Unknown => formatter.write_str("unknown error"),
            Self::InvalidArgument => formatter.write_str("invalid argument"),
            Self::InvalidOperation => formatter.write_str("invalid operation"),
            Self::OutOfMemory => formatter.write_str("out of memory"),
            Self::UnsupportedCpu => formatter.write_str("unsupported processor"),
            Self::Cancelled => formatter.write_str("cancelled"),
            Self::Other(code) => write!(formatter, "error code {code}"),
        }
    }
}

impl ErrorCode {
    /// `None` for "no error".
    pub(super) fn from_embree(code: u32) -> Option<Self> {
        Some(match code {
            sys::RTC_ERROR_NONE => return None,
            sys::RTC_ERROR_UNKNOWN => Self::Unknown,
            sys::RTC_ERROR_INVALID_ARGUMENT => Self::InvalidArgument,
            sys::RTC_ERROR_INVALID_OPERATION => Self::InvalidOperation,
            sys::RTC_ERROR_OUT_OF_MEMORY => Self::OutOfMemory,
            sys::RTC_ERROR_UNSUPPORTED_CPU => Self::UnsupportedCpu,
            sys::RTC_ERROR_CANCELLED => Self::Cancelled,
            other => Self::Other(other),
        })
    }
}

thread_local! {
    // Embree reports an error on the thread whose call failed, so each thread keeps its own: an
    // error never reaches another thread's call on the same device.
    static REPORTED: RefCell<Option<(ErrorCode, String)>> = const { RefCell::new(None) };
}

/// The device's error function: keeps the first error until [`attempt`] asks for it.
pub(super) unsafe extern "C" fn keep_error(_user: *mut c_void, code: u32, message: *const c_char) {
    let message = if message.is_null() {
        String::new()
    } else {
        // SAFETY: Embree passes a NUL-terminated string that lives for the call.
        unsafe { CStr::from_ptr(message) }
            .to_string_lossy()
            .into_owned()
    };
    if let Some(code) = ErrorCode::from_embree(code) {
        // a thread that is ending has no room left to keep an error, nor anybody to ask for it
        let _ = REPORTED.try_with(|kept| {
            kept.borrow_mut().get_or_insert((code, message));
        });
    }
}

/// Runs calls to Embree and returns the first error they reported on this thread.
pub(super) fn attempt<T>(doing: &'static str, calls: impl FnOnce() -> T) -> Result<T, Error> {
    REPORTED.take();
    let result = calls();
    match REPORTED.take() {
        None => Ok(result),
        Some((code, message)) => Err(Error::Embree {
            doing,
            code,
            message,
        }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn report(code: u32, message: &CStr) {
        // SAFETY: the message is NUL-terminated and lives for the call; the user pointer is not used.
        unsafe { keep_error(std::ptr::null_mut(), code, message.as_ptr()) };
    }

    #[test]
    fn an_attempt_gives_its_first_error_and_no_earlier_one() {
        report(sys::RTC_ERROR_UNKNOWN, c"of before");
        let refused = attempt("test this", || {
            report(sys::RTC_ERROR_NONE, c"no error");
            report(sys::RTC_ERROR_INVALID_OPERATION, c"scene not committed");
            report(sys::RTC_ERROR_CANCELLED, c"a later one");
        });
        let error = refused.unwrap_err();
        assert_eq!(
            error.to_string(),
            "Embree cannot test this: scene not committed (invalid operation)"
        );
        // and it is gone
        attempt("test this", || ()).unwrap();
    }

    #[test]
    fn an_error_is_told_to_the_thread_that_made_it() {
        let elsewhere = || report(sys::RTC_ERROR_OUT_OF_MEMORY, c"elsewhere");
        attempt("test this", || {
            std::thread::scope(|scope| scope.spawn(elsewhere).join().unwrap());
        })
        .unwrap();
    }
}
