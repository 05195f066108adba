//! What the kernel did on this thread, for statistics.

use std::cell::Cell;
use std::ops::{Add, Sub};

/// Work done by the intersection kernel.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counters {
    /// Callbacks: one for a packet of rays and a primitive.
    pub callbacks: u64,
    /// Ray-primitive tests: lanes of callbacks.
    pub calls: u64,
    /// Evaluations of the surface's height.
    pub evaluations: u64,
}

impl Add for Counters {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self {
            callbacks: self.callbacks + other.callbacks,
            calls: self.calls + other.calls,
            evaluations: self.evaluations + other.evaluations,
        }
    }
}

impl Sub for Counters {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        Self {
            callbacks: self.callbacks - other.callbacks,
            calls: self.calls - other.calls,
            evaluations: self.evaluations - other.evaluations,
        }
    }
}

thread_local! {
    static COUNTERS: Cell<Counters> = const { Cell::new(Counters { callbacks: 0, calls: 0, evaluations: 0 }) };
}

/// What the kernel has done on the calling thread so far. Embree runs the callbacks of a query on
/// the thread that asks, so the difference of two readings is the work of the queries between.
pub fn counters() -> Counters {
    COUNTERS.get()
}

/// Counts lanes of one callback and what they took.
pub(super) fn count(calls: u64, evaluations: u64) {
    let callbacks = 1;
    COUNTERS.set(
        COUNTERS.get()
            + Counters {
                callbacks,
                calls,
                evaluations,
            },
    );
}
