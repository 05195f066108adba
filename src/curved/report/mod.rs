//! What is in a mesh, what the method does with it, and what to do about that.

mod advice;
mod inspection;

pub use advice::Advice;
pub use inspection::{EdgeLengths, Inspection, MemoryNeed, SurfaceHeights};
