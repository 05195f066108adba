//! The functions that Embree calls.

use super::cluster_query::trace_cluster;
use super::counters::count_callback;
use super::kernel_rays::AnyQuery;
use super::triangle_query::trace_triangle;
use crate::curved::curved_mesh::CurvedMesh;
use crate::embree::{Bounds, IntersectQuery, OccludedQuery, UserGeometry};

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
    match &curved.clusters {
        Some(clusters) => trace_cluster(curved, query, &clusters[prim as usize], prim),
        None => trace_triangle(curved, query, prim, query.valid()),
    }
}
