//! Numbers that the kernel is written over: scalars and SIMD lanes (`scalar`, `lanes`, `pair_lanes`), vectors,
//! derivatives (`jet`, `dual`), intervals; and the cursor between structs and columns (`fields`).

#[macro_use]
mod scalar;

mod dual;
mod fields;
mod interval;
mod jet;
mod lanes;
mod pair_lanes;

mod set_bits;
mod vector;

pub use dual::Dual;
#[cfg(test)]
pub(crate) use fields::tests::assert_counted;
pub(crate) use fields::{Cursor, Fields, from_array, to_array};
pub(crate) use interval::Interval;
pub use jet::{Jet, Quadratic};
pub(crate) use jet::{at_least, capped, lesser, ratio_or_zero};
pub use lanes::{
    LaneMask, Lanes, MAX_LANES, ManyPatches, PATCHES, PatchMask, Patches, Quad, load_lanes,
};
pub(crate) use pair_lanes::PairLanes;
pub use scalar::{Constant, Mask, Real, Scalar, inlined, three};
pub use set_bits::{SetBits, set_bits};
pub use vector::{Vector, vector};
