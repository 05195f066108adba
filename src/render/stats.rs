//! What a picture took.

use std::ops::Add;
use std::time::Duration;

use crate::curved::{Counters, Kinds, Spheres};

/// What a picture took: time, memory, rays, and the kernel's work.
///
/// ```
/// use std::time::Duration;
///
/// use curvetri::render::{MemoryParts, RayCounts, RenderStats, Times};
///
/// let stats = RenderStats {
///     rays: RayCounts { primary: 3_000_000, shadow: 1_000_000, bounce: 0 },
///     times: Times { render: Duration::from_secs(2), ..Times::default() },
///     memory: MemoryParts { mesh: 1 << 20, ..MemoryParts::default() },
///     ..RenderStats::default()
/// };
/// assert_eq!(stats.mray_per_second(), 2.0);
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RenderStats {
    /// Triangles by kind, of all meshes; a mesh counts once, however often it is used.
    pub triangles: Kinds,
    /// Uses of meshes that are used several times.
    pub instances: usize,
    /// Curved triangles by the sphere that bounds them, where spheres were requested.
    pub spheres: Spheres,
    /// Time by step.
    pub times: Times,
    /// Memory by part.
    pub memory: MemoryParts,
    /// RayCounts by kind.
    pub rays: RayCounts,
    /// The kernel's work; none for flat triangles, which are Embree's own.
    pub kernel: Counters,
}

/// Time by step.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Times {
    /// Reading the files and making missing normals; known to whoever read them.
    pub load: Duration,
    /// Finding shared edges and building the patches.
    pub curve: Duration,
    /// Building Embree's tree.
    pub build: Duration,
    /// Tracing and shading.
    pub render: Duration,
}

/// Memory by part, in bytes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct MemoryParts {
    /// Positions, normals and indices.
    pub mesh: u64,
    /// Packed patches, clusters and placements.
    pub records: u64,
    /// Embree's tree, and its copies of flat triangles.
    pub embree: u64,
}

/// RayCounts by kind.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct RayCounts {
    /// From the camera.
    pub primary: u64,
    /// That ask whether something is in the way: to the sun, the lamp or the sky.
    pub shadow: u64,
    /// From surface to surface.
    pub bounce: u64,
}

impl RayCounts {
    /// All rays.
    pub fn total(&self) -> u64 {
        self.primary + self.shadow + self.bounce
    }
}

impl Add for RayCounts {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self {
            primary: self.primary + other.primary,
            shadow: self.shadow + other.shadow,
            bounce: self.bounce + other.bounce,
        }
    }
}

impl RenderStats {
    /// Millions of rays a second, while rendering.
    pub fn mray_per_second(&self) -> f64 {
        ratio(
            self.rays.total() as f64 * 1e-6,
            self.times.render.as_secs_f64(),
        )
    }

    /// Ray-patch tests a ray.
    pub fn calls_per_ray(&self) -> f64 {
        ratio(self.kernel.calls as f64, self.rays.total() as f64)
    }

    /// Evaluations of the surface a ray-patch test.
    pub fn evaluations_per_call(&self) -> f64 {
        ratio(self.kernel.evaluations as f64, self.kernel.calls as f64)
    }
}

/// The quotient, or 0 where there is nothing to divide by.
fn ratio(part: f64, whole: f64) -> f64 {
    if whole > 0.0 { part / whole } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ratios_are_by_ray_and_by_call() {
        let stats = RenderStats {
            rays: RayCounts {
                primary: 5,
                shadow: 2,
                bounce: 1,
            },
            kernel: Counters {
                callbacks: 5,
                tests: 7,
                calls: 16,
                evaluations: 40,
            },
            times: Times {
                render: Duration::from_micros(4),
                ..Times::default()
            },
            ..RenderStats::default()
        };
        assert_eq!(stats.calls_per_ray(), 2.0);
        assert_eq!(stats.evaluations_per_call(), 2.5);
        assert!((stats.mray_per_second() - 2.0).abs() < 1e-9);
        assert_eq!(RenderStats::default().calls_per_ray(), 0.0);
    }
}
