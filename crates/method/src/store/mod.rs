//! How triangles are stored. `packed_patch` is the one packed form, 32 bytes; with the vertices it is a
//! `packed_triangle`, and `unpack` gives the patch back. A `block` holds eight unpacked patches side by side in
//! `columns`. `codecs` round numbers to what the packed form holds.

mod block;
mod codecs;
mod columns;
mod packed_patch;
mod packed_triangle;
mod unpack;

pub use block::PatchBlock;
pub(crate) use codecs::{pack_unevenness, unpack_unevenness};
pub use columns::in_columns;
pub(crate) use columns::{Columns, load_lanes, load_one, store_lanes};
pub(crate) use packed_patch::Contents;
pub use packed_patch::PackedPatch;
pub use packed_triangle::PackedTriangle;
