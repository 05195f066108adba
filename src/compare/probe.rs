//! What rays through the middles of a picture's pixels meet.

use glam::Vec3;
use rayon::prelude::*;

use crate::embree::{QueryOptions, Ray, RayPacket, flush_denormals};
use crate::render::{Camera, CameraError, Lens, Scene, Shading, Vicinity};

/// Rays traced together.
const LANES: usize = 16;

/// What a ray through each pixel's middle meets first.
#[derive(Clone, Debug, PartialEq)]
pub struct Probe {
    width: usize,
    seen: Vec<Option<ProbedSurface>>,
}

/// What a pixel's middle shows of a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ProbedSurface {
    /// The geometry's own normal: unit, towards the viewer.
    pub geometric: Vec3,
    /// The normal that the surface is lit by: unit, on the same side.
    pub shading: Vec3,
    /// Whether the sun reaches it.
    pub sun: Sun,
}

/// How a point of a surface and the sun stand to each other.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sun {
    /// The shading normal points away from it.
    Behind,
    /// The surface faces it, but the meshes themselves are between them.
    Blocked,
    /// It shines there.
    Shines,
}

impl Probe {
    /// Looks at a scene, lit from a direction of unit length.
    ///
    /// # Errors
    /// If the camera sees nothing.
    pub fn new(
        scene: &Scene,
        camera: &Camera,
        [width, height]: [usize; 2],
        shading: Shading,
        towards_sun: Vec3,
    ) -> Result<Self, CameraError> {
        let lens = camera.lens(scene.origin(), width, height)?;
        let lens = lens.near(Vicinity::of(scene.bounds()));
        let probing = Probing {
            scene,
            lens,
            shading,
            towards_sun,
        };
        let mut seen = vec![None; width * height];
        seen.par_chunks_mut(width.max(1))
            .enumerate()
            .for_each(|(y, row)| {
                let _flush = flush_denormals();
                for (n, pixels) in row.chunks_mut(LANES).enumerate() {
                    probing.fill(pixels, n * LANES, y);
                }
            });
        Ok(Self::of(width, seen))
    }

    /// What has been seen, row by row.
    pub(super) fn of(width: usize, seen: Vec<Option<ProbedSurface>>) -> Self {
        Self { width, seen }
    }

    /// The pixels, row by row from the top; `None` where no surface is.
    pub fn seen(&self) -> &[Option<ProbedSurface>] {
        &self.seen
    }

    /// What pixels show that see the surface of either probe.
    pub(super) fn both<'a>(
        &'a self,
        other: &'a Self,
    ) -> impl Iterator<Item = (&'a ProbedSurface, &'a ProbedSurface)> {
        self.beside(other).filter_map(|(a, b)| a.zip(b))
    }

    /// What each pixel shows of either probe.
    pub(super) fn beside<'a>(
        &'a self,
        other: &'a Self,
    ) -> impl Iterator<Item = (Option<&'a ProbedSurface>, Option<&'a ProbedSurface>)> {
        let size = |probe: &Self| (probe.width, probe.seen.len());
        assert_eq!(size(self), size(other), "probes of different sizes");
        let pairs = self.seen.iter().zip(&other.seen);
        pairs.map(|(a, b)| (a.as_ref(), b.as_ref()))
    }
}

struct Probing<'a> {
    scene: &'a Scene,
    lens: Lens,
    shading: Shading,
    towards_sun: Vec3,
}

impl Probing<'_> {
    /// Looks through pixels of row `y`, from column `x` on.
    fn fill(&self, pixels: &mut [Option<ProbedSurface>], x: usize, y: usize) {
        let mut packet = RayPacket::<LANES>::new();
        for lane in 0..pixels.len() {
            packet.set_ray(
                lane,
                &self.lens.ray((x + lane) as f32 + 0.5, y as f32 + 0.5),
            );
        }
        let tree = self.scene.tree();
        tree.intersect(&mut packet, &QueryOptions::COHERENT);
        let mut shadows = RayPacket::<LANES>::new();
        for (lane, pixel) in pixels.iter_mut().enumerate() {
            let Some(hit) = packet.hit(lane) else {
                continue;
            };
            let ray = packet.ray(lane);
            let unit = self.scene.normal(&hit);
            let geometric = if unit.dot(ray.direction) > 0.0 {
                -unit
            } else {
                unit
            };
            let shading = self.shading.normal(self.scene, &hit, geometric);
            let faces = shading.dot(self.towards_sun) > 0.0;
            if faces {
                let start = self.scene.leaving_point(&hit, &ray, geometric);
                shadows.set_ray(lane, &Ray::new(start, self.towards_sun));
            }
            *pixel = Some(ProbedSurface {
                geometric,
                shading,
                sun: if faces { Sun::Shines } else { Sun::Behind },
            });
        }
        let dark = tree.occluded(&mut shadows, &QueryOptions::COHERENT);
        for (lane, pixel) in pixels.iter_mut().enumerate() {
            if let Some(seen) = pixel
                && seen.sun == Sun::Shines
                && dark & 1 << lane != 0
            {
                seen.sun = Sun::Blocked;
            }
        }
    }
}
