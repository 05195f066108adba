//! Numbers that the kernel is written over.

mod dual;
mod fields;
mod interval;
mod jet;
mod lanes;
mod pair_lanes;
mod scalar;
mod vector;

pub use dual::Dual;
pub(crate) use fields::Visitor;
pub(crate) use interval::Interval;
pub use jet::{Jet, Quadratic};
pub(crate) use jet::{at_least, capped, lesser, ratio_or_zero};
pub use lanes::{
    LaneMask, Lanes, MAX_LANES, ManyPatches, PATCHES, PatchMask, Patches, Quad, load_lanes,
};
pub(crate) use pair_lanes::PairLanes;
pub(crate) use scalar::each;
pub use scalar::{Arithmetic, Constant, Mask, Real, Scalar, inlined, three};
pub use vector::{Vector, vector};
