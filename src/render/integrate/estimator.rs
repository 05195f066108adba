//! What all ways to find light have in common.

use glam::Vec4;

use super::sampler::Sample;
use crate::embree::RayPacket;
use crate::render::stats::RayCounts;

/// Rays traced together.
pub(super) const LANES: usize = 16;
/// Something for each lane of a packet.
pub(super) type Lanes<T> = [T; LANES];

/// A way to find the light that camera rays bring.
pub(super) trait Estimator: Sync {
    /// Traces a packet of camera rays, whose directions are of unit length, and what lights them.
    /// Gives each lane's radiance, multiplied by its coverage, and the coverage; zeros where it
    /// sees nothing. `samples` are the lanes' random numbers.
    fn trace(
        &self,
        packet: &mut RayPacket<LANES>,
        samples: &Lanes<Sample>,
        rays: &mut RayCounts,
    ) -> Lanes<Vec4>;
}
