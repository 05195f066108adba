//! The renderer: scenes with instances, and pictures against what is known of them.

mod far;
mod instances;
mod integrators;
#[cfg(feature = "compare")]
mod silhouette;
mod terminator;

use curvetri::render::{UserRay, UserRays};

/// A batch of so many rays, without a report of its progress.
fn batch<'a>(count: usize, ray: &'a (dyn Fn(usize) -> UserRay + Sync)) -> UserRays<'a> {
    UserRays {
        count,
        ray,
        progress: &|_| (),
    }
}
