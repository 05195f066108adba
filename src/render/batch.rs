//! Many rays of the caller's own at once.

use glam::DVec3;
use rayon::prelude::*;

use super::scene::Scene;
use crate::embree::{QueryOptions, Ray, RayPacket, Traced, Width, flush_denormals};

/// Rays that one job takes.
const CHUNK: usize = 1 << 12;

/// Stands for "none" where a primitive has its number.
pub const NO_PRIMITIVE: u32 = u32::MAX;

/// A ray in the user's space: the points `origin + t direction` with `tnear <= t <= tfar`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UserRay {
    /// Where t = 0.
    pub origin: DVec3,
    /// Need not be of unit length: t counts in its length.
    pub direction: DVec3,
    /// Where the ray begins, 0 or more.
    pub tnear: f64,
    /// Where the ray ends; may be infinite.
    pub tfar: f64,
}

/// How many rays are traced together.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum PacketWidth {
    /// One by one.
    #[default]
    One,
    /// Four.
    Four,
    /// Eight.
    Eight,
    /// Sixteen.
    Sixteen,
}

/// The nearest hits of many rays, by the rays' numbers.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Answers {
    /// Where they hit, in units of the direction's length; infinity for a miss.
    pub t: Vec<f32>,
    /// The triangle's number in its mesh; [`NO_PRIMITIVE`] for a miss.
    pub prim_id: Vec<u32>,
    /// Barycentric coordinates of the triangle's second and third vertex; zeros for a miss.
    pub uv: Vec<[f32; 2]>,
    /// The surface's geometric normal, unit; zeros for a miss.
    pub ng: Vec<[f32; 3]>,
}

/// Finds the nearest hit of `count` rays on the threads of the current rayon pool.
///
/// `ray` gives the ray of a number below `count`; it and `progress` are called from any thread, the
/// latter with the number of rays done since its last call. A ray that Embree does not trace (see
/// [`Ray::is_traceable`]) misses.
pub fn answer_rays(
    scene: &Scene,
    count: usize,
    width: PacketWidth,
    ray: &(dyn Fn(usize) -> UserRay + Sync),
    progress: &(dyn Fn(usize) + Sync),
) -> Answers {
    let mut answers = Answers {
        t: vec![f32::INFINITY; count],
        prim_id: vec![NO_PRIMITIVE; count],
        uv: vec![[0.0; 2]; count],
        ng: vec![[0.0; 3]; count],
    };
    answers.chunks().enumerate().for_each(|(n, mut chunk)| {
        let _flush = flush_denormals();
        let ray = |i: usize| ray(n * CHUNK + i).localized(scene.origin());
        match width {
            PacketWidth::One => chunk.answer::<1>(scene, &ray),
            PacketWidth::Four => chunk.answer::<4>(scene, &ray),
            PacketWidth::Eight => chunk.answer::<8>(scene, &ray),
            PacketWidth::Sixteen => chunk.answer::<16>(scene, &ray),
        }
        progress(chunk.t.len());
    });
    answers
}

impl UserRay {
    /// The ray in the space relative to `origin`.
    fn localized(&self, origin: DVec3) -> Ray {
        Ray::new((self.origin - origin).as_vec3(), self.direction.as_vec3())
            .between(self.tnear as f32, self.tfar as f32)
    }
}

/// The answers to the rays of one job.
struct Chunk<'a> {
    t: &'a mut [f32],
    prim_id: &'a mut [u32],
    uv: &'a mut [[f32; 2]],
    ng: &'a mut [[f32; 3]],
}

impl Answers {
    fn chunks(&mut self) -> impl IndexedParallelIterator<Item = Chunk<'_>> {
        (
            self.t.par_chunks_mut(CHUNK),
            self.prim_id.par_chunks_mut(CHUNK),
            self.uv.par_chunks_mut(CHUNK),
            self.ng.par_chunks_mut(CHUNK),
        )
            .into_par_iter()
            .map(|(t, prim_id, uv, ng)| Chunk { t, prim_id, uv, ng })
    }
}

impl Chunk<'_> {
    fn answer<const N: usize>(&mut self, scene: &Scene, ray: &dyn Fn(usize) -> Ray)
    where
        Width<N>: Traced,
    {
        let count = self.t.len();
        for first in (0..count).step_by(N) {
            let mut packet = RayPacket::<N>::new();
            let lanes = N.min(count - first);
            for lane in 0..lanes {
                packet.set_ray(lane, &ray(first + lane));
            }
            scene
                .tree()
                .intersect(&mut packet, &QueryOptions::INCOHERENT);
            for lane in 0..lanes {
                if let Some(hit) = packet.hit(lane) {
                    let i = first + lane;
                    self.t[i] = hit.t;
                    self.prim_id[i] = hit.prim_id;
                    self.uv[i] = [hit.u, hit.v];
                    self.ng[i] = hit.ng.normalize_or_zero().to_array();
                }
            }
        }
    }
}
