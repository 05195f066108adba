//! What time is taken.

use std::sync::OnceLock;
use std::time::Instant;

/// Which time is taken of what is measured.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Clock {
    /// That on the wall.
    #[default]
    Wall,
    /// That which the threads run, a thread, where the system tells (else that on the wall): what
    /// others do on the same machine then takes no part in it, nor do threads that wait for each other.
    Processor,
}

impl Clock {
    /// Seconds of the whole program so far, in all threads together or on the wall.
    pub(super) fn program_time(self) -> f64 {
        match self {
            Self::Wall => wall_time(),
            Self::Processor => processor::program_time(),
        }
    }
}

/// Seconds that this thread has run.
pub(super) fn thread_time() -> f64 {
    processor::thread_time()
}

/// Seconds since the first call.
fn wall_time() -> f64 {
    static START: OnceLock<Instant> = OnceLock::new();
    START.get_or_init(Instant::now).elapsed().as_secs_f64()
}

#[cfg(unix)]
mod processor {
    use rustix::time::{ClockId, clock_gettime};

    fn seconds(clock: ClockId) -> f64 {
        let time = clock_gettime(clock);
        time.tv_sec as f64 + 1e-9 * time.tv_nsec as f64
    }

    pub fn thread_time() -> f64 {
        seconds(ClockId::ThreadCPUTime)
    }

    pub fn program_time() -> f64 {
        seconds(ClockId::ProcessCPUTime)
    }
}

#[cfg(not(unix))]
mod processor {
    pub use super::wall_time as thread_time;
    pub use super::wall_time as program_time;
}
