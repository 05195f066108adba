//! A mesh in random order.

use glam::Vec3;

use curvetri::mesh::Mesh;
use curvetri_bodies::SplitMix;

/// The same mesh with its vertices and its triangles in random order, the same at each call.
pub(super) fn shuffled(mesh: &Mesh) -> Mesh {
    let mut random = SplitMix::new(11);
    let places = permutation(mesh.positions().len(), &mut random);
    let order = permutation(mesh.triangles().len(), &mut random);
    let moved = |from: &[Vec3]| {
        let mut to = vec![Vec3::ZERO; from.len()];
        for (&place, &value) in places.iter().zip(from) {
            to[place as usize] = value;
        }
        to
    };
    let triangle = |&n: &u32| mesh.triangles()[n as usize].map(|v| places[v as usize]);
    Mesh::from_local(
        mesh.origin(),
        moved(mesh.positions()),
        moved(mesh.normals()),
        order.iter().map(triangle).collect(),
    )
}

/// The numbers below `count` in random order.
fn permutation(count: usize, random: &mut SplitMix) -> Vec<u32> {
    let mut numbers: Vec<u32> = (0..count as u32).collect();
    random.shuffle(&mut numbers);
    numbers
}

#[cfg(test)]
mod tests {
    use super::*;
    use curvetri_bodies::Blob;

    #[test]
    fn the_triangles_are_the_same_in_another_order() {
        let mesh = Blob::default().mesh();
        let other = shuffled(&mesh);
        let corners = |mesh: &Mesh| {
            let all = 0..mesh.triangles().len();
            let bits = |p: Vec3| p.to_array().map(f32::to_bits);
            all.map(|t| {
                (
                    mesh.triangle_positions(t).map(bits),
                    mesh.triangle_normals(t).map(bits),
                )
            })
            .collect::<Vec<_>>()
        };
        let (mut before, mut after) = (corners(&mesh), corners(&other));
        assert_ne!(before, after);
        before.sort_unstable();
        after.sort_unstable();
        assert_eq!(before, after);
    }
}
