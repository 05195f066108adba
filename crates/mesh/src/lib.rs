//! Triangle meshes: files, vertex normals, and which triangles share an edge.
//!
//! [`Loader`] reads a file (OBJ, PLY, STL, OFF, glTF) into a [`Mesh`], with a report of what it
//! found. Every reader first makes a [`RawMesh`] of what its file says. [`RawMesh::into_mesh`]
//! checks it, makes missing normals and merges corners into vertices. [`Topology`] then finds the
//! triangles that share an edge, and how they meet there.
//!
//! The modules, each of which uses only those above it:
//!
//! | module | what is in it |
//! |---|---|
//! | `error`, `bounds`, `scenery` | errors, boxes, cameras and lights |
//! | `mesh`, `vertex_order`, `instances` | the finished mesh, the order of its vertices, its instances |
//! | `topology` | vertices at one place, shared edges, T-junctions |
//! | `normals` | normals from a file or made from the triangles |
//! | `report`, `raw_mesh`, `write_obj` | from what a file says to a mesh, and back |
//! | `skipped`, `polygons`, `model` | wrong elements; polygons cut into triangles; a file's meshes and their instances |
//! | `formats` | one reader a file format |
//! | `loader` | the way in |
//!
//! Words used throughout: a *corner* is one of a triangle's three. A *place* is a position that
//! vertices have, counted once however many have it. A *vertex* is a position and a normal; vertices
//! with different normals may share a place.

mod bounds;
mod error;
mod formats;
mod instances;
mod loader;
mod mesh;
mod model;
mod normals;
mod polygons;
mod raw_mesh;
mod report;
mod scenery;
mod skipped;
mod topology;
mod vertex_order;
mod write_obj;

pub use bounds::Bounds;
pub use error::{LoadError, MAX_COORDINATE, MAX_INDICES, MeshError};
pub use instances::{Parts, Placement};
pub use loader::{Loaded, LoadedParts, Loader};
pub use mesh::Mesh;
pub use normals::{NO_NORMAL, NormalOptions, NormalsPolicy, NormalsReport};
pub use raw_mesh::RawMesh;
pub use report::LoadReport;
pub use scenery::{FileCamera, FileCone, FileLamp, Scenery};
pub use topology::{EdgeKind, NO_TRIANGLE, Topology, TopologyCounts, t_junctions, weld};
pub use write_obj::{obj_text, write_obj};
