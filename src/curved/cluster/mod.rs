//! Clusters: neighbouring triangles as one Embree primitive. The tree is one to three levels lower, there are
//! fewer callbacks, and the boxes of all triangles of a cluster are in two cache lines.

mod build;
mod grouping;
mod layout;
mod ray_test;
#[cfg(test)]
mod test_triangles;

pub(super) use grouping::group;
pub(super) use layout::{Cluster, SIZE};
pub(super) use ray_test::{PacketEntries, RayEntries, lanes_in_boxes};
