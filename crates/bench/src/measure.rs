//! Times of tracing.

use std::time::Instant;

use rayon::ThreadPool;
use rayon::prelude::*;

use super::clock::{self, Clock};
use super::rays::RayKind;
use curvetri::curved::{Counters, counters};
use curvetri::embree::{QueryOptions, Ray, RayPacket, Scene, Traced, Width, flush_denormals};

/// How rays are handed to Embree.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Way {
    /// Rays a packet: 1, 4, 8 or 16.
    pub width: usize,
    /// Whether they are said to be alike.
    pub coherent: bool,
}

impl Way {
    /// Every way there is.
    pub const ALL: [Self; 7] = [
        Self::new(1, false),
        Self::new(4, true),
        Self::new(4, false),
        Self::new(8, true),
        Self::new(8, false),
        Self::new(16, true),
        Self::new(16, false),
    ];
    /// The ways that may be a form's best.
    pub const FEW: [Self; 2] = [Self::new(1, false), Self::new(16, true)];

    const fn new(width: usize, coherent: bool) -> Self {
        Self { width, coherent }
    }

    /// As it appears in reports: `16c` for packets of sixteen coherent rays.
    #[must_use]
    pub fn name(&self) -> String {
        format!("{}{}", self.width, if self.coherent { "c" } else { "" })
    }
}

/// The rays of a kind, packed in every width.
pub(super) struct PackedRays {
    pub kind: RayKind,
    pub count: usize,
    one: Vec<RayPacket<1>>,
    four: Vec<RayPacket<4>>,
    eight: Vec<RayPacket<8>>,
    sixteen: Vec<RayPacket<16>>,
}

/// Rays that one job takes.
const CHUNK: usize = 1024;

impl PackedRays {
    pub fn new(kind: RayKind, rays: &[Ray]) -> Self {
        Self {
            kind,
            count: rays.len(),
            one: packed(rays),
            four: packed(rays),
            eight: packed(rays),
            sixteen: packed(rays),
        }
    }

    /// How many rays hit.
    pub fn trace(&self, scene: &Scene, way: Way) -> u64 {
        match way.width {
            1 => self.hits(scene, way, &self.one),
            4 => self.hits(scene, way, &self.four),
            8 => self.hits(scene, way, &self.eight),
            _ => self.hits(scene, way, &self.sixteen),
        }
    }

    /// Seconds to trace them on a pool's threads.
    pub fn time(&self, scene: &Scene, way: Way, pool: &ThreadPool, clock: Clock) -> f64 {
        let trace = || {
            let start = Instant::now();
            std::hint::black_box(self.trace(scene, way));
            start.elapsed().as_secs_f64()
        };
        match clock {
            Clock::Wall => pool.install(trace),
            Clock::Processor => {
                let ran = || pool.broadcast(|_| clock::thread_time());
                let before = ran().into_iter().sum::<f64>();
                pool.install(trace);
                let after = ran().into_iter().sum::<f64>();
                (after - before) / pool.current_num_threads() as f64
            }
        }
    }

    /// How many hit, and what the kernel did for it.
    pub fn count(&self, scene: &Scene, way: Way, one: &ThreadPool) -> (u64, Counters) {
        one.install(|| {
            let before = counters();
            let hits = self.trace(scene, way);
            (hits, counters() - before)
        })
    }

    /// How far each ray goes, infinitely far where it misses.
    pub fn distances(&self, scene: &Scene) -> Vec<f32> {
        let traced = self.one.par_iter().map(|packet| {
            let mut packet = packet.clone();
            scene.intersect(&mut packet, &QueryOptions::INCOHERENT);
            packet.hit(0).map_or(f32::INFINITY, |hit| hit.t)
        });
        traced.collect()
    }

    fn hits<const N: usize>(&self, scene: &Scene, way: Way, packets: &[RayPacket<N>]) -> u64
    where
        Width<N>: Traced,
    {
        let options = if way.coherent {
            QueryOptions::COHERENT
        } else {
            QueryOptions::INCOHERENT
        };
        let occlusion = self.kind.is_occlusion();
        // Each a job of its own: with whole runs of them a thread may be left with the longest at the end,
        // by chance, while the others wait.
        let chunks = packets.par_chunks(CHUNK / N).with_max_len(1);
        let hits = chunks.map(|chunk| {
            let _flush = flush_denormals();
            let hits = chunk.iter().map(|packet| {
                let mut packet = packet.clone();
                if occlusion {
                    return scene.occluded(&mut packet, &options).count_ones();
                }
                scene.intersect(&mut packet, &options);
                let missed = packet.hits.geom_id.iter().filter(|id| **id == u32::MAX);
                (N - missed.count()) as u32
            });
            hits.map(u64::from).sum::<u64>()
        });
        hits.sum()
    }
}

fn packed<const N: usize>(rays: &[Ray]) -> Vec<RayPacket<N>> {
    rays.par_chunks(N).map(RayPacket::from_rays).collect()
}
