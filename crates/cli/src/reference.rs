//! `docs/cli.md`: the help of every command, as the program prints it.

use std::fmt::Write;
use std::path::Path;
use std::{env, fs};

use clap::CommandFactory;

use crate::Cli;

/// If set, the test writes the page instead of comparing it.
const WRITE: &str = "CURVETRI_WRITE_REFERENCE";
/// Columns that the help is wrapped to.
const WIDTH: usize = 100;

fn reference() -> String {
    let mut program = Cli::command().term_width(WIDTH);
    program.build();
    let mut page = String::from(
        "# Command line\n\nThe help of every command, as `curvetri COMMAND --help` prints it. \
         [Rendering](rendering.md) explains\nwhat needs more than a line. A test compares this page \
         with the program; to write it anew:\n\n```sh\n",
    );
    let _ = writeln!(page, "{WRITE}=1 cargo test -p curvetri-cli reference\n```");
    section(&mut page, "curvetri", &mut program.clone());
    for command in program.get_subcommands_mut() {
        if command.get_name() != "help" {
            let name = format!("curvetri {}", command.get_name());
            section(&mut page, &name, command);
        }
    }
    page
}

fn section(page: &mut String, name: &str, command: &mut clap::Command) {
    let help = command.render_long_help().to_string();
    let lines = help.trim_end().lines().map(str::trim_end);
    let _ = writeln!(page, "\n## {name}\n\n```text");
    for line in lines {
        let _ = writeln!(page, "{line}");
    }
    page.push_str("```\n");
}

#[test]
fn the_committed_reference_is_the_help_of_the_program() {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/cli.md");
    let page = reference();
    if env::var_os(WRITE).is_some() {
        fs::write(&file, page).expect("docs/cli.md can be written");
        return;
    }
    let committed = fs::read_to_string(&file).expect("docs/cli.md is there");
    assert!(
        committed == page,
        "docs/cli.md is out of date: {WRITE}=1 cargo test -p curvetri-cli reference"
    );
}
