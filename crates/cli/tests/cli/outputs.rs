//! What becomes of output files when the program is ended from outside.

use std::os::unix::process::ExitStatusExt;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::thread;
use std::time::Duration;

use crate::program::{Workshop, stderr};

/// Begins a picture that takes minutes, and waits until its file is begun.
fn long_render(shop: &Workshop) -> Child {
    let mesh = shop.sphere("ball.obj");
    // Who runs the tests may ignore signals, as nohup does; then the program would as well.
    let mut program = Command::new("env");
    program
        .args([
            "--default-signal=INT,TERM,HUP",
            env!("CARGO_BIN_EXE_curvetri"),
        ])
        .args(["render", &mesh, "-o", &shop.path("out.png")])
        .args(["--size", "4000x4000", "--samples", "256"])
        .stderr(Stdio::null());
    let mut child = program.spawn().unwrap();
    while !is_begun(shop) {
        let ended = child.try_wait().unwrap();
        assert!(ended.is_none(), "ended before it began its file: {ended:?}");
        thread::sleep(Duration::from_millis(5));
    }
    child
}

fn is_begun(shop: &Workshop) -> bool {
    shop.names().iter().any(|name| name.ends_with(".part"))
}

/// Ends it by a signal.
fn end(mut child: Child, signal: &str) -> ExitStatus {
    let kill = Command::new("sh")
        .args(["-c", &format!("kill -s {signal} {}", child.id())])
        .status();
    assert!(kill.unwrap().success());
    child.wait().unwrap()
}

#[test]
fn an_interrupted_program_leaves_nothing_behind() {
    for (signal, number) in [("INT", 2), ("TERM", 15), ("HUP", 1)] {
        let shop = Workshop::new();
        shop.write("out.png", "old");
        let status = end(long_render(&shop), signal);
        assert_eq!(status.signal(), Some(number));
        assert_eq!(shop.names(), ["ball.obj", "out.png"], "{signal}");
        assert_eq!(std::fs::read(shop.path("out.png")).unwrap(), b"old");
    }
}

#[test]
fn what_a_killed_program_left_is_removed_by_the_next_one() {
    let shop = Workshop::new();
    end(long_render(&shop), "KILL");
    assert!(is_begun(&shop));
    let args = ["-o", &shop.path("out.png"), "--size", "8x8"];
    shop.succeeds(&[&["render", &shop.path("ball.obj")], &args[..]].concat());
    assert_eq!(shop.names(), ["ball.obj", "out.png"]);
}

#[test]
fn a_limit_of_file_size_is_an_error() {
    let shop = Workshop::new();
    let mesh = shop.sphere("ball.obj");
    shop.write("out.obj", "old");
    let mut program = Command::new("sh");
    // of 512 or 1024 bytes each
    program.args(["-c", "ulimit -f 4; exec \"$@\"", "sh"]);
    program.args([env!("CARGO_BIN_EXE_curvetri"), "tessellate", &mesh]);
    program.args(["-o", &shop.path("out.obj"), "--level", "40"]);
    let output = program.output().unwrap();
    let said = stderr(&output);
    assert_eq!(output.status.code(), Some(1), "{said}");
    assert!(said.contains("out.obj"), "{said}");
    assert!(said.contains("File too large"), "{said}");
    assert_eq!(shop.names(), ["ball.obj", "out.obj"]);
    assert_eq!(std::fs::read(shop.path("out.obj")).unwrap(), b"old");
}

#[test]
fn a_signal_that_is_ignored_from_the_start_stays_so() {
    let shop = Workshop::new();
    let mesh = shop.sphere("ball.obj");
    // the shell's trap is inherited
    let script = "trap '' HUP; \"$@\" & child=$!; \
        while ! ls -A | grep -q part; do kill -0 $child || exit 9; done; \
        kill -s HUP $child; wait $child";
    let mut program = Command::new("bash");
    program.args(["-c", script, "bash", env!("CARGO_BIN_EXE_curvetri")]);
    program.args(["render", &mesh, "-o", "out.png", "--size", "300x200"]);
    program.args(["--samples", "64"]);
    program.current_dir(shop.path(""));
    let output = program.output().unwrap();
    assert!(output.status.success(), "{}", stderr(&output));
    assert_eq!(shop.names(), ["ball.obj", "out.png"]);
}
