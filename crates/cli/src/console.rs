//! What people and programs see: messages, progress, results.

use std::io::{self, IsTerminal, Write};
use std::time::Duration;

use anyhow::Result;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressFinish, ProgressStyle};

/// Messages and progress on standard error, as much of them as the user wants.
pub struct Console {
    quiet: bool,
    verbose: bool,
}

impl Console {
    pub fn new(quiet: bool, verbose: bool) -> Self {
        Self { quiet, verbose }
    }

    /// Something the user should know, unless `--quiet`.
    pub fn warn(&self, text: &str) {
        if !self.quiet {
            let _ = writeln!(io::stderr(), "curvetri: warning: {text}");
        }
    }

    /// Something only `--verbose` shows.
    pub fn note(&self, text: &str) {
        if self.verbose {
            let _ = writeln!(io::stderr(), "curvetri: {text}");
        }
    }

    /// A bar for work of this length, shown on a terminal only.
    pub fn progress(&self, what: &'static str, length: u64) -> ProgressBar {
        let shown = !self.quiet && io::stderr().is_terminal();
        let target = if shown {
            ProgressDrawTarget::stderr()
        } else {
            ProgressDrawTarget::hidden()
        };
        let style = "{msg:10} {wide_bar} {percent:>3} % {eta:>4}";
        ProgressBar::with_draw_target(Some(length), target)
            .with_style(ProgressStyle::with_template(style).expect("a fixed template"))
            .with_message(what)
            // also when an error ends the work
            .with_finish(ProgressFinish::AndClear)
    }

    /// A sign of life for work of unknown length, shown on a terminal only.
    pub fn spinner(&self, what: &'static str) -> ProgressBar {
        let bar = self.progress(what, 0);
        bar.set_style(
            ProgressStyle::with_template("{msg:10} {spinner}").expect("a fixed template"),
        );
        if !bar.is_hidden() {
            bar.enable_steady_tick(Duration::from_millis(100));
        }
        bar
    }
}

/// Prints a result on standard output.
pub fn print(text: &str) -> Result<()> {
    let mut out = io::stdout().lock();
    out.write_all(text.as_bytes())?;
    out.flush()?;
    Ok(())
}

/// Whether the reader of standard output went away, which is no reason for words.
pub fn is_closed_pipe(error: &anyhow::Error) -> bool {
    error
        .downcast_ref::<io::Error>()
        .is_some_and(|error| error.kind() == io::ErrorKind::BrokenPipe)
}
