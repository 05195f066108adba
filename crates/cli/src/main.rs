//! The `curvetri` command: one file a command, with its arguments and a `run` function.

mod accuracy;
mod accuracy_report;
mod advice;
mod bench;
mod bench_report;
mod compare;
mod console;
mod inspect;
mod integrator;
mod light;
mod paint;
#[cfg(test)]
mod reference;
mod render;
#[cfg(unix)]
mod signals;
mod stats;
mod surface;
mod tessellate;
mod trace;
mod values;
mod view;

use std::fmt;
use std::io::{self, Write};
use std::panic::{self, AssertUnwindSafe};
use std::process::ExitCode;

use anyhow::{Context, Result};
use clap::error::ErrorKind;
use clap::{CommandFactory, Parser, Subcommand};

use crate::console::Console;
use curvetri::embree::Device;

/// Ray-traces triangle meshes with vertex normals as the smooth curved surfaces they stand for.
#[derive(Parser)]
#[command(
    name = "curvetri",
    disable_version_flag = true,
    arg_required_else_help = true
)]
struct Cli {
    #[command(subcommand)]
    command: Option<Command>,

    /// Print the version, Embree's version and the instruction set it uses
    #[arg(short = 'V', long)]
    version: bool,

    /// Print errors only
    #[arg(short, long, global = true, conflicts_with = "verbose")]
    quiet: bool,

    /// Print what is being done
    #[arg(short, long, global = true)]
    verbose: bool,
}

#[derive(Subcommand)]
enum Command {
    Render(Box<render::RenderArgs>),
    Compare(Box<compare::CompareArgs>),
    Trace(trace::TraceArgs),
    Accuracy(accuracy::AccuracyArgs),
    Inspect(inspect::InspectArgs),
    Tessellate(tessellate::TessellateArgs),
    Bench(bench::BenchArgs),
}

/// A mistake in the arguments that only shows when they are seen together.
#[derive(Debug)]
struct Usage(String);

impl fmt::Display for Usage {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(&self.0)
    }
}

impl std::error::Error for Usage {}

/// Ends a command with a [`Usage`] error.
fn usage<T>(message: impl Into<String>) -> Result<T> {
    Err(Usage(message.into()).into())
}

/// Runs the command. Exit codes: 0, 1 for failed work, 2 for usage.
fn main() -> ExitCode {
    panic::set_hook(Box::new(report_panic));
    let cli = match Cli::try_parse() {
        Ok(cli) => cli,
        Err(error) => return refused(&error),
    };
    match panic::catch_unwind(AssertUnwindSafe(|| run(&cli))) {
        Ok(Ok(())) => ExitCode::SUCCESS,
        Ok(Err(error)) => failed(&error),
        // the hook has reported it
        Err(_) => ExitCode::FAILURE,
    }
}

fn run(cli: &Cli) -> Result<()> {
    #[cfg(unix)]
    signals::handle().context("cannot handle signals")?;
    let console = Console::new(cli.quiet, cli.verbose);
    match &cli.command {
        _ if cli.version => print_version(),
        Some(Command::Render(args)) => render::run(args, &console),
        Some(Command::Compare(args)) => compare::run(args, &console),
        Some(Command::Trace(args)) => trace::run(args, &console),
        Some(Command::Accuracy(args)) => accuracy::run(args, &console),
        Some(Command::Inspect(args)) => inspect::run(args, &console),
        Some(Command::Tessellate(args)) => tessellate::run(args, &console),
        Some(Command::Bench(args)) => bench::run(args, &console),
        None => usage("no command is given; see curvetri --help"),
    }
}

fn print_version() -> Result<()> {
    let device = device(None)?;
    console::print(&format!(
        "curvetri {}\nEmbree {} ({})\n",
        env!("CARGO_PKG_VERSION"),
        device.version(),
        device.isa()
    ))
}

/// Embree, building on this many threads.
fn device(threads: Option<usize>) -> Result<Device> {
    let config = threads.map(|threads| format!("threads={threads}"));
    curvetri::linked::device_with_config(config.as_deref().unwrap_or_default())
        .context("Embree does not start")
}

/// Runs work on this many threads.
fn on_threads<T: Send>(
    threads: Option<usize>,
    work: impl FnOnce() -> Result<T> + Send,
) -> Result<T> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads.unwrap_or(0));
    pool.build()
        .context("cannot start the threads")?
        .install(work)
}

/// Prints what the parser found wrong, or the help that the user wants.
fn refused(error: &clap::Error) -> ExitCode {
    let text = error.render();
    if matches!(error.kind(), ErrorKind::DisplayHelp) {
        return match console::print(&text.to_string()) {
            Ok(()) => ExitCode::SUCCESS,
            Err(error) => failed(&error),
        };
    }
    let name = if text.to_string().starts_with("error: ") {
        "curvetri: "
    } else {
        ""
    };
    let _ = write!(io::stderr(), "{name}{text}");
    ExitCode::from(2)
}

/// Prints an error with its chain of causes.
fn failed(error: &anyhow::Error) -> ExitCode {
    if console::is_closed_pipe(error) {
        return ExitCode::FAILURE;
    }
    let _ = writeln!(io::stderr(), "curvetri: error: {}", chain(error));
    if error.is::<Usage>() {
        let usage = Cli::command().render_usage();
        let _ = writeln!(
            io::stderr(),
            "\n{usage}\n\nFor more information, try '--help'."
        );
        return ExitCode::from(2);
    }
    ExitCode::FAILURE
}

/// The error and its causes, without those that the one before already contains.
fn chain(error: &anyhow::Error) -> String {
    let mut text = error.to_string();
    for cause in error.chain().skip(1) {
        let cause = cause.to_string();
        if !text.ends_with(&cause) {
            text += ": ";
            text += &cause;
        }
    }
    text
}

/// A panic is a fault of this program: one line of what to report, not a trace.
fn report_panic(info: &panic::PanicHookInfo<'_>) {
    let place = info
        .location()
        .map_or_else(String::new, |at| format!(" at {at}"));
    let payload = info.payload();
    let text = payload.downcast_ref::<&str>().copied();
    let text = text.or_else(|| payload.downcast_ref::<String>().map(String::as_str));
    let what = text.unwrap_or("unknown");
    let _ = writeln!(
        io::stderr(),
        "curvetri: error: a fault in curvetri itself{place} (please report it): {what}"
    );
}
