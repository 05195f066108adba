//! Meshes from files and from programs.

mod fuzz_seeds;
mod made_bodies;
