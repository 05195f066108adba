//! Finds the installed Embree and builds the shim over it.
fn main() {}
