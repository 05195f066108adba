//! How Embree's queries are answered.

mod block_cache;
mod callbacks;
mod cluster_query;
mod counters;
mod error_bound;
mod far_rays;
mod kernel_rays;
mod triangle_query;

pub use counters::{Counters, counters};
