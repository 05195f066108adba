//! Where rays meet a patch. A ray is clipped (`clip`, and `single` for one ray alone), the rest of its way is a
//! `segment`, and the `paraboloid` says where it may cross the surface. A single crossing is found by the
//! `secant` method; otherwise `search` looks for the roots by `bracketing` or by the paper's `ita`.
//! `packet` and `pairs` are the same for many rays in SIMD lanes, `entry` for one.

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
