//! Where in a pixel its samples lie.

/// The generalised golden ratio's powers as 32-bit fractions: Roberts' R2 sequence, whose first n
/// points are spread evenly for every n.
const STEP: [u32; 2] = [3_242_174_889, 2_447_445_414];

/// A pixel's sequence of sample points: the same in every run, and turned differently from pixel to
/// pixel so that no pattern shows.
#[derive(Clone, Copy, Debug)]
pub(super) struct PixelSampler {
    start: [u32; 2],
}

impl PixelSampler {
    /// The sequence of the pixel at column `x` and row `y`.
    pub fn new(x: u32, y: u32) -> Self {
        let first = mix(x ^ mix(y));
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
            let sampler = PixelSampler::new(pixel, 7 * pixel);
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
    fn pixels_differ() {
        let points: Vec<_> = [(0, 0), (1, 0), (0, 1), (1, 1)]
            .map(|(x, y)| PixelSampler::new(x, y).point(0))
            .to_vec();
        for (n, a) in points.iter().enumerate() {
            assert!(points[..n].iter().all(|b| a != b));
        }
    }
}
