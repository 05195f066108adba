//! Random numbers for pixels: where their samples lie, and which way light goes there.

/// The generalised golden ratio's powers as 32-bit fractions: Roberts' R2 sequence, whose first n
/// points are spread evenly for every n.
const STEP: [u32; 2] = [3_242_174_889, 2_447_445_414];

/// A pixel's sequence of sample points: the same in every run with the same seed, and turned
/// differently from pixel to pixel so that no pattern shows.
#[derive(Clone, Copy, Debug)]
pub(in crate::render) struct PixelSampler {
    start: [u32; 2],
}

/// The random numbers of one sample of a pixel.
#[derive(Clone, Copy, Debug, Default)]
pub(in crate::render) struct Sample {
    index: u32,
    seed: u32,
}

impl PixelSampler {
    /// The sequence of the pixel at column `x` and row `y`.
    pub fn new(x: u32, y: u32, seed: u32) -> Self {
        let first = mix(x ^ mix(y ^ mix(seed)));
        Self {
            start: [first, mix(first ^ 0x9e37_79b9)],
        }
    }

    /// Sample `index` within the pixel, each coordinate in [0, 1).
    pub fn point(&self, index: u32) -> [f32; 2] {
        [0, 1].map(|axis| {
            let bits = self.start[axis].wrapping_add(index.wrapping_mul(STEP[axis]));
            (bits >> 8) as f32 / (1 << 24) as f32
        })
    }

    /// The random numbers that sample `index` goes on with.
    pub fn sample(&self, index: u32) -> Sample {
        Sample {
            index: index % MOST_INDEX,
            seed: mix(self.start[1] ^ 0x85eb_ca6b).wrapping_add(index / MOST_INDEX),
        }
    }
}

/// How long a sequence of [`sobol_burley`] is.
const MOST_INDEX: u32 = 1 << 16;

impl Sample {
    /// Four numbers in [0, 1), others for each `set`: an Owen-scrambled Sobol sequence along the
    /// pixel's samples, so that few of them already are spread evenly.
    pub fn numbers(&self, set: u32) -> [f32; 4] {
        let sets = sobol_burley::NUM_DIMENSION_SETS_4D;
        let seed = self.seed ^ mix(set / sets);
        sobol_burley::sample_4d(self.index, set % sets, seed)
    }
}

/// A hash of 32 bits in which every bit depends on every other (`lowbias32` by C. Wellons).
fn mix(mut x: u32) -> u32 {
    x = (x ^ x >> 16).wrapping_mul(0x7feb_352d);
    x = (x ^ x >> 15).wrapping_mul(0x846c_a68b);
    x ^ x >> 16
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sixteen_samples_meet_every_quarter_of_a_pixel_about_equally() {
        for pixel in 0..100 {
            let sampler = PixelSampler::new(pixel, 7 * pixel, 0);
            let mut counts = [0; 4];
            for index in 0..16 {
                let [x, y] = sampler.point(index);
                assert!((0.0..1.0).contains(&x) && (0.0..1.0).contains(&y));
                counts[usize::from(x >= 0.5) + 2 * usize::from(y >= 0.5)] += 1;
            }
            assert!(
                counts.iter().all(|count| (2..=6).contains(count)),
                "{counts:?}"
            );
        }
    }

    #[test]
    fn pixels_and_seeds_differ() {
        let samplers = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (1, 1, 0), (0, 0, 1)]
            .map(|(x, y, seed)| PixelSampler::new(x, y, seed));
        for (n, a) in samplers.iter().enumerate() {
            for b in &samplers[..n] {
                assert_ne!(a.point(0), b.point(0));
                assert_ne!(a.sample(0).numbers(0), b.sample(0).numbers(0));
            }
        }
    }

    /// The mean over a pixel's samples of a function of numbers of two sets.
    fn mean(seed: u32, sets: [u32; 2], of: impl Fn([f32; 4], [f32; 4]) -> f32) -> f32 {
        let sampler = PixelSampler::new(9, 2, seed);
        let samples = (0..4096).map(|n| sampler.sample(n));
        let values = samples.map(|sample| of(sample.numbers(sets[0]), sample.numbers(sets[1])));
        values.sum::<f32>() / 4096.0
    }

    #[test]
    fn numbers_are_even_and_sets_have_nothing_to_do_with_each_other() {
        let sets = sobol_burley::NUM_DIMENSION_SETS_4D;
        for other in [1, 2, 17, sets, sets + 1, 5 * sets] {
            for seed in 0..4 {
                for (i, j) in [(0, 0), (1, 3), (3, 2)] {
                    let product = mean(seed, [0, other], |a, b| a[i] * b[j]);
                    assert!((product - 0.25).abs() < 0.01, "{other} {i} {j}: {product}");
                }
                let plain = mean(seed, [other, 0], |a, _| a[0]);
                assert!((plain - 0.5).abs() < 1e-3, "{other}: {plain}");
            }
        }
        let beyond = PixelSampler::new(9, 2, 0);
        assert_ne!(
            beyond.sample(MOST_INDEX).numbers(0),
            beyond.sample(0).numbers(0)
        );
    }
}
