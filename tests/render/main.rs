//! The renderer: scenes with instances, and pictures against what is known of them.

mod far;
mod instances;
mod integrators;
#[cfg(feature = "compare")]
mod silhouette;
mod terminator;
