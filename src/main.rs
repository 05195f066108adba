//! The `curvetri` command.
fn main() {}
