//! The Embree callbacks of a curved mesh.

use std::ops::DerefMut;

use super::CurvedMesh;
use super::cluster::{Cluster, SIZE};
use super::counters::{count, count_callback};
use super::laid::Laid;
use crate::embree::{Bounds, IntersectQuery, OccludedQuery, QueryRays, SurfaceHit, UserGeometry};
use crate::method::{HitLanes, PackedTriangle, PatchBlock, Ray, RayLanes, Real, Solver};

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
        self.trace(query, true, IntersectQuery::report);
    }

    fn occluded(&self, query: &mut OccludedQuery<'_>) {
        // Only filters look at the hit.
        let normals = query.has_filters();
        self.trace(query, normals, OccludedQuery::report);
    }
}

/// Fewer valid lanes than this are traced one by one.
const MIN_PACKET: u32 = 3;

/// The lanes of a mask of one bit a lane.
fn lanes(mut mask: u32) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        let lane = mask.trailing_zeros();
        mask &= mask.wrapping_sub(1);
        (lane < u32::BITS).then_some(lane as usize)
    })
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

/// The lane's ray from beyond a root that was rejected.
fn rest_of_ray(patch: &PackedTriangle<'_>, query: &QueryRays<'_>, lane: usize, t: f32) -> Ray<f32> {
    let ray = kernel_ray(&query.ray(lane));
    Ray {
        tnear: patch.beyond(&ray, t),
        ..ray
    }
}

impl CurvedMesh {
    /// Offers the roots of a query's rays on its primitive, with the surface's normals there if
    /// `normals`, else zeros.
    fn trace<'a, Q: DerefMut<Target = QueryRays<'a>>>(
        &self,
        query: &mut Q,
        normals: bool,
        report: impl Fn(&mut Q, usize, SurfaceHit) -> bool + Copy,
    ) {
        count_callback();
        let prim = query.prim_id();
        let Some(clusters) = &self.clusters else {
            return self.trace_triangle(query, prim, query.valid(), normals, report);
        };
        let cluster = &clusters[prim as usize];
        if query.valid().count_ones() < MIN_PACKET {
            for lane in query.lanes() {
                self.trace_lane(query, cluster, lane, normals, report);
            }
            return;
        }
        let mut left = cluster.present();
        if matches!(self.solver, Solver::Bracketing { .. }) {
            let met = cluster.packet_met(&ray_lanes(query), query.valid());
            left = self.trace_block(query, (prim, cluster), &met, normals, report);
            if left == 0 {
                return;
            }
        }
        let mut entries = cluster.packet_entries(&ray_lanes(query), query.valid());
        entries.keep(left);
        // Lanes that are occluded by now are valid no more.
        while let Some((n, lanes)) = entries.next(query.tfar(), query.valid()) {
            self.trace_triangle(query, cluster.triangle(n), lanes, normals, report);
        }
    }

    /// Offers the roots of one ray of a query on a cluster's triangles.
    fn trace_lane<'a, Q: DerefMut<Target = QueryRays<'a>>>(
        &self,
        query: &mut Q,
        cluster: &Cluster,
        lane: usize,
        normals: bool,
        report: impl Fn(&mut Q, usize, SurfaceHit) -> bool,
    ) {
        let mut entries = cluster.entries(&query.ray(lane));
        // All are read before anything is done with one: then the processor waits for them side by side.
        let mut patches = [None; SIZE];
        for n in lanes(entries.met) {
            patches[n] = Some(self.kept(cluster.triangle(n)));
        }
        while let Some(n) = entries.next(query.tfar()[lane]) {
            if let Some(patch) = &patches[n] {
                query.set_prim_id(cluster.triangle(n));
                let ray = kernel_ray(&query.ray(lane));
                self.offer_roots(patch, ray, normals, |hit| report(query, lane, hit));
            }
        }
    }

    /// Offers the first roots of a query's rays on those triangles of a cluster that can be laid out side by
    /// side, for each of the rays in the lanes of `met`; gives the places of the others that rays may meet, one
    /// bit each.
    fn trace_block<'a, Q: DerefMut<Target = QueryRays<'a>>>(
        &self,
        query: &mut Q,
        (prim, cluster): (u32, &Cluster),
        met: &[u32; SIZE],
        normals: bool,
        report: impl Fn(&mut Q, usize, SurfaceHit) -> bool,
    ) -> u32 {
        let asked = met.iter().enumerate();
        let asked = asked.fold(0, |asked, (n, &lanes)| asked | u32::from(lanes != 0) << n);
        if asked == 0 {
            return 0;
        }
        let pairs = met.iter().map(|lanes| lanes.count_ones()).sum::<u32>();
        // On very fine meshes rays that come by later would not find it laid out any more.
        if pairs == 1 && !Laid::has(self.number, prim) {
            let n = asked.trailing_zeros() as usize;
            self.trace_triangle(query, cluster.triangle(n), met[n], normals, report);
            return 0;
        }
        let mut laid = 0;
        let hits = Laid::trace(
            self.number,
            prim,
            |block| self.lay(block, cluster),
            |block, hits| {
                laid = asked & block.unpacked();
                block.intersect_packet(&ray_lanes(query), met, self.solver, normals, hits);
            },
        );
        let tested = (0..SIZE).filter(|n| laid & 1 << n != 0);
        let calls = tested.map(|n| met[n].count_ones()).sum::<u32>();
        let evaluations = hits.evaluations.into();
        count(laid.count_ones().into(), calls.into(), evaluations);
        for hit in hits.iter() {
            let (triangle, lane) = (cluster.triangle(hit.patch), hit.lane);
            query.set_prim_id(triangle);
            let (t, u, v) = (hit.t, hit.u, hit.v);
            let ng = hit.normal.into();
            let counts = report(query, lane, SurfaceHit { t, u, v, ng });
            // Without filters only a nearer hit stands against one.
            if !counts && query.has_filters() && query.valid() & 1 << lane != 0 {
                let patch = self.kept(triangle);
                let ray = rest_of_ray(&patch, query, lane, t);
                self.offer_roots(&patch, ray, normals, |hit| report(query, lane, hit));
            }
        }
        Laid::keep(hits);
        asked & !laid
    }

    /// Lays out what can be of a cluster: at once, as rays that come by one triangle come by its neighbours.
    fn lay(&self, block: &mut PatchBlock, cluster: &Cluster) {
        let mut triangles = [None; SIZE];
        for n in lanes(cluster.present()) {
            let triangle = self.kept(cluster.triangle(n));
            triangles[n] = triangle.fits_block().then_some(triangle);
        }
        block.unpack(&triangles);
    }

    /// Offers the roots of some of a query's rays on a triangle.
    fn trace_triangle<'a, Q: DerefMut<Target = QueryRays<'a>>>(
        &self,
        query: &mut Q,
        triangle: u32,
        valid: u32,
        normals: bool,
        report: impl Fn(&mut Q, usize, SurfaceHit) -> bool,
    ) {
        query.set_prim_id(triangle);
        let patch = self.kept(triangle);
        if valid.count_ones() < MIN_PACKET {
            for lane in lanes(valid) {
                let ray = kernel_ray(&query.ray(lane));
                self.offer_roots(&patch, ray, normals, |hit| report(query, lane, hit));
            }
            return;
        }
        let hits = self.packet_hits(&patch, query, valid, normals);
        for lane in lanes(hits.found) {
            if !report(query, lane, surface_hit(&hits, lane)) {
                let ray = rest_of_ray(&patch, query, lane, hits.t[lane]);
                self.offer_roots(&patch, ray, normals, |hit| report(query, lane, hit));
            }
        }
    }

    /// The first roots of some rays of a query.
    fn packet_hits(
        &self,
        patch: &PackedTriangle<'_>,
        query: &QueryRays<'_>,
        valid: u32,
        normals: bool,
    ) -> HitLanes {
        let hits = patch.intersect_packet(&ray_lanes(query), valid, self.solver, normals);
        count(1, valid.count_ones().into(), hits.evaluations.into());
        hits
    }

    /// Reports the ray's roots on a patch, nearest first, until one is accepted.
    fn offer_roots(
        &self,
        patch: &PackedTriangle<'_>,
        mut ray: Ray<f32>,
        normals: bool,
        mut report: impl FnMut(SurfaceHit) -> bool,
    ) {
        let mut evaluations = 0;
        loop {
            let (hit, normal) = patch.intersect(&ray, self.solver, normals);
            evaluations += u64::from(hit.evaluations);
            let (t, u, v) = (hit.t, hit.u, hit.v);
            let ng = normal.into();
            if !hit.found || report(SurfaceHit { t, u, v, ng }) {
                break;
            }
            ray.tnear = patch.beyond(&ray, t);
        }
        count(1, 1, evaluations);
    }

    /// How far the true surface may be from the point `origin + t direction` of a hit on a
    /// triangle, along the surface's normal, in the units of the positions.
    ///
    /// A secondary ray that starts this far off the surface, on the side it leaves to, does not
    /// meet the surface it starts from; nothing thicker is needed, so that no light leaks where
    /// surfaces come close.
    ///
    /// # Panics
    /// If there is no such triangle.
    pub fn error_bound(&self, triangle: u32, ray: &crate::embree::Ray, t: f32) -> f32 {
        let positions = super::corners(&self.mesh, triangle as usize).positions;
        let extent = (positions[1] - positions[0])
            .max_abs()
            .greater((positions[2] - positions[0]).max_abs());
        let reach = ray.origin.abs().max_element() + t * ray.direction.abs().max_element();
        let ulps = if self.is_apart(triangle) {
            APART_ULPS
        } else {
            RAY_ULPS
        };
        f32::EPSILON * (SIZE_ULPS * extent + ulps * (reach + positions[0].max_abs()))
    }
}

/// Share of the error bound that comes with the triangle's size: rounding inside the kernel.
const SIZE_ULPS: f32 = 64.0;
/// Share that comes with coordinates and distance: rounding of the ray's points.
const RAY_ULPS: f32 = 4.0;
/// The same of triangles that Embree traces.
const APART_ULPS: f32 = 8.0;

fn ray_lanes<'a>(query: &'a QueryRays<'_>) -> RayLanes<'a> {
    RayLanes {
        origin: [query.org_x(), query.org_y(), query.org_z()],
        direction: [query.dir_x(), query.dir_y(), query.dir_z()],
        tnear: query.tnear(),
        tfar: query.tfar(),
    }
}

fn kernel_ray(ray: &crate::embree::Ray) -> Ray<f32> {
    Ray {
        origin: ray.origin.into(),
        direction: ray.direction.into(),
        tnear: ray.tnear,
        tfar: ray.tfar,
    }
}
