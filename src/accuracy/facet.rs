//! The models' surfaces in `f64`.

use glam::DVec3;

use super::model::Model;
use super::probe::{Point, Probe};
use crate::bodies::{Body, BodyTriangle};
use crate::surface::{Patch, PatchFlags, Surface};

/// One triangle of a model.
enum Facet {
    /// The plane, with the patch that has the guides over it.
    Flat(Box<Patch<f64>>, [DVec3; 3]),
    Curved(Box<Patch<f64>>),
}

/// A body's triangles, taken for a model's.
pub(super) struct Facets(Vec<Facet>);

impl Facets {
    pub fn new(body: &Body, model: Model) -> Self {
        let facet = |t: &BodyTriangle| Facet::new(t, model);
        Self(body.triangles().iter().map(facet).collect())
    }
}

impl Facet {
    fn new(triangle: &BodyTriangle, model: Model) -> Self {
        let patch = |surface| {
            let positions = triangle.positions.map(Into::into);
            let normals = triangle.normals.map(Into::into);
            let flags = PatchFlags::new(surface).with_unchecked();
            Box::new(Patch::new(positions, normals, flags))
        };
        match model {
            Model::Flat => Facet::Flat(patch(Surface::Tensor), triangle.positions),
            Model::Curved(surface) => Facet::Curved(patch(surface)),
        }
    }

    fn normal(&self, [u, v]: [f64; 2]) -> DVec3 {
        match self {
            Facet::Flat(patch, _) => patch.plane_normal().into(),
            Facet::Curved(patch) => patch.normal_at(u, v).into(),
        }
    }
}

impl Probe for Facets {
    fn at(&self, triangle: usize, at: [f64; 2]) -> Option<Point> {
        let [u, v] = at;
        let facet = &self.0[triangle];
        let (position, line) = match facet {
            Facet::Flat(patch, corners) => (on_plane(*corners, at), patch.guide_at(u, v)),
            Facet::Curved(patch) => (patch.point(u, v).position.into(), patch.guide_at(u, v)),
        };
        Some(Point {
            position,
            normal: facet.normal(at),
            line: line.into(),
        })
    }

    fn normal_on_side(&self, triangle: usize, at: [f64; 2]) -> Option<DVec3> {
        Some(self.0[triangle].normal(at))
    }
}

/// The point of a triangle's plane with barycentric coordinates (u, v).
pub(super) fn on_plane([a, b, c]: [DVec3; 3], [u, v]: [f64; 2]) -> DVec3 {
    a + u * (b - a) + v * (c - a)
}
