//! The order of vertices and edges: 0, 1, 2 and 0 again. Edge `k` runs from vertex `k` to the next one.

/// The vertex, or the edge, after this one.
pub(crate) const fn next(k: usize) -> usize {
    (k + 1) % 3
}
