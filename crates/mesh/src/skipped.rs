//! Elements of a file that are wrong: the file is refused, or they are skipped and counted.

use crate::error::Fault;

/// What is done with elements that are wrong and can be left out, and how many there were.
#[derive(Debug, Default, Clone, PartialEq)]
pub(crate) struct Skipped {
    lenient: bool,
    count: u64,
    /// What was wrong with the first.
    first: Option<String>,
}

impl Skipped {
    /// None so far. A lenient reader skips what is wrong, others refuse the file.
    pub(crate) fn new(lenient: bool) -> Skipped {
        Skipped {
            lenient,
            ..Skipped::default()
        }
    }

    /// The same rule with nothing skipped so far.
    pub(crate) fn fresh(&self) -> Skipped {
        Skipped::new(self.lenient)
    }

    /// Skips an element for this reason.
    ///
    /// # Errors
    ///
    /// The reason, with `element`, which a lenient reader would skip, where this one is not lenient.
    pub(crate) fn skip(&mut self, element: &str, fault: Fault) -> Result<(), Fault> {
        if !self.lenient {
            return Err(fault.with(&format!("; --lenient skips {element}")));
        }
        self.count += 1;
        self.first.get_or_insert_with(|| fault.text());
        Ok(())
    }

    /// Adds what was skipped later in the file.
    pub(crate) fn append(&mut self, later: Skipped) {
        self.count += later.count;
        if self.first.is_none() {
            self.first = later.first;
        }
    }

    /// How many were skipped.
    pub(crate) fn count(&self) -> u64 {
        self.count
    }

    /// A sentence for the user, if anything was skipped.
    pub(crate) fn warning(&self) -> Option<String> {
        let first = self.first.as_ref()?;
        Some(match self.count {
            1 => format!("1 wrong element was skipped: {first}"),
            count => format!("{count} wrong elements were skipped; the first: {first}"),
        })
    }
}
