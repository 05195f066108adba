//! How much work the kernel did on this thread, for statistics.

use std::cell::Cell;
use std::ops::{Add, Sub};

/// Work done by the intersection kernel.
///
/// ```
/// use curvetri::curved::{Counters, counters};
///
/// let before = counters();
/// // ... rays are traced on this thread ...
/// let work: Counters = counters() - before;
/// assert_eq!(work.evaluations, 0);
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counters {
    /// Calls by Embree: one for a packet of rays and a primitive.
    pub callbacks: u64,
    /// Tests of a packet against a triangle.
    pub tests: u64,
    /// Ray-triangle tests: lanes of the tests.
    pub calls: u64,
    /// Evaluations of the surface's height.
    pub evaluations: u64,
}

impl Add for Counters {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self {
            callbacks: self.callbacks + other.callbacks,
            tests: self.tests + other.tests,
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
            tests: self.tests - other.tests,
            calls: self.calls - other.calls,
            evaluations: self.evaluations - other.evaluations,
        }
    }
}

const NONE: Counters = Counters {
    callbacks: 0,
    tests: 0,
    calls: 0,
    evaluations: 0,
};

thread_local! {
    static COUNTERS: Cell<Counters> = const { Cell::new(NONE) };
}

/// What the kernel has done on the calling thread so far. Embree runs the callbacks of a query on
/// the thread that asks, so the difference of two readings is the work of the queries between.
pub fn counters() -> Counters {
    COUNTERS.get()
}

/// Counts a call by Embree.
pub(super) fn count_callback() {
    add(Counters {
        callbacks: 1,
        ..NONE
    });
}

/// Counts tests of packets, their lanes (calls), and what they took.
pub(super) fn count(tests: u64, calls: u64, evaluations: u64) {
    add(Counters {
        tests,
        calls,
        evaluations,
        ..NONE
    });
}

fn add(done: Counters) {
    COUNTERS.set(COUNTERS.get() + done);
}
