//! The query under way on a thread: its filter, and a panic on its way to the caller.

use std::any::Any;
use std::cell::Cell;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::ptr;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use super::filter::Filter;
use super::table::Table;

/// How to trace a packet.
///
/// ```
/// use curvetri_embree::{Candidate, QueryOptions};
///
/// let back = |candidate: &Candidate| candidate.hit.ng.dot(candidate.ray.direction) > 0.0;
/// let options = QueryOptions::COHERENT.with_filter(&back);
/// assert!(options.coherent);
/// ```
#[derive(Clone, Copy, Default)]
pub struct QueryOptions<'a> {
    /// The packet's rays are alike, as a camera's are: Embree walks its tree once for all of them.
    pub coherent: bool,
    /// Decides which hits count, after the geometry's own filter. Only for scenes made with
    /// [`SceneBuilder::query_filters`](super::SceneBuilder::query_filters).
    pub filter: Option<&'a Filter<'a>>,
}

impl<'a> QueryOptions<'a> {
    /// For rays that go many ways.
    pub const INCOHERENT: Self = Self {
        coherent: false,
        filter: None,
    };
    /// For rays that are alike.
    pub const COHERENT: Self = Self {
        coherent: true,
        filter: None,
    };

    /// The same with a filter.
    pub fn with_filter(self, filter: &'a Filter<'a>) -> Self {
        Self {
            filter: Some(filter),
            ..self
        }
    }
}

type Payload = Box<dyn Any + Send>;

/// A query under way: lives on the stack of the function that asked.
pub(super) struct Query<'a> {
    embree: &'static Table,
    filter: Option<&'a Filter<'a>>,
    panicked: Cell<bool>,
    payload: Cell<Option<Payload>>,
}

thread_local! {
    // Embree runs a query's callbacks on the thread that asked, so they find it here, also where a
    // callback asks a query of its own and comes back.
    static CURRENT: Cell<*const Query<'static>> = const { Cell::new(ptr::null()) };
}

/// Puts the outer query back, also on unwinding.
struct Restore(*const Query<'static>);

impl Drop for Restore {
    fn drop(&mut self) {
        CURRENT.set(self.0);
    }
}

/// Runs a query with its filter, and resumes a panic of its callbacks here.
pub(super) fn run(embree: &'static Table, filter: Option<&Filter<'_>>, call: impl FnOnce()) {
    let query = Query {
        embree,
        filter,
        panicked: Cell::new(false),
        payload: Cell::new(None),
    };
    let outer = CURRENT.replace(ptr::from_ref(&query).cast());
    let restore = Restore(outer);
    call();
    drop(restore);
    if let Some(payload) = query.payload.take() {
        resume_unwind(payload);
    }
}

impl Query<'_> {
    /// Calls with the query under way on this thread, or with `None` where another program's own
    /// query reached us.
    pub(super) fn with_current<T>(call: impl FnOnce(Option<&Query<'_>>) -> T) -> T {
        let current = CURRENT.get();
        // SAFETY: the pointer is null or that of a query on this thread's stack, further out than
        // this call, which takes it back before it ends.
        call(unsafe { current.as_ref() })
    }

    /// The query's own filter.
    pub(super) fn filter(&self) -> Option<&Filter<'_>> {
        self.filter
    }

    /// The Embree that runs it.
    pub(super) fn embree(&self) -> &'static Table {
        self.embree
    }

    fn keep(&self, payload: Payload) {
        self.panicked.set(true);
        self.payload.set(Some(payload));
    }
}

/// Runs the Rust part of a callback of a query. Returns `None`, quickly, if this or an earlier
/// callback of the query panicked; the panic resumes where the query was asked.
pub(super) fn callback<T>(call: impl FnOnce(Option<&Query<'_>>) -> T) -> Option<T> {
    Query::with_current(|query| {
        if query.is_some_and(|query| query.panicked.get()) {
            return None;
        }
        // What a panic leaves half done belongs to the caller it resumes in.
        match catch_unwind(AssertUnwindSafe(|| call(query))) {
            Ok(result) => Some(result),
            Err(payload) => {
                // without a query of ours there is no caller to resume in: the panic's own message
                // is all that can be said
                if let Some(query) = query {
                    query.keep(payload);
                }
                None
            }
        }
    })
}

/// Panics of a geometry's bounds callback, which Embree may call from any of its threads.
#[derive(Default)]
pub(super) struct BuildPanics {
    count: AtomicU64,
    pending: AtomicBool,
    payload: Mutex<Option<Payload>>,
}

impl BuildPanics {
    /// Runs a bounds callback; `None`, quickly, once one panicked.
    pub(super) fn callback<T>(&self, call: impl FnOnce() -> T) -> Option<T> {
        if self.pending.load(Ordering::Relaxed) {
            return None;
        }
        match catch_unwind(AssertUnwindSafe(call)) {
            Ok(result) => Some(result),
            Err(payload) => {
                let mut kept = self
                    .payload
                    .lock()
                    .unwrap_or_else(|poison| poison.into_inner());
                kept.get_or_insert(payload);
                self.pending.store(true, Ordering::Relaxed);
                self.count.fetch_add(1, Ordering::Relaxed);
                None
            }
        }
    }

    /// How many there were so far.
    pub(super) fn count(&self) -> u64 {
        self.count.load(Ordering::Relaxed)
    }

    /// After a build that began when there were `before`: resumes the panic there was since.
    pub(super) fn resume(&self, before: u64) {
        if self.count() == before {
            return;
        }
        let payload = self
            .payload
            .lock()
            .unwrap_or_else(|poison| poison.into_inner())
            .take();
        self.pending.store(false, Ordering::Relaxed);
        match payload {
            Some(payload) => resume_unwind(payload),
            // the same geometry in two scenes, built at the same time: the other one has it
            None => panic!("the bounds callback of a geometry panicked"),
        }
    }
}
