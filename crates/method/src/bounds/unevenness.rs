//! How far a surface may be off its paraboloid.

use crate::numbers::{Constant, Vector, inlined};
use crate::patch::{Patch, Rule, next};

/// How far the surface may be off the paraboloid, in units of the patch's size, for a unit of slope: it is not
/// at the vertices. Measured: fewer than 1 in 500 points of random patches are further off (the test below).
pub(crate) const HEIGHT: f64 = 0.4;
/// What the slope's greatest deviation at the sampled places is multiplied by, for what they do not show.
/// Measured, not proven: fewer than 1 in 500 points of random patches are steeper (docs/decisions/0020).
const SAMPLING_FACTOR: f64 = 1.3;
/// What is added for what a polynomial cannot follow, for the third power of the greatest slope: the next term
/// of the slope's series. Its factor is measured by the same test.
const CUBED: f64 = 0.25;

impl<S: Constant> Patch<S> {
    /// How far the surface's slope is off the paraboloid's at the most.
    #[inline(always)]
    pub(crate) fn unevenness(&self, normals: &[Vector<S>; 3]) -> S {
        const PLACES: [[f64; 2]; 4] = [[0.2, 0.2], [0.6, 0.2], [0.2, 0.6], [0.33, 0.34]];
        let zero = self.area2.zero();
        let one = self.area2.one();
        let (mut furthest, mut steepest, mut all) = (zero, zero, zero);
        let mut look = inlined(
            #[inline(always)]
            |b: [S; 3], normal: Vector<S>| {
                let upright = normal.dot(self.normal);
                let slope = self.normal - normal * (one / upright);
                let off = slope - self.paraboloid_slope(b);
                let (off, slope) = (off.dot(off), slope.dot(slope));
                furthest = off.greater(furthest);
                steepest = slope.greater(steepest);
                // What is no number stays so.
                all = all + off;
            },
        );
        each!(|i| {
            let mut b = [zero; 3];
            b[i] = one;
            look(b, normals[i]);
        });
        // Where the angular rule's surface is off most: half-way along an edge.
        let edges: &[_] = match self.rule {
            Rule::Angular => &[[0.5, 0.0], [0.5, 0.5], [0.0, 0.5]],
            _ => &[],
        };
        for &[u, v] in PLACES.iter().chain(edges) {
            let (u, v) = (zero.constant(u), zero.constant(v));
            look([one - u - v, u, v], self.geometric_normal(u, v));
        }
        let cubed = steepest * steepest.sqrt();
        furthest.sqrt() * zero.constant(SAMPLING_FACTOR) + cubed * zero.constant(CUBED) + all * zero
    }

    /// The paraboloid's slope, uphill.
    #[inline(always)]
    fn paraboloid_slope(&self, b: [S; 3]) -> Vector<S> {
        let [first, second, third] = three!(|k| {
            let (i, j) = (k, next(k));
            (self.gradients[j] * b[i] + self.gradients[i] * b[j]) * self.edges[k].bulge
        });
        first + second + third
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numbers::vector;
    use crate::patch::{PatchFlags, PatchKind, Surface};
    use crate::tests::{Random, V};

    /// How far the surface's slope and height are off the paraboloid's at some place, in units of the bound.
    fn off(patch: &Patch<f64>, random: &mut Random) -> [f64; 2] {
        let [u, v] = random.inside();
        let place = patch.point(u, v);
        let local = (place.position - patch.origin) * (1.0 / patch.size);
        let [b1, b2] = [1, 2].map(|k| patch.gradients[k].dot(local));
        let b = [1.0 - b1 - b2, b1, b2];
        let slope = patch.normal - place.normal * (1.0 / place.normal.dot(patch.normal));
        let steeper = (slope - patch.paraboloid_slope(b)).length();
        let height = (0..3).map(|k| patch.edges[k].bulge * b[k] * b[next(k)]);
        let away = (local.dot(patch.normal) - height.sum::<f64>()).abs();
        [steeper, away / HEIGHT].map(|off| off / patch.unevenness)
    }

    #[test]
    fn no_surface_is_further_off_the_paraboloid_than_is_kept() {
        let mut random = Random(22);
        let (mut total, mut over, mut high) = (0, 0, 0);
        for n in 0..2000 {
            let (p, normals) = random.triangle([5.0, 15.0, 30.0, 45.0][n % 4], 0.6);
            let flags = PatchFlags::new(Surface::ALL[n / 4 % 3]);
            let patch = Patch::<f64>::new(p, normals, flags);
            if patch.kind() != PatchKind::Curved {
                continue;
            }
            for _ in 0..30 {
                let [steeper, away] = off(&patch, &mut random);
                total += 1;
                over += u32::from(steeper > 1.0);
                high += u32::from(away > 1.0);
            }
        }
        println!("{over} of {total} points are steeper, {high} further off");
        assert!(
            total > 20_000 && (over + high) * 500 < total,
            "{over}, {high} of {total}"
        );
    }

    #[test]
    fn what_is_steepest_on_its_sides_is_not_further_off_either() {
        // Triangles of a torus: their paraboloids fit at the vertices.
        let corner = |i: usize, j: usize| {
            let ring = i as f64 / 12.0 * std::f64::consts::TAU;
            let tube = j as f64 / 16.0 * std::f64::consts::TAU;
            let normal: V = vector(ring.cos() * tube.cos(), ring.sin() * tube.cos(), tube.sin());
            (vector(ring.cos(), ring.sin(), 0.0) + normal * 0.4, normal)
        };
        let mut random = Random(23);
        for surface in Surface::ALL {
            for j in 0..16 {
                for corners in [
                    [(0, j), (1, j), (1, j + 1)],
                    [(0, j), (1, j + 1), (0, j + 1)],
                ] {
                    let corners = corners.map(|(i, j)| corner(i, j));
                    let flags = PatchFlags::new(surface);
                    let patch = Patch::new(corners.map(|c| c.0), corners.map(|c| c.1), flags);
                    for _ in 0..200 {
                        let [steeper, away] = off(&patch, &mut random);
                        assert!(
                            steeper < 1.05 && away < 1.0,
                            "{surface:?}: {steeper} {away}"
                        );
                    }
                }
            }
        }
    }
}
