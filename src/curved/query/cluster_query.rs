//! A query's rays against a cluster of triangles.

use super::block_cache::BlockCache;
use super::counters::count;
use super::kernel_rays::AnyQuery;
use super::triangle_query::{MIN_PACKET, offer_roots, offer_roots_beyond, trace_triangle};
use crate::curved::bits::set_bits;
use crate::curved::cluster::{Cluster, PacketEntries, RayEntries, SIZE, lanes_in_boxes};
use crate::curved::curved_mesh::CurvedMesh;
use crate::embree::SurfaceHit;
use curvetri_method::{PatchBlock, Solver};

/// Offers the roots of a query's rays on the triangles of a cluster, of which `number` is the number.
pub(super) fn trace_cluster<'a>(
    curved: &CurvedMesh,
    query: &mut impl AnyQuery<'a>,
    cluster: &Cluster,
    number: u32,
) {
    if query.valid().count_ones() < MIN_PACKET {
        for lane in set_bits(query.valid()) {
            trace_ray(curved, query, cluster, lane);
        }
        return;
    }
    let mut left = cluster.present();
    if matches!(curved.solver, Solver::Bracketing { .. }) {
        left = trace_block(curved, query, cluster, number);
        if left == 0 {
            return;
        }
    }
    let mut entries = PacketEntries::new(cluster, left, &query.rays(), query.valid());
    // Lanes that are occluded by now are valid no more.
    while let Some((n, lanes)) = entries.next(query.rays().tfar, query.valid()) {
        trace_triangle(curved, query, cluster.triangle(n), lanes);
    }
}

/// Offers the roots of one ray on the triangles of a cluster.
fn trace_ray<'a>(
    curved: &CurvedMesh,
    query: &mut impl AnyQuery<'a>,
    cluster: &Cluster,
    lane: usize,
) {
    let mut entries = RayEntries::new(cluster, &query.kernel_ray(lane));
    // All are read before anything is done with one: the processor waits for all of them at once then.
    let mut patches = [None; SIZE];
    for n in set_bits(entries.boxes()) {
        patches[n] = Some(curved.packed_triangle(cluster.triangle(n)));
    }
    while let Some(n) = entries.next(query.rays().tfar[lane]) {
        if let Some(patch) = &patches[n] {
            query.set_prim_id(cluster.triangle(n));
            let ray = query.kernel_ray(lane);
            offer_roots(curved, query, lane, patch, ray);
        }
    }
}

/// Offers the first roots of a query's rays on those triangles of a cluster that fit a block of unpacked
/// patches, for all pairs of a ray and a triangle at once. Returns the places of the other triangles whose
/// boxes rays hit, one bit each.
fn trace_block<'a>(
    curved: &CurvedMesh,
    query: &mut impl AnyQuery<'a>,
    cluster: &Cluster,
    number: u32,
) -> u32 {
    let lanes = lanes_in_boxes(cluster, &query.rays(), query.valid());
    let places = lanes.iter().enumerate();
    let places = places.fold(0, |all, (n, &lanes)| all | u32::from(lanes != 0) << n);
    if places == 0 {
        return 0;
    }
    let pairs = lanes.iter().map(|lanes| lanes.count_ones()).sum::<u32>();
    // On very fine meshes the block would not be in the cache any more when the next rays come.
    if pairs == 1 && !BlockCache::contains((curved.id, number)) {
        let n = places.trailing_zeros() as usize;
        trace_triangle(curved, query, cluster.triangle(n), lanes[n]);
        return 0;
    }
    let (mut unpacked, normals) = (0, query.needs_normals());
    let hits = BlockCache::trace(
        (curved.id, number),
        |block| unpack(curved, block, cluster),
        |block, hits| {
            unpacked = places & block.unpacked();
            block.intersect_packet(&query.rays(), &lanes, curved.solver, normals, hits);
        },
    );
    let calls = set_bits(unpacked)
        .map(|n| lanes[n].count_ones())
        .sum::<u32>();
    let evaluations = hits.evaluations.into();
    count(unpacked.count_ones().into(), calls.into(), evaluations);
    for hit in hits.iter() {
        let (triangle, lane) = (cluster.triangle(hit.patch), hit.lane);
        query.set_prim_id(triangle);
        let (t, u, v) = (hit.t, hit.u, hit.v);
        let ng = hit.normal.into();
        let counts = query.report(lane, SurfaceHit { t, u, v, ng });
        // Without filters a hit is rejected only where there is a nearer one.
        let goes_on = query.valid() & 1 << lane != 0 && t <= query.rays().tfar[lane];
        if !counts && query.may_reject() && goes_on {
            let patch = curved.packed_triangle(triangle);
            offer_roots_beyond(curved, query, lane, &patch, t);
        }
    }
    BlockCache::give_back(hits);
    places & !unpacked
}

/// Unpacks all triangles of a cluster that fit, also those that these rays do not need: rays that hit the box
/// of one triangle are followed by rays that hit its neighbours'.
fn unpack(curved: &CurvedMesh, block: &mut PatchBlock, cluster: &Cluster) {
    let mut triangles = [None; SIZE];
    for n in set_bits(cluster.present()) {
        let triangle = curved.packed_triangle(cluster.triangle(n));
        triangles[n] = triangle.fits_block().then_some(triangle);
    }
    block.unpack(&triangles);
}
