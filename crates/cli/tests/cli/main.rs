//! The command `curvetri` as a whole program.

mod accuracy;
mod bench;
#[cfg(unix)]
mod browser;
mod compare;
#[cfg(unix)]
mod compare_report;
mod errors;
mod exr;
mod inspect;
mod instances;
#[cfg(unix)]
mod outputs;
mod program;
mod render;
mod tessellate;
mod trace;
mod trace_all_hits;
mod warnings;
