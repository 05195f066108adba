//! A query's rays against one triangle.

use super::counters::count;
use super::kernel_rays::AnyQuery;
use crate::curved::bits::set_bits;
use crate::curved::curved_mesh::CurvedMesh;
use crate::embree::SurfaceHit;
use curvetri_method::{HitLanes, PackedTriangle, Ray};

/// Fewer rays than this are traced one by one.
pub(super) const MIN_PACKET: u32 = 3;

/// Offers the roots of the rays in the lanes of `valid`.
pub(super) fn trace_triangle<'a>(
    curved: &CurvedMesh,
    query: &mut impl AnyQuery<'a>,
    triangle: u32,
    valid: u32,
) {
    query.set_prim_id(triangle);
    let patch = curved.packed_triangle(triangle);
    if valid.count_ones() < MIN_PACKET {
        for lane in set_bits(valid) {
            let ray = query.kernel_ray(lane);
            offer_roots(curved, query, lane, &patch, ray);
        }
        return;
    }
    let normals = query.needs_normals();
    let hits = patch.intersect_packet(&query.rays(), valid, curved.solver, normals);
    count(1, valid.count_ones().into(), hits.evaluations.into());
    for lane in set_bits(hits.found) {
        if !query.report(lane, surface_hit(&hits, lane)) {
            offer_roots_beyond(curved, query, lane, &patch, hits.t[lane]);
        }
    }
}

/// Offers the roots of a lane's ray beyond one that was rejected.
pub(super) fn offer_roots_beyond<'a>(
    curved: &CurvedMesh,
    query: &mut impl AnyQuery<'a>,
    lane: usize,
    patch: &PackedTriangle<'_>,
    t: f32,
) {
    let ray = query.kernel_ray(lane);
    let rest = Ray {
        tnear: patch.beyond(&ray, t),
        ..ray
    };
    offer_roots(curved, query, lane, patch, rest);
}

/// Offers the roots of a lane's ray on a patch, nearest first, until one is accepted.
pub(super) fn offer_roots<'a>(
    curved: &CurvedMesh,
    query: &mut impl AnyQuery<'a>,
    lane: usize,
    patch: &PackedTriangle<'_>,
    mut ray: Ray<f32>,
) {
    let normals = query.needs_normals();
    let mut evaluations = 0;
    loop {
        let (hit, normal) = patch.intersect(&ray, curved.solver, normals);
        evaluations += u64::from(hit.evaluations);
        let (t, u, v) = (hit.t, hit.u, hit.v);
        let ng = normal.into();
        if !hit.found || query.report(lane, SurfaceHit { t, u, v, ng }) {
            break;
        }
        ray.tnear = patch.beyond(&ray, t);
    }
    count(1, 1, evaluations);
}

fn surface_hit(hits: &HitLanes, lane: usize) -> SurfaceHit {
    let [x, y, z] = hits.normal;
    SurfaceHit {
        t: hits.t[lane],
        u: hits.u[lane],
        v: hits.v[lane],
        ng: glam::vec3(x[lane], y[lane], z[lane]),
    }
}
