//! The models' surfaces in `f64`.

use glam::DVec3;

use super::bezier::Bezier;
use super::model::SurfaceModel;
use super::probe::{ProbedPoint, SurfaceProbe};
use curvetri::method::{BoundsKind, Patch, PatchFlags, Ray, Solver, Surface};
use curvetri_bodies::BodyTriangle;

/// How far above the highest point of its surface a ray starts, in units of the triangle's size.
const CLEARANCE: f64 = 0.1;

/// One triangle of a model.
enum Facet {
    /// The plane, with the patch that has the guides over it.
    Flat(Box<Patch<f64>>, [DVec3; 3]),
    Curved(Box<Patch<f64>>),
    /// What rays by the paper's algorithm find.
    Paper(Box<Patch<f64>>, [DVec3; 3]),
    Peer(Bezier),
}

/// Triangles, taken for a model's.
pub(super) struct ModelFacets(Vec<Facet>);

impl ModelFacets {
    pub fn new(triangles: &[BodyTriangle], model: SurfaceModel) -> Self {
        Self(triangles.iter().map(|t| Facet::new(t, model)).collect())
    }
}

impl Facet {
    fn new(triangle: &BodyTriangle, model: SurfaceModel) -> Self {
        let patch = |surface, bounds| {
            let positions = triangle.positions.map(Into::into);
            let normals = triangle.normals.map(Into::into);
            let flags = PatchFlags::new(surface).with_unchecked();
            Box::new(Patch::new(positions, normals, flags.with_bounds(bounds)))
        };
        match model {
            SurfaceModel::Flat => Facet::Flat(
                patch(Surface::Tensor, BoundsKind::Tight),
                triangle.positions,
            ),
            SurfaceModel::Curved(surface) => Facet::Curved(patch(surface, BoundsKind::Tight)),
            SurfaceModel::Paper => Facet::Paper(
                patch(Surface::Angular, BoundsKind::Sphere),
                triangle.positions,
            ),
            SurfaceModel::Peer(peer) => Facet::Peer(Bezier::new(peer, triangle)),
        }
    }

    fn normal(&self, [u, v]: [f64; 2]) -> DVec3 {
        match self {
            Facet::Flat(patch, _) => patch.plane_normal().into(),
            Facet::Curved(patch) | Facet::Paper(patch, _) => patch.normal_at(u, v).into(),
            Facet::Peer(bezier) => {
                let [_, by_u, by_v] = bezier.at([u, v]);
                by_u.cross(by_v)
            }
        }
    }
}

impl SurfaceProbe for ModelFacets {
    fn at(&self, triangle: usize, at: [f64; 2]) -> Option<ProbedPoint> {
        let facet = &self.0[triangle];
        let guide = |patch: &Patch<f64>| Some(patch.guide_at(at[0], at[1]).into());
        let (position, line) = match facet {
            Facet::Flat(patch, corners) => (on_plane(*corners, at), guide(patch)),
            Facet::Curved(patch) => (patch.point(at[0], at[1]).position.into(), guide(patch)),
            Facet::Paper(patch, corners) => return down_guide(patch, *corners, at),
            Facet::Peer(bezier) => (bezier.at(at)[0], None),
        };
        Some(ProbedPoint {
            position,
            normal: facet.normal(at),
            line,
        })
    }

    fn normal_on_edge(&self, triangle: usize, at: [f64; 2]) -> Option<DVec3> {
        match &self.0[triangle] {
            Facet::Paper(patch, corners) => Some(down_guide(patch, *corners, at)?.normal),
            facet => Some(facet.normal(at)),
        }
    }
}

/// The first point that the paper's algorithm finds down the guide over (u, v).
fn down_guide(patch: &Patch<f64>, corners: [DVec3; 3], at: [f64; 2]) -> Option<ProbedPoint> {
    let (start, line) = above(patch, corners, at, patch.heights()[1]);
    let ray = Ray {
        origin: start.into(),
        direction: line.into(),
        tnear: 0.0,
        tfar: f64::INFINITY,
    };
    let hit = patch.intersect(&ray, Solver::ITA);
    hit.found.then(|| ProbedPoint {
        position: start + hit.t * line,
        normal: patch.normal_at(hit.u, hit.v).into(),
        line: Some(line),
    })
}

/// Where a ray down the guide over (u, v) starts, close above what reaches this height, and its
/// direction.
pub(super) fn above(
    patch: &Patch<f64>,
    corners: [DVec3; 3],
    at: [f64; 2],
    top: f64,
) -> (DVec3, DVec3) {
    let guide: DVec3 = patch.guide_at(at[0], at[1]).into();
    let start = on_plane(corners, at) + guide * (top + CLEARANCE * patch.size());
    (start, -guide)
}

/// The point of a triangle's plane with barycentric coordinates (u, v).
pub(super) fn on_plane([a, b, c]: [DVec3; 3], [u, v]: [f64; 2]) -> DVec3 {
    a + u * (b - a) + v * (c - a)
}
