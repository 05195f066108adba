//! A mesh as one Embree user geometry of curved triangles.
