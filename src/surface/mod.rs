//! The spherical interpolation method: pure maths of one curved triangle, no Embree.
