//! The surfaces as rays through Embree find them.

use std::sync::Arc;

use glam::DVec3;

use super::facet::above;
use super::model::SurfaceModel;
use super::probe::{ProbedPoint, SurfaceProbe};
use super::sampling;
use curvetri::curved::{CurvedMesh, CurvedOptions};
use curvetri::embree::{
    Candidate, Device, Error, Geometry, Hit, QueryOptions, Ray, RayPacket, Scene, SceneBuilder,
    flush_denormals,
};
use curvetri::mesh::Mesh;
use curvetri::method::Patch;
use curvetri_bodies::Body;

/// How far inside an edge rays are shot for the normals of flat triangles there, in barycentric
/// coordinates: at the edge itself Embree gives the point to one of the two.
const INSIDE: f64 = 1e-3;

/// A body under an Embree tree.
pub(super) struct TracedBody {
    scene: Scene,
    mesh: Arc<Mesh>,
    /// What the guides are taken from.
    patches: Vec<Patch<f64>>,
    flat: bool,
}

impl TracedBody {
    pub fn new(device: &Device, body: &Body, model: SurfaceModel) -> Result<Self, Error> {
        let flat = model == SurfaceModel::Flat;
        let curved = match model {
            // For the guides over them.
            SurfaceModel::Flat => CurvedOptions::default(),
            _ => (model.options()).expect("rays are traced against our own surfaces only"),
        };
        let mesh = Arc::new(body.mesh());
        let options = CurvedOptions {
            unchecked: true,
            ..curved
        };
        let curved = Arc::new(CurvedMesh::new(mesh.clone(), &options));
        let geometry = if flat {
            Geometry::triangles(device, mesh.positions(), mesh.triangles())?
        } else {
            Geometry::user(device, curved.clone())?
        };
        let patches = (0..mesh.triangles().len() as u32).map(|t| curved.oracle(t));
        let mut builder = SceneBuilder::new(device)?.robust(true).query_filters(true);
        builder.attach(&geometry.commit()?);
        Ok(Self {
            scene: builder.commit()?,
            patches: patches.collect(),
            mesh,
            flat,
        })
    }

    /// The ray down the guide over (u, v), starting close above the surface.
    fn ray(&self, triangle: usize, at: [f64; 2]) -> Ray {
        let patch = &self.patches[triangle];
        let corners = self.mesh.triangle_positions(triangle).map(|p| p.as_dvec3());
        let top = if self.flat { 0.0 } else { patch.heights()[1] };
        let (start, line) = above(patch, corners, at, top);
        Ray::new(start.as_vec3(), line.as_vec3())
    }

    fn first(&self, ray: &Ray, options: &QueryOptions<'_>) -> Option<Hit> {
        let _flush = flush_denormals();
        let mut packet = RayPacket::<1>::from_rays([ray]);
        self.scene.intersect(&mut packet, options);
        packet.hit(0)
    }
}

impl SurfaceProbe for TracedBody {
    fn at(&self, triangle: usize, at: [f64; 2]) -> Option<ProbedPoint> {
        let ray = self.ray(triangle, at);
        let hit = self.first(&ray, &QueryOptions::INCOHERENT)?;
        let (origin, line) = (ray.origin.as_dvec3(), ray.direction.as_dvec3());
        Some(ProbedPoint {
            position: origin + f64::from(hit.t) * line,
            normal: hit.ng.as_dvec3(),
            line: Some(line),
        })
    }

    fn normal_on_edge(&self, triangle: usize, at: [f64; 2]) -> Option<DVec3> {
        let at = if self.flat {
            sampling::inset(at, INSIDE)
        } else {
            at
        };
        // Both neighbours reach a little over their edge, so each has a hit on its guides.
        let own = |candidate: &Candidate| candidate.hit.prim_id == triangle as u32;
        let ray = self.ray(triangle, at);
        let options = QueryOptions::INCOHERENT.with_filter(&own);
        Some(self.first(&ray, &options)?.ng.as_dvec3())
    }
}
