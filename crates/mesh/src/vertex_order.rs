//! Vertices in an order in which neighbours are close to each other in memory.

use glam::Vec3;
use rayon::prelude::*;

use crate::mesh::Mesh;

/// Digits of each coordinate of a place.
const DIGITS: u32 = 21;

impl Mesh {
    /// The same mesh with its vertices numbered anew, by place: a ray that meets a triangle reads six vectors
    /// of its vertices, and those of the triangles beside it soon after, so what is close in space should be
    /// close in memory. Triangles keep their numbers.
    #[must_use]
    pub fn ordered(self) -> Mesh {
        let bounds = around(&self.positions);
        let mut order: Vec<(u64, u32)> = (self.positions.par_iter())
            .zip(0..self.positions.len() as u32)
            .map(|(&position, vertex)| (code(position, bounds), vertex))
            .collect();
        order.par_sort_unstable();
        let mut place_of = vec![0u32; order.len()];
        for (place, &(_, vertex)) in order.iter().enumerate() {
            place_of[vertex as usize] = place as u32;
        }
        let moved = |from: Vec<Vec3>| -> Vec<Vec3> {
            let vertices = order.par_iter().map(|&(_, vertex)| vertex);
            vertices.map(|vertex| from[vertex as usize]).collect()
        };
        let (positions, normals) = (moved(self.positions), moved(self.normals));
        let mut triangles = self.triangles;
        triangles
            .par_iter_mut()
            .for_each(|triangle| *triangle = triangle.map(|vertex| place_of[vertex as usize]));
        Mesh {
            origin: self.origin,
            positions,
            normals,
            triangles,
        }
    }
}

/// The least corner of a box around points, and how many steps there are to a unit of length.
fn around(points: &[Vec3]) -> (Vec3, f32) {
    let least = points
        .par_iter()
        .copied()
        .reduce(|| Vec3::INFINITY, Vec3::min);
    let most = points
        .par_iter()
        .copied()
        .reduce(|| Vec3::NEG_INFINITY, Vec3::max);
    let extent = (most - least).max_element();
    let steps = ((1u32 << DIGITS) - 1) as f32;
    (least, if extent > 0.0 { steps / extent } else { 0.0 })
}

/// A place's number along Morton's curve: the coordinates' binary digits in turn.
fn code(position: Vec3, (least, steps): (Vec3, f32)) -> u64 {
    let at = (position - least) * steps;
    let spread = |coordinate: f32| {
        let digits = u64::from((coordinate as u32).min((1 << DIGITS) - 1));
        // Two zeros behind each digit, by halves.
        let pairs = [
            (32, 0x001f_0000_0000_ffff),
            (16, 0x001f_0000_ff00_00ff),
            (8, 0x100f_00f0_0f00_f00f),
            (4, 0x10c3_0c30_c30c_30c3),
            (2, 0x1249_2492_4924_9249),
        ];
        pairs
            .into_iter()
            .fold(digits, |digits, (by, mask)| (digits | digits << by) & mask)
    };
    spread(at.x) | spread(at.y) << 1 | spread(at.z) << 2
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn coordinates_take_turns() {
        let unit = (Vec3::ZERO, 1.0);
        assert_eq!(code(Vec3::new(1.0, 0.0, 0.0), unit), 0b001);
        assert_eq!(code(Vec3::new(0.0, 3.0, 0.0), unit), 0b010_010);
        assert_eq!(code(Vec3::new(5.0, 1.0, 7.0), unit), 0b101_100_111);
        let most = f32::MAX;
        assert_eq!(code(Vec3::splat(most), unit), (1 << (3 * DIGITS)) - 1);
    }

    #[test]
    fn a_point_and_huge_meshes_have_an_order() {
        for size in [0.0, 1e-30, 1e18] {
            let positions = [Vec3::ZERO, Vec3::X, Vec3::Y].map(|p| p * size).to_vec();
            let mesh = Mesh {
                origin: glam::DVec3::ZERO,
                normals: vec![Vec3::Z; 3],
                triangles: vec![[0, 1, 2]],
                positions: positions.clone(),
            };
            assert_eq!(mesh.ordered().triangle_positions(0)[..], positions);
        }
    }
}
