//! What bindgen makes of the C headers; `ci/bindings.sh` compares it with the headers and writes it anew.
#![allow(
    missing_docs,
    non_camel_case_types,
    non_snake_case,
    non_upper_case_globals,
    dead_code
)]
#![allow(clippy::all, clippy::undocumented_unsafe_blocks)]

#[rustfmt::skip]
pub(crate) mod embree_3;
#[rustfmt::skip]
pub(crate) mod embree_4;
#[rustfmt::skip]
pub mod table;
