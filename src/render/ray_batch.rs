//! Many rays of the caller at once.

use rayon::prelude::*;

use super::scene::Scene;
use super::user_ray::{RayFault, UserRay};
use crate::embree::{Hit, QueryOptions, RayPacket, Traced, Width, flush_denormals};

/// Rays that one job takes.
const CHUNK: usize = 1 << 12;

/// Stands for "none" where a primitive has its number.
pub const NO_PRIMITIVE: u32 = u32::MAX;

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
    /// Where they hit, in units of the direction's length; infinity for a miss. As precise as single precision is
    /// near the scene, however far away the ray begins.
    pub t: Vec<f64>,
    /// The triangle's number in its mesh; [`NO_PRIMITIVE`] for a miss.
    pub prim_id: Vec<u32>,
    /// Barycentric coordinates of the triangle's second and third vertex; zeros for a miss.
    pub uv: Vec<[f32; 2]>,
    /// The surface's geometric normal, unit; zeros for a miss.
    pub ng: Vec<[f32; 3]>,
}

/// All hits of many rays: see [`answer_all_hits`].
#[derive(Clone, Debug, Default, PartialEq)]
pub struct AllAnswers {
    /// The first hits of each ray, nearest first: those of the n-th ray begin at n times their number a
    /// ray. Beyond a ray's last hit there are misses.
    pub hits: Answers,
    /// How many hits each ray has: all of them, also where only some are returned.
    pub count: Vec<u32>,
}

/// Rays of the caller's own, given by their numbers.
///
/// Both functions are called from any thread. A ray that cannot be traced misses: see [`untraceable_rays`].
///
/// ```
/// use curvetri::mesh::Mesh;
/// use curvetri::render::{
///     AllAnswers, Answers, Form, NO_PRIMITIVE, PacketWidth, Scene, UserRay, UserRays,
///     answer_all_hits, answer_occluded, answer_rays, untraceable_rays,
/// };
/// use glam::DVec3;
///
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// let mesh = Mesh::new(vec![DVec3::ZERO, DVec3::X, DVec3::Y], None, vec![[0, 1, 2]])?;
/// let scene = Scene::with_filters(&curvetri::linked::device()?, vec![mesh], Form::Flat)?;
/// let rays = UserRays {
///     count: 2,
///     ray: &|n| UserRay {
///         origin: DVec3::new(0.25 + n as f64, 0.25, 2.0),
///         direction: DVec3::NEG_Z,
///         tnear: 0.0,
///         tfar: f64::INFINITY,
///     },
///     progress: &|_| (),
/// };
/// let nearest: Answers = answer_rays(&scene, &rays, PacketWidth::Sixteen);
/// assert!((nearest.t[0] - 2.0).abs() < 1e-5);
/// assert_eq!(nearest.prim_id, [0, NO_PRIMITIVE]);
/// let all: AllAnswers = answer_all_hits(&scene, &rays, PacketWidth::One, 3);
/// assert_eq!((all.count, all.hits.t.len()), (vec![1, 0], 6));
/// assert_eq!(answer_occluded(&scene, &rays, PacketWidth::Four), [true, false]);
/// assert_eq!(untraceable_rays(&scene, &rays), None);
/// # Ok(())
/// # }
/// ```
pub struct UserRays<'a> {
    /// How many there are.
    pub count: usize,
    /// The ray of a number below `count`.
    pub ray: &'a (dyn Fn(usize) -> UserRay + Sync),
    /// Gets the number of rays done since its last call.
    pub progress: &'a (dyn Fn(usize) + Sync),
}

/// Finds the nearest hit of rays on the threads of the current rayon pool.
pub fn answer_rays(scene: &Scene, rays: &UserRays<'_>, width: PacketWidth) -> Answers {
    let mut answers = Answers::misses(rays.count);
    let chunks = answers.chunks(1);
    chunks.enumerate().for_each(|(n, hits)| {
        let chunk = RayChunk::new(scene, rays, n);
        width.run(&mut Nearest { chunk, hits });
        chunk.done();
    });
    answers
}

/// Finds all hits of rays (see [`Scene::all_hits`]), and returns the `most` nearest of each, on the
/// threads of the current rayon pool.
///
/// # Panics
/// If `most` is 0, or the scene was not made [for filters](Scene::with_filters).
pub fn answer_all_hits(
    scene: &Scene,
    rays: &UserRays<'_>,
    width: PacketWidth,
    most: usize,
) -> AllAnswers {
    assert!(most > 0, "no hits are requested");
    let mut answers = AllAnswers {
        hits: Answers::misses(rays.count * most),
        count: vec![0; rays.count],
    };
    let chunks = answers.hits.chunks(most);
    let chunks = chunks.zip(answers.count.par_chunks_mut(CHUNK));
    chunks.enumerate().for_each(|(n, (hits, count))| {
        let chunk = RayChunk::new(scene, rays, n);
        width.run(&mut All {
            chunk,
            hits,
            count,
            most,
        });
        chunk.done();
    });
    answers
}

/// Finds out which rays hit anything, on the threads of the current rayon pool.
pub fn answer_occluded(scene: &Scene, rays: &UserRays<'_>, width: PacketWidth) -> Vec<bool> {
    let mut answers = vec![false; rays.count];
    let chunks = answers.par_chunks_mut(CHUNK);
    chunks.enumerate().for_each(|(n, occluded)| {
        let chunk = RayChunk::new(scene, rays, n);
        width.run(&mut Occlusion { chunk, occluded });
        chunk.done();
    });
    answers
}

/// The rays of a batch that cannot be traced.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Untraceable {
    /// How many there are, 1 or more.
    pub count: usize,
    /// The number of the first.
    pub first: usize,
    /// What is wrong with that one.
    pub fault: RayFault,
}

/// Finds out which rays cannot be traced, on the threads of the current rayon pool: they hit nothing in any of
/// the answers. `None` where all can.
pub fn untraceable_rays(scene: &Scene, rays: &UserRays<'_>) -> Option<Untraceable> {
    let faults = (0..rays.count).into_par_iter().filter_map(|number| {
        let fault = (rays.ray)(number).localized(scene).err()?;
        Some(Untraceable {
            count: 1,
            first: number,
            fault,
        })
    });
    faults.reduce_with(|a, b| Untraceable {
        count: a.count + b.count,
        ..if a.first < b.first { a } else { b }
    })
}

/// Work on packets of any width.
trait Job {
    fn run<const N: usize>(&mut self)
    where
        Width<N>: Traced;
}

impl PacketWidth {
    fn run(self, job: &mut impl Job) {
        let _flush = flush_denormals();
        match self {
            Self::One => job.run::<1>(),
            Self::Four => job.run::<4>(),
            Self::Eight => job.run::<8>(),
            Self::Sixteen => job.run::<16>(),
        }
    }
}

/// The rays of one job.
#[derive(Clone, Copy)]
struct RayChunk<'a> {
    scene: &'a Scene,
    rays: &'a UserRays<'a>,
    first: usize,
    count: usize,
}

impl<'a> RayChunk<'a> {
    fn new(scene: &'a Scene, rays: &'a UserRays<'a>, number: usize) -> Self {
        let first = number * CHUNK;
        Self {
            scene,
            rays,
            first,
            count: CHUNK.min(rays.count - first),
        }
    }

    /// The rays in packets, each with the number in the chunk of its first, and what to add to their t.
    fn packets<const N: usize>(self) -> impl Iterator<Item = (usize, RayPacket<N>, [f64; N])> {
        let ray = move |i: usize| (self.rays.ray)(self.first + i).localized(self.scene);
        (0..self.count).step_by(N).map(move |first| {
            let (mut packet, mut shifts) = (RayPacket::<N>::new(), [0.0; N]);
            let lanes = shifts.iter_mut().enumerate();
            for (lane, shift) in lanes.take(self.count - first) {
                if let Ok(near) = ray(first + lane) {
                    packet.set_ray(lane, &near.ray);
                    *shift = near.shift;
                }
            }
            (first, packet, shifts)
        })
    }

    fn done(self) {
        (self.rays.progress)(self.count);
    }
}

struct Nearest<'a> {
    chunk: RayChunk<'a>,
    hits: HitSlots<'a>,
}

impl Job for Nearest<'_> {
    fn run<const N: usize>(&mut self)
    where
        Width<N>: Traced,
    {
        let tree = self.chunk.scene.tree();
        for (first, mut packet, shifts) in self.chunk.packets::<N>() {
            tree.intersect(&mut packet, &QueryOptions::INCOHERENT);
            for (lane, shift) in shifts.into_iter().enumerate() {
                if let Some(hit) = packet.hit(lane) {
                    self.hits.put(first + lane, &hit, shift, self.chunk.scene);
                }
            }
        }
    }
}

struct All<'a> {
    chunk: RayChunk<'a>,
    hits: HitSlots<'a>,
    count: &'a mut [u32],
    most: usize,
}

impl Job for All<'_> {
    fn run<const N: usize>(&mut self)
    where
        Width<N>: Traced,
    {
        let mut found = [const { Vec::new() }; N];
        for (first, packet, shifts) in self.chunk.packets::<N>() {
            self.chunk.scene.all_hits(&packet, false, &mut found);
            let counts = &mut self.count[first..];
            for (lane, (count, hits)) in counts.iter_mut().zip(&found).enumerate() {
                *count = hits.len() as u32;
                for (n, hit) in hits.iter().take(self.most).enumerate() {
                    let slot = (first + lane) * self.most + n;
                    self.hits.put(slot, hit, shifts[lane], self.chunk.scene);
                }
            }
        }
    }
}

struct Occlusion<'a> {
    chunk: RayChunk<'a>,
    occluded: &'a mut [bool],
}

impl Job for Occlusion<'_> {
    fn run<const N: usize>(&mut self)
    where
        Width<N>: Traced,
    {
        let tree = self.chunk.scene.tree();
        for (first, mut packet, _) in self.chunk.packets::<N>() {
            let lanes = tree.occluded(&mut packet, &QueryOptions::INCOHERENT);
            for (lane, occluded) in self.occluded[first..].iter_mut().take(N).enumerate() {
                *occluded = lanes & 1 << lane != 0;
            }
        }
    }
}

/// Where a job's hits go.
struct HitSlots<'a> {
    t: &'a mut [f64],
    prim_id: &'a mut [u32],
    uv: &'a mut [[f32; 2]],
    ng: &'a mut [[f32; 3]],
}

impl HitSlots<'_> {
    fn put(&mut self, slot: usize, hit: &Hit, shift: f64, scene: &Scene) {
        self.t[slot] = shift + f64::from(hit.t);
        self.prim_id[slot] = hit.prim_id;
        self.uv[slot] = [hit.u, hit.v];
        self.ng[slot] = scene.normal(hit).to_array();
    }
}

impl Answers {
    fn misses(count: usize) -> Self {
        Self {
            t: vec![f64::INFINITY; count],
            prim_id: vec![NO_PRIMITIVE; count],
            uv: vec![[0.0; 2]; count],
            ng: vec![[0.0; 3]; count],
        }
    }

    /// The slots of each job, `each` of them a ray.
    fn chunks(&mut self, each: usize) -> impl IndexedParallelIterator<Item = HitSlots<'_>> {
        let size = CHUNK * each;
        (
            self.t.par_chunks_mut(size),
            self.prim_id.par_chunks_mut(size),
            self.uv.par_chunks_mut(size),
            self.ng.par_chunks_mut(size),
        )
            .into_par_iter()
            .map(|(t, prim_id, uv, ng)| HitSlots { t, prim_id, uv, ng })
    }
}
