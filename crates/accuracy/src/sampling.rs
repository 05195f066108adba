//! Where a triangle and an edge are looked at.

use curvetri_bodies::SplitMix;

/// The golden ratio's siblings: Roberts' R2 sequence, which fills the square evenly.
const R2: [f64; 2] = [0.754_877_666_246_692_7, 0.569_840_290_998_053_2];
/// The golden ratio less 1.
const R1: f64 = 0.618_033_988_749_894_8;

/// `count` barycentric coordinates (u, v), uniform over a triangle's area.
pub(super) fn points(count: usize, seed: u64, triangle: usize) -> impl Iterator<Item = [f64; 2]> {
    let start = [0, 1].map(|n| unit(seed, 2 * triangle as u64 + n));
    (0..count).map(move |n| {
        let [u, v] = [0, 1].map(|k| (start[k] + R2[k] * n as f64).fract());
        if u + v > 1.0 {
            [1.0 - u, 1.0 - v]
        } else {
            [u, v]
        }
    })
}

/// How far inside its edges a triangle is looked at there, in barycentric coordinates: where the
/// surface ends, a ray at the very end may miss by rounding.
const INSIDE: f64 = 1e-6;

/// Barycentric coordinates along a triangle's edges, their middles among them and its corners not,
/// as dense as `count` points inside it.
pub(super) fn around(count: usize) -> impl Iterator<Item = [f64; 2]> {
    let parts = 2 * ((count as f64).sqrt() / 2.0).ceil() as usize;
    (0..3).flat_map(move |k| {
        (1..parts).map(move |n| inset(on_edge(k, n as f64 / parts as f64), INSIDE))
    })
}

/// The same point, moved towards the triangle's middle by this share of the way.
pub(super) fn inset(at: [f64; 2], share: f64) -> [f64; 2] {
    at.map(|b| b + share * (1.0 / 3.0 - b))
}

/// Barycentric coordinates of a place on edge `k`, from its first end at 0.
pub(super) fn on_edge(k: usize, along: f64) -> [f64; 2] {
    match k {
        0 => [along, 0.0],
        1 => [1.0 - along, along],
        _ => [0.0, 1.0 - along],
    }
}

/// `count` places along an edge, from 0 to 1 and uniform.
pub(super) fn places(count: usize, seed: u64, edge: usize) -> impl Iterator<Item = f64> {
    let start = unit(!seed, edge as u64);
    (0..count).map(move |n| (start + R1 * n as f64).fract())
}

/// A number from 0 up to but without 1. The factor sets the sequences of neighbouring seeds far apart.
fn unit(seed: u64, index: u64) -> f64 {
    SplitMix::from_index(seed.wrapping_mul(0xd134_2543_de82_ef95), index).unit()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_fill_the_triangle_evenly() {
        let count = 20_000;
        let mut sums = [0.0; 3];
        let mut in_corner = 0;
        for [u, v] in points(count, 7, 3) {
            assert!(u >= 0.0 && v >= 0.0 && u + v <= 1.0 + 1e-15);
            sums = [sums[0] + u, sums[1] + v, sums[2] + u * v];
            in_corner += usize::from(u + v < 0.5);
        }
        let means = sums.map(|sum| sum / count as f64);
        assert!((means[0] - 1.0 / 3.0).abs() < 1e-3 && (means[1] - 1.0 / 3.0).abs() < 1e-3);
        assert!((means[2] - 1.0 / 12.0).abs() < 1e-3, "{means:?}");
        assert!((in_corner as f64 / count as f64 - 0.25).abs() < 2e-3);
    }

    #[test]
    fn seeds_and_triangles_differ() {
        let first = |seed, triangle| points(1, seed, triangle).next();
        assert_ne!(first(1, 0), first(2, 0));
        assert_ne!(first(1, 0), first(1, 1));
        assert_eq!(first(1, 5), first(1, 5));
    }
}
