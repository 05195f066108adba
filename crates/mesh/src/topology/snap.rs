//! Puts vertices that are meant to be one into one place.
//!
//! Programs write a corner that several parts or triangles share with rounding of their own, so
//! that it differs in the last digits: 1e-17 here and 0 there. Welding by exact position would leave
//! a crack there, too thin to be meant. So vertices nearer to each other than a millionth of the
//! edges around them become one, and also those that single precision hardly distinguishes. Only
//! vertices at open edges are looked at: where a surface is whole, however small its triangles are,
//! it stays as it is.

use glam::{DVec3, Vec3};
use rayon::prelude::*;

/// How near to each other, in lengths of the longest edges at them, vertices are one.
const TOLERANCE: f32 = 1e-6;

/// How many units in the last place of their coordinates they may be apart anyway, as long as that
/// is short (the second) against the edges.
const UNITS: f32 = 2.0;
const SHORT: f32 = 1e-3;

/// A direction along which no usual mesh lies in layers.
const DIRECTION: DVec3 = DVec3::new(0.541_196_1, 0.618_034, 0.570_796_3);

/// How many vertices are tried around one: so many only lie there in files made to be slow.
const MAX_TRIED: usize = 64;

/// Makes the corners at open places that are meant to be one name one of them; returns how many others there
/// are. No place moves by more than the tolerance: it goes to one that stays.
pub(crate) fn snap(places: &[Vec3], corners: &mut [[u32; 3]]) -> u64 {
    let open = open_places(corners, places.len());
    if open.is_empty() {
        return 0;
    }
    let reach = reaches(places, corners);
    let order = by_direction(places, open);
    let mut target: Vec<u32> = (0..places.len() as u32).collect();
    let mut snapped = 0;
    for (i, &(key, place)) in order.iter().enumerate() {
        let (p, r) = (places[place as usize], reach[place as usize]);
        let near = order[..i]
            .iter()
            .rev()
            .take(MAX_TRIED)
            .take_while(|(other, _)| key - other <= f64::from(r))
            .map(|&(_, other)| other as usize)
            // Going only to what stays keeps chains of near ones from moving far.
            .filter(|&other| target[other] as usize == other)
            .find(|&other| p.distance(places[other]) <= r.min(reach[other]));
        if let Some(near) = near {
            target[place as usize] = near as u32;
            snapped += 1;
        }
    }
    if snapped > 0 {
        corners
            .par_iter_mut()
            .for_each(|t| *t = t.map(|place| target[place as usize]));
    }
    snapped
}

/// The places at edges that are not matched by as many in the opposite direction.
fn open_places(corners: &[[u32; 3]], places: usize) -> Vec<u32> {
    // Every edge adds a number of its other end to what it leaves and takes one from what it
    // reaches: with its opposite that makes zero at both, and without hardly ever.
    let mut balance = vec![0u64; places];
    for t in corners {
        for k in 0..3 {
            let [a, b] = [t[k], t[(k + 1) % 3]];
            balance[a as usize] = balance[a as usize].wrapping_add(scattered(b));
            balance[b as usize] = balance[b as usize].wrapping_sub(scattered(a));
        }
    }
    (0..places as u32)
        .filter(|&place| balance[place as usize] != 0)
        .collect()
}

/// A number that looks random, the same for the same index (the end of splitmix64).
fn scattered(index: u32) -> u64 {
    let z = u64::from(index)
        .wrapping_add(1)
        .wrapping_mul(0x9e37_79b9_7f4a_7c15);
    let z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

/// How far from each place others are one with it; zero where no edge starts.
fn reaches(places: &[Vec3], corners: &[[u32; 3]]) -> Vec<f32> {
    let mut longest = vec![0.0f32; places.len()];
    for t in corners {
        for k in 0..3 {
            let [a, b] = [t[k], t[(k + 1) % 3]].map(|v| v as usize);
            let length = places[a].distance(places[b]);
            longest[a] = longest[a].max(length);
            longest[b] = longest[b].max(length);
        }
    }
    longest
        .par_iter()
        .zip(places)
        .map(|(&length, p)| {
            let unit = UNITS * f32::EPSILON * p.abs().max_element();
            (TOLERANCE * length).max(unit.min(SHORT * length))
        })
        .collect()
}

/// Some places sorted along a direction, with how far along it they are.
fn by_direction(places: &[Vec3], some: Vec<u32>) -> Vec<(f64, u32)> {
    let key = |place: u32| places[place as usize].as_dvec3().dot(DIRECTION);
    let some = some.into_par_iter();
    let mut order: Vec<(f64, u32)> = some.map(|place| (key(place), place)).collect();
    order.par_sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    order
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use crate::{LoadReport, Mesh, NormalOptions, RawMesh, Topology};

    /// Two triangles of this size at this place, with an edge that differs by `gap` at one end.
    fn pair(size: f64, at: f64, gap: f64) -> (Mesh, LoadReport) {
        let corners = [[0., 0.], [1., 0.], [0., 1.], [1., 0.], [1., 1.], [0., 1.]];
        let mut positions = corners.map(|[x, y]| DVec3::new(size * x + at, size * y, 0.0));
        positions[3].y += gap;
        let raw = RawMesh {
            positions: positions.to_vec(),
            corners: vec![[0, 1, 2], [3, 4, 5]],
            ..RawMesh::default()
        };
        raw.into_mesh(&NormalOptions::default()).unwrap()
    }

    fn joined(size: f64, at: f64, gap: f64) -> bool {
        let (mesh, report) = pair(size, at, gap);
        let smooth = Topology::new(&mesh).counts().smooth;
        assert_eq!(report.snapped, u64::from(smooth == 1 && gap != 0.0));
        smooth == 1
    }

    #[test]
    fn what_lies_within_a_millionth_of_a_side_is_one_at_any_size() {
        for size in [1e-12, 1.0, 1e12] {
            assert!(joined(size, 0.0, 0.0));
            assert!(joined(size, 0.0, 1e-17 * size));
            assert!(joined(size, 0.0, 1e-6 * size));
            assert!(!joined(size, 0.0, 2e-6 * size));
        }
    }

    #[test]
    fn what_single_precision_hardly_distinguishes_is_one() {
        // So near the origin that it stays there; units in the last place are 2.4e-7.
        assert!(joined(0.5, 3.9, 0.0));
        let (mesh, _) = pair(0.5, 3.9, 0.0);
        assert_eq!(mesh.origin(), DVec3::ZERO);
        let (mesh, report) = pair(0.5, 3.9, 6e-7);
        assert_eq!(
            (Topology::new(&mesh).counts().smooth, report.snapped),
            (1, 1)
        );
    }

    #[test]
    fn small_triangles_beside_large_ones_stay() {
        // A thin triangle of a thousandth of the others' size.
        let positions = [[0., 0.], [1., 0.], [0., 1.], [-1e-3, 1.], [-1e-3, 0.]];
        let raw = RawMesh {
            positions: positions.map(|[x, y]| DVec3::new(x, y, 0.0)).to_vec(),
            corners: vec![[0, 1, 2], [0, 2, 3], [0, 3, 4]],
            ..RawMesh::default()
        };
        let (mesh, report) = raw.into_mesh(&NormalOptions::default()).unwrap();
        assert_eq!((mesh.positions().len(), report.snapped), (5, 0));
    }

    #[test]
    fn a_whole_surface_stays_as_small_as_it_is() {
        // A tetrahedron with a corner that nearly touches another.
        let positions = [[0., 0., 0.], [1., 0., 0.], [0., 1., 0.], [1e-7, 0., 1e-7]];
        let raw = RawMesh {
            positions: positions.map(DVec3::from).to_vec(),
            corners: vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]],
            ..RawMesh::default()
        };
        let (mesh, report) = raw.into_mesh(&NormalOptions::default()).unwrap();
        assert_eq!(
            (Topology::new(&mesh).counts().places, report.snapped),
            (4, 0)
        );
    }

    #[test]
    fn a_row_of_near_vertices_does_not_run_together() {
        // Triangles from a far point to a row of points, each near enough to the next.
        let step = 0.9e-6;
        let mut positions = vec![DVec3::X];
        positions.extend((0..200).map(|k| DVec3::Y * (step * f64::from(k))));
        let corners = (1..200).map(|k| [0, k, k + 1]).collect();
        let raw = RawMesh {
            positions: positions.clone(),
            corners,
            ..RawMesh::default()
        };
        let (mesh, report) = raw.into_mesh(&NormalOptions::default()).unwrap();
        assert_eq!(report.snapped, 100);
        for (t, &[_, b, _]) in mesh.triangles().iter().enumerate() {
            let moved = mesh.world_position(b as usize).distance(positions[t + 1]);
            assert!(moved <= 1e-6, "{moved}");
        }
    }
}
