//! How triangles are stored: packed one by one, and unpacked side by side.

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
