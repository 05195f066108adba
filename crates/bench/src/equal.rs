//! How finely the curved surface has to be cut for flat triangles to be as near to the true one.

use glam::DVec3;
use rayon::prelude::*;

use curvetri::curved::CurvedMesh;
use curvetri::method::PatchKind;

/// The distance of a point from the true surface, to first order.
pub type Truth = fn(DVec3) -> f64;

/// Triangles that are looked at.
const TRIANGLES: usize = 4000;
/// Points an edge of the grid on each.
const GRID: u32 = 8;
/// No cut is finer.
const FINEST: u32 = 1000;

/// Errors of a mesh's flat triangles and of its curved ones.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SurfaceErrors {
    /// The greatest distance to the true surface, flat and curved.
    pub greatest: [f64; 2],
    /// The mean distance.
    pub mean: [f64; 2],
}

impl SurfaceErrors {
    /// Measures a mesh against its true surface.
    #[must_use]
    pub fn of(curved: &CurvedMesh, truth: impl Fn(DVec3) -> f64 + Sync) -> Self {
        let count = curved.mesh().triangles().len();
        let step = count.div_ceil(TRIANGLES).max(1);
        let measured: Vec<[f64; 2]> = (0..count)
            .into_par_iter()
            .step_by(step)
            .flat_map_iter(|triangle| points(curved, triangle as u32))
            .map(|points| points.map(|p| truth(curved.mesh().origin() + p).abs()))
            .collect();
        let mut errors = Self::default();
        for which in 0..2 {
            let of = measured.iter().map(|errors| errors[which]);
            errors.greatest[which] = of.clone().fold(0.0, f64::max);
            errors.mean[which] = of.sum::<f64>() / measured.len().max(1) as f64;
        }
        errors
    }

    /// Into how many parts edges are to be cut, for errors that fall with the square of it. The
    /// outline is off by as much as the greatest error is.
    #[must_use]
    pub fn parts(&self) -> u32 {
        let [flat, curved] = self.greatest;
        let parts = (flat / curved.max(f64::MIN_POSITIVE)).sqrt().ceil();
        (parts as u32).clamp(1, FINEST)
    }
}

/// Points of a triangle, each flat and curved.
fn points(curved: &CurvedMesh, triangle: u32) -> impl Iterator<Item = [DVec3; 2]> {
    let patch = curved.oracle(triangle);
    let [a, b, c] = curved
        .mesh()
        .triangle_positions(triangle as usize)
        .map(|p| p.as_dvec3());
    let inside = (0..GRID).flat_map(|j| (0..GRID - j).map(move |i| [i, j]));
    let exists = patch.kind() != PatchKind::Degenerate;
    inside.filter(move |_| exists).map(move |place| {
        let [u, v] = place.map(|n| (f64::from(n) + 1.0 / 3.0) / f64::from(GRID));
        let point = patch.point(u, v).position;
        let flat = a + u * (b - a) + v * (c - a);
        [flat, DVec3::new(point.x, point.y, point.z)]
    })
}
