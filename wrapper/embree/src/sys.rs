//! The generated bindings of the shim and of Embree's types.
#![allow(
    missing_docs,
    non_camel_case_types,
    non_snake_case,
    non_upper_case_globals,
    dead_code
)]
#![allow(clippy::all, clippy::undocumented_unsafe_blocks)]

#[cfg(embree_bindgen)]
include!(concat!(env!("OUT_DIR"), "/bindings.rs"));
#[cfg(all(not(embree_bindgen), embree3))]
include!("bindings_3.rs");
#[cfg(all(not(embree_bindgen), embree4))]
include!("bindings_4.rs");

// Here and not in the build script: the compiler starts anew when its options change, so that testing with
// both versions of Embree would compile all twice.
#[cfg_attr(embree3, link(name = "embree3"))]
#[cfg_attr(embree4, link(name = "embree4"))]
unsafe extern "C" {}

/// `RTC_INVALID_GEOMETRY_ID`, a macro with a cast that bindgen leaves out.
pub(crate) const INVALID_ID: u32 = u32::MAX;

/// Levels of nested instances in a hit.
pub(crate) const LEVELS: usize = RTC_MAX_INSTANCE_LEVEL_COUNT as usize;

/// Calls an Embree function through the shim's table, as in `embree!(release_scene(scene))`.
macro_rules! embree {
    ($function:ident($($argument:expr),* $(,)?)) => {
        (*$crate::sys::curvetri_embree())
            .$function
            .expect("the shim's table is filled")($($argument),*)
    };
}
pub(crate) use embree;
