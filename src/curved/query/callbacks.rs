//! The functions that Embree calls.

use super::cluster_query::trace_cluster;
use super::counters::count_callback;
use super::far_rays::{MovedQuery, far_lanes};
use super::kernel_rays::AnyQuery;
use super::triangle_query::trace_triangle;
use crate::curved::curved_mesh::CurvedMesh;
use crate::curved::triangle;
use crate::embree::{Bounds, IntersectQuery, OccludedQuery, UserGeometry};
use curvetri_method::Real;
use glam::Vec3;

impl UserGeometry for CurvedMesh {
    fn primitives(&self) -> u32 {
        // A mesh holds at most 2^31 index values, so this fits.
        let count = self
            .clusters
            .as_ref()
            .map_or(self.records.len(), |clusters| clusters.len());
        count as u32
    }

    fn bounds(&self, prim: u32, _time_step: u32) -> Bounds {
        match &self.clusters {
            Some(clusters) => clusters[prim as usize].bounds(),
            None => self.triangle_bounds(prim),
        }
    }

    fn intersect(&self, query: &mut IntersectQuery<'_>) {
        trace(self, query);
    }

    fn occluded(&self, query: &mut OccludedQuery<'_>) {
        trace(self, query);
    }
}

/// Offers the roots of a query's rays on its primitive.
fn trace<'a>(curved: &CurvedMesh, query: &mut impl AnyQuery<'a>) {
    count_callback();
    let prim = query.prim_id();
    let (middle, extent) = whereabouts(curved, prim);
    match far_lanes(query, middle, extent) {
        0 => trace_primitive(curved, query, prim),
        far => trace_moved(curved, query, prim, far),
    }
}

/// Around which point a primitive lies, and how far about it reaches from there.
#[inline(always)]
fn whereabouts(curved: &CurvedMesh, prim: u32) -> (Vec3, f32) {
    match &curved.clusters {
        Some(clusters) => {
            let cluster = &clusters[prim as usize];
            (cluster.middle(), cluster.extent())
        }
        None => {
            let [a, b, c] = triangle::vertices(&curved.mesh, prim as usize).positions;
            ((a.into()), (b - a).max_abs().greater((c - a).max_abs()))
        }
    }
}

fn trace_primitive<'a>(curved: &CurvedMesh, query: &mut impl AnyQuery<'a>, prim: u32) {
    match &curved.clusters {
        Some(clusters) => trace_cluster(curved, query, &clusters[prim as usize], prim),
        None => trace_triangle(curved, query, prim, query.valid()),
    }
}

/// The same, with the rays of some lanes moved to near the primitive.
#[cold]
#[inline(never)]
fn trace_moved<'a>(curved: &CurvedMesh, query: &mut impl AnyQuery<'a>, prim: u32, far: u32) {
    let (middle, _) = whereabouts(curved, prim);
    trace_primitive(curved, &mut MovedQuery::new(query, far, middle), prim);
}
