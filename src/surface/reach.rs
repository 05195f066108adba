//! How far a curved triangle reaches along any direction, from what is kept of it.

use super::frame::Frame;
use super::kept::KeptPatch;
use super::vector::Vector;

/// Below this cosine between a vertex normal and the plane's, guides may lean without bound.
const MIN_COSINE: f32 = 0.05;

/// A triangle in its plane and what its surface may stand out from there, for its box along any direction.
#[derive(Clone, Copy, Debug)]
pub struct Reach {
    corners: [Vector<f32>; 3],
    normal: Vector<f32>,
    heights: [f32; 2],
    /// How far a guide leans beside the normal at the most, for a unit of height.
    lean: f32,
}

impl KeptPatch<'_> {
    /// How far the surface reaches; none where there is no surface, and where its vertex normals lie so flat
    /// that this is more than can be said.
    pub fn reach(&self) -> Option<Reach> {
        let corners = self.corners();
        let frame = Frame::new(&corners.positions, &corners.normals)?;
        let normal = frame.cross * (frame.winding / frame.area2);
        let (mut heights, mut lean) = ([0.0; 2], 0.0);
        if let Some(slab) = self.record().slab::<f32>() {
            let cosines = corners.normals.map(|n| n.dot(normal));
            let least = cosines.into_iter().fold(1.0, f32::min);
            // A guide stands on a sum of normals, which leans no more than they do.
            lean = (1.0 - least * least).max(0.0).sqrt() / least;
            if !(MIN_COSINE < least) {
                return None;
            }
            heights = slab.map(|height| height * frame.size);
        }
        Some(Reach {
            corners: corners.positions,
            normal,
            heights,
            lean,
        })
    }
}

impl Reach {
    /// The plane's unit normal, turned to agree with the vertex normals.
    pub fn normal(&self) -> Vector<f32> {
        self.normal
    }

    /// The way from the first vertex to the second.
    pub fn side(&self) -> Vector<f32> {
        self.corners[1] - self.corners[0]
    }

    /// The least and the greatest value that the scalar product with a direction takes over the surface, seen
    /// from a point; but for rounding.
    pub fn along(&self, direction: Vector<f32>, from: Vector<f32>) -> [f32; 2] {
        let [a, b, c] = self.corners.map(|corner| direction.dot(corner - from));
        let upright = direction.dot(self.normal);
        let aside = (direction.dot(direction) - upright * upright).max(0.0);
        let beside = aside.sqrt() * self.lean;
        // Heights are zero at the corners.
        let (mut lower, mut upper) = (0f32, 0f32);
        for height in self.heights {
            for way in [upright - beside, upright + beside] {
                lower = lower.min(height * way);
                upper = upper.max(height * way);
            }
        }
        [a.min(b).min(c) + lower, a.max(b).max(c) + upper]
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::{Random, rounded};
    use super::super::{Corners, PatchFlags, PatchKind, Prepared, Surface};
    use super::*;

    #[test]
    fn no_point_of_a_surface_is_out_of_reach() {
        let mut random = Random(41);
        let (mut points, mut widest) = (0, 0f32);
        for n in 0..2000 {
            let (positions, normals) = random.triangle([2.0, 10.0, 25.0, 50.0][n % 4], 0.6);
            let corners = Corners {
                positions: rounded(positions),
                normals: rounded(normals),
            };
            let record = Prepared::new(&corners, PatchFlags::new(Surface::ALL[n % 3])).record;
            let kept = KeptPatch::new(corners, &record);
            let Some(reach) = kept.reach() else {
                assert_ne!(record.kind(), PatchKind::Curved);
                continue;
            };
            let (patch, from) = (kept.patch(), corners.positions[n % 3]);
            let direction = Vector::from_f64(random.direction());
            let [lower, upper] = reach.along(direction, from);
            let room = 1e-5 * patch.size();
            for _ in 0..20 {
                let [u, v] = random.inside();
                let at = patch.point(u as f32, v as f32).position;
                let value = direction.dot(at - from);
                assert!(lower - room < value && value < upper + room, "{corners:?}");
                points += 1;
            }
            if n % 4 == 0 {
                let flat = corners.positions.map(|corner| direction.dot(corner - from));
                let least = flat.into_iter().fold(f32::INFINITY, f32::min);
                let most = flat.into_iter().fold(f32::NEG_INFINITY, f32::max);
                widest = widest.max(((upper - lower) - (most - least)) / patch.size());
            }
        }
        println!("{points} points, of surfaces that bend little {widest} beyond the triangle");
        assert!(points > 20_000 && widest < 0.1, "{points} {widest}");
    }
}
