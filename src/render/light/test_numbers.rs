//! Random numbers for the tests of lights.

use crate::render::integrate::PixelSampler;

/// How many there are.
pub const COUNT: u32 = 1 << 14;

/// Sets of four numbers in [0, 1), spread evenly.
pub fn numbers() -> impl Iterator<Item = [f32; 4]> {
    let sampler = PixelSampler::new(3, 4, 5);
    (0..COUNT).map(move |n| sampler.sample(n).numbers(0))
}
