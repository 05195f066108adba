//! Who imports whom, read from the sources.
//!
//! [`Sources::read`] reads all modules of a crate. [`Sources::imports`] tells which file uses something that
//! another file defines: by `use`, by a path in the code or in a macro's arguments, by a macro, or by a method that
//! stands in another file than its type. A re-export is followed to the file that defines the item, so an import
//! through the crate's root counts as what it is.
//! [`Sources::faults`] compares the imports with a declared order of folders, and finds circles of files.
//!
//! Code for tests alone, under `#[cfg(test)]`, does not count: tests may use anything. A method's call does not name
//! its type, so it counts only where no other file defines a function of that name.

mod imports;
mod modules;
mod order;
mod paths;

pub use imports::Import;
pub use modules::{ReadError, Sources};
