//! Ends the program on a signal without leaving half-written files behind.

use std::fs;
use std::io;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::thread;

use curvetri::output::remove_unfinished;
use signal_hook::consts::{SIGHUP, SIGINT, SIGQUIT, SIGTERM, SIGXCPU, SIGXFSZ};
use signal_hook::iterator::Signals;
use signal_hook::low_level::emulate_default_handler;

/// The signals that end the program from outside.
const ENDING: [i32; 5] = [SIGHUP, SIGINT, SIGQUIT, SIGTERM, SIGXCPU];

/// From now on these signals end the program as they always do, once its half-written files are removed.
/// A file that would become larger than the user's limit is an error of writing instead.
///
/// A signal that whoever started the program wants ignored stays so, as `nohup` wants it for SIGHUP.
///
/// # Errors
/// If the operating system refuses.
pub fn handle() -> io::Result<()> {
    // With a handler, whatever it does, a write beyond the limit fails and does not end the program.
    signal_hook::flag::register(SIGXFSZ, Arc::new(AtomicBool::new(false)))?;
    let ignored = ignored();
    let mut signals = Signals::new(ENDING.iter().filter(|&&signal| !ignored.contains(signal)))?;
    thread::Builder::new()
        .name("signals".into())
        .spawn(move || {
            if let Some(signal) = signals.forever().next() {
                remove_unfinished(|| {
                    let _ = emulate_default_handler(signal);
                });
            }
        })?;
    Ok(())
}

/// Signals, one bit each.
struct SignalMask(u64);

impl SignalMask {
    fn contains(&self, signal: i32) -> bool {
        (self.0 >> (signal - 1)) & 1 == 1
    }
}

/// What the program ignores from its start. Only Linux tells this in a file; elsewhere there is none.
fn ignored() -> SignalMask {
    let status = fs::read_to_string("/proc/self/status").unwrap_or_default();
    let mut lines = status.lines();
    let mask = lines.find_map(|line| line.strip_prefix("SigIgn:"));
    let mask = mask.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok());
    SignalMask(mask.unwrap_or(0))
}
