//! A packet of rays against one patch, on SIMD lanes: the kernel's one source over [`Lanes`], for
//! whatever instruction set the processor turns out to have.

use fearless_simd::{Level, dispatch, prelude::*};

use super::hit::{Hit, Solver};
use super::lane_search::{search_lanes, trace_one};
use super::ray::Ray;
use super::single::EdgesInLanes;
use crate::numbers::{LaneMask, Lanes, MAX_LANES, Vector, inlined, vector};
use crate::store::PackedTriangle;

/// Up to 16 rays, one slice a component, all of the same length.
#[derive(Clone, Copy, Debug)]
pub struct RayLanes<'a> {
    /// Where `t = 0`: x, y and z.
    pub origin: [&'a [f32]; 3],
    /// The way for one unit of `t`: x, y and z.
    pub direction: [&'a [f32]; 3],
    /// Least parameters of a hit.
    pub tnear: &'a [f32],
    /// Greatest parameters of a hit.
    pub tfar: &'a [f32],
}

/// Where the rays of a packet meet the surface first.
#[derive(Clone, Copy, Debug)]
pub struct HitLanes {
    /// The lanes that do, one bit a lane; the other fields are undefined elsewhere.
    pub found: u32,
    /// The rays' parameters.
    pub t: [f32; MAX_LANES],
    /// `b2` at the guides' feet.
    pub u: [f32; MAX_LANES],
    /// `b3` at the guides' feet.
    pub v: [f32; MAX_LANES],
    /// The surface's own geometric normals, unit, x, y and z; only where requested.
    pub normal: [[f32; MAX_LANES]; 3],
    /// How often the surface was evaluated, the sum over the lanes.
    pub evaluations: u32,
}

/// What is requested of a packet.
#[derive(Clone, Copy, Debug)]
struct Request {
    valid: u32,
    solver: Solver,
    normals: bool,
}

impl PackedTriangle<'_> {
    /// The first hits with `tnear <= t <= tfar` of the lanes of `valid` (one bit a lane), with the
    /// surface's normals there if `normals`.
    ///
    /// Every lane's answer is bit for bit that of [`Patch::intersect`](crate::Patch::intersect) and
    /// [`Patch::normal_at`](crate::Patch::normal_at) for its ray alone. Lanes that are not valid may
    /// hold anything.
    ///
    /// # Panics
    /// If the slices differ in length, or there are more than 16 rays.
    ///
    /// ```
    /// use curvetri_method::{
    ///     BuiltPatch, HitLanes, PackedPatch, PackedTriangle, PatchFlags, RayLanes, Solver,
    ///     TriangleVertices, vector,
    /// };
    ///
    /// let c = 1.0 / 3f32.sqrt();
    /// let positions = [vector(c, c, c), vector(c, -c, -c), vector(-c, c, -c)];
    /// let vertices = TriangleVertices { positions, normals: positions };
    /// let packed: PackedPatch = BuiltPatch::new(&vertices, PatchFlags::default()).packed;
    /// let triangle = PackedTriangle::new(vertices, &packed);
    ///
    /// // Two rays; the second runs the other way.
    /// let rays = RayLanes {
    ///     origin: [&[5.0 * c; 2], &[5.0 * c; 2], &[-5.0 * c; 2]],
    ///     direction: [&[-c, c], &[-c, c], &[c, -c]],
    ///     tnear: &[0.0; 2],
    ///     tfar: &[f32::INFINITY; 2],
    /// };
    /// let hits: HitLanes = triangle.intersect_packet(&rays, 0b11, Solver::default(), false);
    /// assert_eq!(hits.found, 0b01);
    /// assert!((hits.t[0] - 4.0).abs() < 1e-5);
    /// ```
    pub fn intersect_packet(
        &self,
        rays: &RayLanes<'_>,
        valid: u32,
        solver: Solver,
        normals: bool,
    ) -> HitLanes {
        self.intersect_packet_at(Level::new(), rays, valid, solver, normals)
    }

    /// The same with the instructions of one level.
    #[inline(always)]
    pub(crate) fn intersect_packet_at(
        &self,
        level: Level,
        rays: &RayLanes<'_>,
        valid: u32,
        solver: Solver,
        normals: bool,
    ) -> HitLanes {
        assert!(rays.tnear.len() <= MAX_LANES, "a packet has up to 16 rays");
        let there = u32::MAX >> (u32::BITS as usize - MAX_LANES) >> (MAX_LANES - rays.tnear.len());
        let request = Request {
            // The lanes of a register beyond the packet hold no ray.
            valid: valid & there,
            solver,
            normals,
        };
        let mut hits = HitLanes {
            found: 0,
            t: [0.0; MAX_LANES],
            u: [0.0; MAX_LANES],
            v: [0.0; MAX_LANES],
            normal: [[0.0; MAX_LANES]; 3],
            evaluations: 0,
        };
        // Laid out within, so that the level's instructions serve that as well.
        dispatch!(level, simd => trace(simd, self, rays, request, &mut hits));
        hits
    }

    /// Where the ray first meets the surface with `tnear <= t <= tfar`, and the surface's normal there
    /// if `normal`, else zeros.
    ///
    /// The answer is bit for bit that of [`Patch::intersect`](crate::Patch::intersect) and [`Patch::normal_at`](crate::Patch::normal_at), but for the count
    /// of evaluations: a ray that may meet the surface several times has it sampled in many places at
    /// once, also in those beyond the first root.
    pub fn intersect(
        &self,
        ray: &Ray<f32>,
        solver: Solver,
        normal: bool,
    ) -> (Hit<f32>, Vector<f32>) {
        self.intersect_at(Level::new(), ray, solver, normal)
    }

    /// The same with the instructions of one level.
    #[inline(always)]
    pub(crate) fn intersect_at(
        &self,
        level: Level,
        ray: &Ray<f32>,
        solver: Solver,
        normal: bool,
    ) -> (Hit<f32>, Vector<f32>) {
        let mut found = (Hit::none(0.0), vector(0.0, 0.0, 0.0));
        dispatch!(level, simd => {
            let (interval, frame) = match self.single_slab() {
                Some(slab) => {
                    let single = EdgesInLanes::new(simd, self.vertices(), slab);
                    (single.clip(ray), Some(single.frame))
                }
                None => {
                    let frame = self.frame();
                    (self.clip_volume(frame.as_ref()).clip(ray, true), frame)
                }
            };
            if frame.is_some() && interval.alive {
                let patch = self.unpack_surface(frame.as_ref());
                found = trace_one(simd, &patch, &interval, ray, solver, normal);
            }
        });
        found
    }
}

/// A register's lanes at a time.
#[inline(always)]
fn trace<S: Simd>(
    simd: S,
    triangle: &PackedTriangle<'_>,
    rays: &RayLanes<'_>,
    request: Request,
    hits: &mut HitLanes,
) {
    let frame = triangle.frame();
    let clip_volume = triangle.clip_volume(frame.as_ref());
    let mut patch = None;
    for first in (0..rays.tnear.len()).step_by(S::f32s::LEN) {
        let valid = S::mask32s::from_bitmask(simd, u64::from(request.valid >> first));
        let ray = load_ray(simd, rays, first);
        let interval = clip_volume.clip(&ray, LaneMask(valid));
        if interval.is_empty() {
            continue;
        }
        let patch = &*patch.get_or_insert_with(
            #[inline(always)]
            || triangle.unpack_surface(frame.as_ref()),
        );
        let hit = match request.solver {
            Solver::Ita { .. } => patch.intersect_clipped(&interval, &ray, request.solver),
            Solver::Bracketing { .. } => patch.intersect_with_search(
                &interval,
                &ray,
                request.solver,
                #[inline(always)]
                |segment| search_lanes(simd, patch, &segment, request.solver),
            ),
        };
        hits.evaluations += hit.evaluations;
        let found = hit.found.0.to_bitmask() as u32;
        if found == 0 {
            continue;
        }
        hits.found |= found << first;
        hit.t.store(&mut hits.t, first);
        hit.u.store(&mut hits.u, first);
        hit.v.store(&mut hits.v, first);
        if request.normals {
            let normal = patch.geometric_normal(hit.u, hit.v);
            normal.x.store(&mut hits.normal[0], first);
            normal.y.store(&mut hits.normal[1], first);
            normal.z.store(&mut hits.normal[2], first);
        }
    }
}

#[inline(always)]
pub(crate) fn load_ray<S: Simd>(simd: S, rays: &RayLanes<'_>, first: usize) -> Ray<Lanes<S>> {
    let load_vector = inlined(
        #[inline(always)]
        |[x, y, z]: [&[f32]; 3]| -> Vector<Lanes<S>> {
            vector(
                Lanes::load(simd, x, first),
                Lanes::load(simd, y, first),
                Lanes::load(simd, z, first),
            )
        },
    );
    Ray {
        origin: load_vector(rays.origin),
        direction: load_vector(rays.direction),
        tnear: Lanes::load(simd, rays.tnear, first),
        tfar: Lanes::load(simd, rays.tfar, first),
    }
}
