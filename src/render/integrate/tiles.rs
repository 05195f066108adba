//! Renders a picture in tiles over all threads.

use std::ops::Add;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Instant;

use glam::Vec4;
use rayon::prelude::*;

use super::ambient_occlusion::AmbientOcclusion;
use super::direct::Direct;
use super::estimator::{Estimator, LANES};
use super::path::PathTracer;
use super::sampler::{PixelSampler, Sample};
use super::world::World;
use crate::curved::{Counters, counters};
use crate::embree::{RayPacket, flush_denormals};
use crate::render::camera::{CameraError, Lens};
use crate::render::film::Film;
use crate::render::picture::{Integrator, Picture, Window};
use crate::render::scene::Scene;
use crate::render::stats::{RayCounts, RenderStats};

/// Pixels a side of a tile, a multiple of [`BLOCK`].
const TILE: usize = 16;
/// Pixels a side of the blocks whose rays are traced together.
const BLOCK: usize = 4;
const _: () = assert!(BLOCK * BLOCK == LANES && TILE.is_multiple_of(BLOCK));

/// Renders a picture on the threads of the current rayon pool. The picture does not depend on how
/// many these are.
///
/// `progress` is called from any of them with the tiles done and their number.
///
/// # Errors
/// If the camera sees nothing.
///
/// # Panics
/// If the picture has no pixel or no samples, a path no surfaces, or the crop is not within the
/// picture.
pub fn render(
    scene: &Scene,
    picture: &Picture,
    progress: &(dyn Fn(usize, usize) + Sync),
) -> Result<(Film, RenderStats), CameraError> {
    let window = picture.window();
    assert!(picture.samples > 0, "a picture of nothing");
    let lens = picture.lens(scene)?;
    let start = Instant::now();
    let estimator = estimator(scene, picture);
    let places = tiles_of(&window);
    let done = AtomicUsize::new(0);
    let tiles: Vec<Tile> = places
        .par_iter()
        .map(|&corner| {
            let tile = Tile::traced(&*estimator, &lens, picture, corner);
            progress(done.fetch_add(1, Ordering::Relaxed) + 1, places.len());
            tile
        })
        .collect();
    let mut film = Film::of(window);
    for tile in &tiles {
        film.paste(tile.corner, TILE, &tile.pixels);
    }
    let work = tiles
        .iter()
        .map(|tile| tile.work)
        .fold(Work::default(), Work::add);
    let mut stats = RenderStats {
        triangles: scene.triangles(),
        instances: scene.instances(),
        spheres: scene.spheres(),
        times: scene.times(),
        memory: scene.memory(),
        rays: work.rays,
        kernel: work.kernel,
    };
    stats.times.render = start.elapsed();
    Ok((film, stats))
}

fn estimator<'a>(scene: &'a Scene, picture: &'a Picture) -> Box<dyn Estimator + 'a> {
    let world = World::new(scene, picture);
    match picture.integrator {
        Integrator::Direct { sky_shadows } => Box::new(Direct { world, sky_shadows }),
        Integrator::AmbientOcclusion { distance } => Box::new(AmbientOcclusion { world, distance }),
        Integrator::Path { depth } => {
            assert!(depth > 0, "a path of no surfaces");
            Box::new(PathTracer { world, depth })
        }
    }
}

/// The corners of the tiles that a window shows a part of, on a grid that is the same whatever the
/// window: so packets are the same, and a crop's pixels those of the whole picture.
fn tiles_of(window: &Window) -> Vec<[usize; 2]> {
    let [columns, rows] = [0, 1].map(|axis| {
        let first = window.corner[axis] / TILE;
        first..(window.corner[axis] + window.size[axis]).div_ceil(TILE)
    });
    rows.flat_map(|y| columns.clone().map(move |x| [x * TILE, y * TILE]))
        .collect()
}

/// A square of the picture, done. Pixels beyond the picture's edges are empty.
struct Tile {
    corner: [usize; 2],
    pixels: Vec<Vec4>,
    work: Work,
}

/// What a tile took.
#[derive(Clone, Copy, Default)]
struct Work {
    rays: RayCounts,
    kernel: Counters,
}

impl Add for Work {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self {
            rays: self.rays + other.rays,
            kernel: self.kernel + other.kernel,
        }
    }
}

impl Tile {
    fn traced(
        estimator: &dyn Estimator,
        lens: &Lens,
        picture: &Picture,
        corner: [usize; 2],
    ) -> Self {
        let _flush = flush_denormals();
        let before = counters();
        let mut tile = Self {
            corner,
            pixels: vec![Vec4::ZERO; TILE * TILE],
            work: Work::default(),
        };
        for block in 0..(TILE / BLOCK).pow(2) {
            let [x, y] = [block % (TILE / BLOCK), block / (TILE / BLOCK)].map(|n| n * BLOCK);
            let block = Block::new(picture, [corner[0] + x, corner[1] + y]);
            let sums = block.traced(estimator, lens, picture.samples, &mut tile.work.rays);
            for (lane, sum) in sums.into_iter().enumerate() {
                tile.pixels[(y + lane / BLOCK) * TILE + x + lane % BLOCK] = sum;
            }
        }
        tile.work.kernel = counters() - before;
        tile
    }
}

/// The pixels whose rays are traced together.
struct Block {
    pixels: [Option<([usize; 2], PixelSampler)>; LANES],
}

impl Block {
    /// The block with this upper left corner; pixels beyond the picture's edges stay empty.
    fn new(picture: &Picture, corner: [usize; 2]) -> Self {
        let pixels = std::array::from_fn(|lane| {
            let [x, y] = [corner[0] + lane % BLOCK, corner[1] + lane / BLOCK];
            let inside = x < picture.width && y < picture.height;
            inside.then(|| ([x, y], PixelSampler::new(x as u32, y as u32, picture.seed)))
        });
        Self { pixels }
    }

    /// Each pixel's mean over its samples, taken in their order.
    fn traced(
        &self,
        estimator: &dyn Estimator,
        lens: &Lens,
        samples: u32,
        rays: &mut RayCounts,
    ) -> [Vec4; LANES] {
        let mut sums = [Vec4::ZERO; LANES];
        for sample in 0..samples {
            let mut packet = RayPacket::new();
            let mut numbers = [Sample::default(); LANES];
            for (lane, pixel) in self.pixels.iter().enumerate() {
                if let Some(([x, y], sampler)) = pixel {
                    let [dx, dy] = sampler.point(sample);
                    packet.set_ray(lane, &lens.ray(*x as f32 + dx, *y as f32 + dy));
                    numbers[lane] = sampler.sample(sample);
                }
            }
            if packet.active() == 0 {
                break;
            }
            let values = estimator.trace(&mut packet, &numbers, rays);
            for (sum, value) in sums.iter_mut().zip(values) {
                *sum += value;
            }
        }
        sums.map(|sum| sum / samples as f32)
    }
}
