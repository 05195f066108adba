//! Random numbers that are the same everywhere, for tests, benchmarks and made meshes.

use glam::Vec3;

/// Added to the state for each number.
const STEP: u64 = 0x9e37_79b9_7f4a_7c15;

/// SplitMix64 of Steele, Lea and Flood, "Fast splittable pseudorandom number generators", 2014.
pub struct SplitMix(u64);

impl SplitMix {
    /// The sequence of a seed.
    pub fn new(seed: u64) -> SplitMix {
        SplitMix(seed)
    }

    /// The sequence of a seed from its number `index` on, counted from 0.
    pub fn from_index(seed: u64, index: u64) -> SplitMix {
        SplitMix(seed.wrapping_add(index.wrapping_mul(STEP)))
    }

    /// The next number, any of 64 bits.
    pub fn next_u64(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(STEP);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// A number from 0 up to but without 1.
    pub fn unit(&mut self) -> f64 {
        (self.next_u64() >> 11) as f64 / (1u64 << 53) as f64
    }

    /// [`Self::unit`] rounded to `f32`, so that 1 can occur: once in 2^25 times.
    pub fn unit_f32(&mut self) -> f32 {
        self.unit() as f32
    }

    /// A number from `low` up to but without `high`.
    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    /// A whole number below `count`.
    ///
    /// # Panics
    /// If `count` is 0.
    pub fn below(&mut self, count: usize) -> usize {
        (self.next_u64() % count as u64) as usize
    }

    /// A point of the cube from -1 to 1.
    pub fn in_cube(&mut self) -> Vec3 {
        Vec3::from_array([(); 3].map(|()| 2.0 * self.unit_f32() - 1.0))
    }

    /// A direction of unit length, all equally likely.
    pub fn direction(&mut self) -> Vec3 {
        let (z, turn) = (
            2.0 * self.unit_f32() - 1.0,
            std::f32::consts::TAU * self.unit_f32(),
        );
        let flat = (1.0 - z * z).max(0.0).sqrt();
        Vec3::new(flat * turn.cos(), flat * turn.sin(), z)
    }

    /// Barycentric coordinates of a point of a triangle, all points equally likely.
    pub fn barycentric(&mut self) -> [f32; 3] {
        let (mut u, mut v) = (self.unit_f32(), self.unit_f32());
        if u + v > 1.0 {
            (u, v) = (1.0 - u, 1.0 - v);
        }
        [1.0 - u - v, u, v]
    }

    /// Puts values into random order.
    pub fn shuffle<T>(&mut self, values: &mut [T]) {
        for last in (1..values.len()).rev() {
            values.swap(last, self.below(last + 1));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sequence_is_the_published_one() {
        let mut random = SplitMix::new(1_234_567);
        assert_eq!(random.next_u64(), 6_457_827_717_110_365_317);
        assert_eq!(random.next_u64(), 3_203_168_211_198_807_973);
        assert_eq!(
            SplitMix::from_index(1_234_567, 1).next_u64(),
            3_203_168_211_198_807_973
        );
    }

    #[test]
    fn numbers_stay_in_their_range() {
        let mut random = SplitMix::new(1);
        let numbers: Vec<f64> = (0..1000).map(|_| random.between(2.0, 3.0)).collect();
        assert!(numbers.iter().all(|x| (2.0..3.0).contains(x)));
        assert!((numbers.iter().sum::<f64>() / 1000.0 - 2.5).abs() < 0.05);
        assert!((0..1000).all(|_| random.below(3) < 3));
    }

    #[test]
    fn points_and_directions_are_spread_evenly() {
        let mut random = SplitMix::new(2);
        let (mut cube, mut sphere, mut triangle) = (Vec3::ZERO, Vec3::ZERO, Vec3::ZERO);
        for _ in 0..10_000 {
            let point = random.in_cube();
            assert!(point.abs().max_element() <= 1.0);
            let direction = random.direction();
            assert!(direction.is_normalized());
            let barycentric = Vec3::from_array(random.barycentric());
            assert!(barycentric.min_element() >= -f32::EPSILON);
            assert!((barycentric.element_sum() - 1.0).abs() < 1e-6);
            cube += point;
            sphere += direction;
            triangle += barycentric;
        }
        assert!(cube.length() < 0.03 * 10_000.0, "{cube}");
        assert!(sphere.length() < 0.03 * 10_000.0, "{sphere}");
        let third = triangle / 10_000.0 - 1.0 / 3.0;
        assert!(third.length() < 0.01, "{third}");
    }

    #[test]
    fn shuffling_keeps_all_values() {
        let mut values: Vec<u32> = (0..100).collect();
        SplitMix::new(3).shuffle(&mut values);
        assert!(!values.is_sorted());
        values.sort_unstable();
        assert_eq!(values, (0..100).collect::<Vec<_>>());
    }
}
