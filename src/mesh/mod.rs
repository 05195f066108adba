//! Triangle meshes: reading files, vertex normals, which triangles share a side.
