//! Programs find the Embree of `EMBREE_DIR` where it was when they were linked: its `lib/` becomes their run-time path.
//!
//! Cargo lets a package do so for its own programs alone. So the packages under `crates/` that have programs or tests
//! which link Embree have this file too, by a symbolic link.

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    // the build script of curvetri-embree-linked tells it, where EMBREE_DIR is set
    if let Ok(lib) = std::env::var("DEP_EMBREE_LIB") {
        println!("cargo::rustc-link-arg=-Wl,-rpath,{lib}");
    }
}
