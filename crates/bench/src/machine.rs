//! What the measuring is done on.

use std::fs;

use curvetri::embree::Error;

/// A machine and the programs on it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Machine {
    /// The processor's name.
    pub processor: String,
    /// Threads it runs at once.
    pub threads: usize,
    /// Bytes of memory; 0 where that is not known.
    pub memory: u64,
    /// The operating system and the processor's architecture.
    pub system: String,
    /// Embree's version.
    pub embree: String,
    /// The instruction set that Embree uses.
    pub isa: String,
    /// This program's version.
    pub version: String,
}

impl Machine {
    /// This one.
    ///
    /// # Errors
    /// If Embree does not start.
    pub fn new() -> Result<Self, Error> {
        let device = curvetri::linked::device()?;
        let name = fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
        let name = name.lines().find_map(|line| {
            let (key, value) = line.split_once(':')?;
            (key.trim() == "model name").then(|| value.trim().to_owned())
        });
        Ok(Self {
            processor: name.unwrap_or_else(|| "unknown processor".to_owned()),
            threads: all_threads(),
            memory: memory("MemTotal:"),
            system: format!("{} {}", std::env::consts::OS, std::env::consts::ARCH),
            embree: device.version().to_string(),
            isa: device.isa(),
            version: env!("CARGO_PKG_VERSION").to_owned(),
        })
    }
}

/// Threads that run at once.
pub(super) fn all_threads() -> usize {
    std::thread::available_parallelism().map_or(1, usize::from)
}

/// Bytes that can be taken without harm: two thirds of what is free, or a few gigabytes where that is
/// not known.
#[must_use]
pub fn spare_memory() -> u64 {
    match memory("MemAvailable:") {
        0 => 4 << 30,
        available => available / 3 * 2,
    }
}

/// A line of the system's report on memory, in bytes; 0 where there is none.
fn memory(name: &str) -> u64 {
    let report = fs::read_to_string("/proc/meminfo").unwrap_or_default();
    let line = report.lines().find_map(|line| line.strip_prefix(name));
    let kilobytes = line.and_then(|rest| rest.trim().trim_end_matches("kB").trim().parse().ok());
    kilobytes.map_or(0, |kilobytes: u64| kilobytes * 1024)
}
