//! Where rays meet a patch.

mod bracketing;
mod clip;
mod entry;
mod hit;
mod ita;
mod lane_search;
mod packet;
mod pairs;
mod paraboloid;
mod ray;
mod root;
mod search;
mod secant;
mod segment;
mod single;

pub use entry::Precision;
pub use hit::{Hit, Solver};
pub use packet::{HitLanes, RayLanes};
pub use pairs::{PairHit, PairHits};
pub use ray::Ray;
#[cfg(test)]
pub(crate) use segment::Segment;
