//! A triangle's flags: which of its edges are straight, and what the options request.

use crate::curved::options::CurvedOptions;
use crate::mesh::Topology;
use curvetri_method::PatchFlags;

/// A triangle's flags as its own edges have them.
pub(super) fn flags_of(
    topology: &Topology,
    triangle: usize,
    options: &CurvedOptions,
) -> PatchFlags {
    let none = PatchFlags::new(options.surface).with_bounds(options.bounds);
    if options.unchecked {
        return none.with_unchecked();
    }
    let edges = topology.edges(triangle);
    (0..3).fold(none, |flags, k| {
        if edges[k].is_straight() {
            flags.with_straight(k)
        } else {
            flags
        }
    })
}

/// A triangle's flags with its edges towards another triangle straight.
pub(super) fn straight_towards(
    topology: &Topology,
    flags: PatchFlags,
    triangle: usize,
    other: u32,
) -> PatchFlags {
    let neighbours = topology.neighbours(triangle);
    (0..3).fold(flags, |flags, k| {
        if neighbours[k] == other {
            flags.with_straight(k)
        } else {
            flags
        }
    })
}
