//! Renders a picture in tiles over all threads.

use std::ops::Add;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Instant;

use glam::{DVec3, Vec4};
use rayon::prelude::*;

use super::camera::{Camera, CameraError, Lens, UpAxis};
use super::direct::{Direct, GroundPlane, LANES};
use super::film::Film;
use super::light::Lighting;
use super::sampler::PixelSampler;
use super::scene::Scene;
use super::shading::Shading;
use super::stats::{Rays, RenderStats};
use crate::curved::{Counters, counters};
use crate::embree::{RayPacket, flush_denormals};

/// Pixels a side of a tile, a multiple of [`BLOCK`].
const TILE: usize = 16;
/// Pixels a side of the blocks whose rays are traced together.
const BLOCK: usize = 4;
const _: () = assert!(BLOCK * BLOCK == LANES && TILE.is_multiple_of(BLOCK));

/// What to render of a scene.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    /// Pixels in a row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Camera rays a pixel, spread evenly over its square.
    pub samples: u32,
    /// The camera.
    pub camera: Camera,
    /// The lights.
    pub lighting: Lighting,
    /// Share of light that surfaces reflect, 0 to 1.
    pub albedo: f32,
    /// What flat triangles are lit by.
    pub shading: Shading,
    /// The ground.
    pub ground: Ground,
}

impl Picture {
    /// A picture of this size by daylight, of 16 samples a pixel, without a ground.
    pub fn new(width: usize, height: usize, camera: Camera, up: UpAxis) -> Self {
        Self {
            width,
            height,
            samples: 16,
            camera,
            lighting: Lighting::daylight(up),
            albedo: 0.7,
            shading: Shading::default(),
            ground: Ground::default(),
        }
    }
}

/// A plane under the meshes that takes their shadows.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Ground {
    /// No ground.
    #[default]
    None,
    /// An endless plane through the surface's lowest point that fades into the background.
    Plane,
    /// Such a plane in a place of its own: [`Ground::under`] another scene.
    Fixed(FixedGround),
}

/// A ground that stays where it is, whatever the scene. In the user's space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FixedGround {
    /// Its height along the sky's up vector.
    height: f64,
    /// The middle of what lies on it.
    centre: DVec3,
    /// How far that reaches from its middle.
    radius: f64,
}

/// Renders a picture on the threads of the current rayon pool. The picture does not depend on how
/// many these are.
///
/// `progress` is called from any of them with the tiles done and their number.
///
/// # Errors
/// If the camera sees nothing.
///
/// # Panics
/// If the picture has no pixel or no samples.
pub fn render(
    scene: &Scene,
    picture: &Picture,
    progress: &(dyn Fn(usize, usize) + Sync),
) -> Result<(Film, RenderStats), CameraError> {
    let (width, height) = (picture.width, picture.height);
    assert!(
        width > 0 && height > 0 && picture.samples > 0,
        "a picture of nothing"
    );
    let lens = picture.camera.lens(scene.origin(), width, height)?;
    let start = Instant::now();
    let direct = Direct {
        scene,
        lighting: &picture.lighting,
        albedo: picture.albedo,
        shading: picture.shading,
        ground: picture.ground.plane(scene, &picture.lighting),
    };
    let columns = width.div_ceil(TILE);
    let count = columns * height.div_ceil(TILE);
    let done = AtomicUsize::new(0);
    let tiles: Vec<Tile> = (0..count)
        .into_par_iter()
        .map(|n| {
            let tile = Tile::traced(&direct, &lens, picture, [n % columns, n / columns]);
            progress(done.fetch_add(1, Ordering::Relaxed) + 1, count);
            tile
        })
        .collect();
    let mut film = Film::new(width, height);
    for tile in &tiles {
        film.paste(tile.corner, TILE, &tile.pixels);
    }
    let work = tiles
        .iter()
        .map(|tile| tile.work)
        .fold(Work::default(), Work::add);
    let mut stats = RenderStats {
        triangles: scene.triangles(),
        times: scene.times(),
        memory: scene.memory(),
        rays: work.rays,
        kernel: work.kernel,
    };
    stats.times.render = start.elapsed();
    Ok((film, stats))
}

impl Ground {
    /// The ground that [`Ground::Plane`] is for a scene: other scenes may lie on it as well.
    pub fn under(scene: &Scene, lighting: &Lighting) -> Self {
        Self::Fixed(FixedGround::under(scene, lighting))
    }

    fn plane(self, scene: &Scene, lighting: &Lighting) -> Option<GroundPlane> {
        let ground = match self {
            Self::None => return None,
            Self::Plane => FixedGround::under(scene, lighting),
            Self::Fixed(ground) => ground,
        };
        let (up, origin) = (lighting.sky.up, scene.origin());
        let radius = ground.radius as f32;
        Some(GroundPlane {
            up,
            height: (ground.height - origin.dot(up.as_dvec3())) as f32,
            centre: (ground.centre - origin).as_vec3(),
            fade: [2.0 * radius, 12.0 * radius],
        })
    }
}

impl FixedGround {
    fn under(scene: &Scene, lighting: &Lighting) -> Self {
        let (bounds, up) = (scene.bounds(), lighting.sky.up);
        Self {
            height: f64::from(scene.lowest(up)) + scene.origin().dot(up.as_dvec3()),
            centre: bounds.centre(),
            radius: 0.5 * bounds.diagonal(),
        }
    }
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
    rays: Rays,
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
    fn traced(direct: &Direct<'_>, lens: &Lens, picture: &Picture, place: [usize; 2]) -> Self {
        let _flush = flush_denormals();
        let before = counters();
        let corner = place.map(|n| n * TILE);
        let mut tile = Self {
            corner,
            pixels: vec![Vec4::ZERO; TILE * TILE],
            work: Work::default(),
        };
        for block in 0..(TILE / BLOCK).pow(2) {
            let [x, y] = [block % (TILE / BLOCK), block / (TILE / BLOCK)].map(|n| n * BLOCK);
            let block = Block::new(picture, [corner[0] + x, corner[1] + y]);
            let sums = block.traced(direct, lens, picture.samples, &mut tile.work.rays);
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
            inside.then(|| ([x, y], PixelSampler::new(x as u32, y as u32)))
        });
        Self { pixels }
    }

    /// Each pixel's mean over its samples, taken in their order.
    fn traced(
        &self,
        direct: &Direct<'_>,
        lens: &Lens,
        samples: u32,
        rays: &mut Rays,
    ) -> [Vec4; LANES] {
        let mut sums = [Vec4::ZERO; LANES];
        for sample in 0..samples {
            let mut packet = RayPacket::new();
            for (lane, pixel) in self.pixels.iter().enumerate() {
                if let Some(([x, y], sampler)) = pixel {
                    let [dx, dy] = sampler.point(sample);
                    packet.set_ray(lane, &lens.ray(*x as f32 + dx, *y as f32 + dy));
                }
            }
            if packet.active() == 0 {
                break;
            }
            for (sum, value) in sums.iter_mut().zip(direct.trace(&mut packet, rays)) {
                *sum += value;
            }
        }
        sums.map(|sum| sum / samples as f32)
    }
}
