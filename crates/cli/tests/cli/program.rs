//! Runs the program in a directory of its own.

use std::fmt::Write;
use std::fs;
use std::process::{Command, Output};

/// A directory for one test's files.
pub struct Workshop(tempfile::TempDir);

impl Workshop {
    pub fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    /// The path of a file in the directory.
    pub fn path(&self, name: &str) -> String {
        self.0.path().join(name).to_str().unwrap().to_owned()
    }

    /// Writes a file and returns its path.
    pub fn write(&self, name: &str, content: impl AsRef<[u8]>) -> String {
        let path = self.path(name);
        fs::write(&path, content).unwrap();
        path
    }

    /// The names of all files, sorted.
    pub fn names(&self) -> Vec<String> {
        let entries = fs::read_dir(self.0.path()).unwrap();
        let mut names: Vec<_> = entries
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .collect();
        names.sort();
        names
    }

    /// The unit sphere as four triangles, which the method makes exactly round.
    pub fn sphere(&self, name: &str) -> String {
        self.moved_sphere(name, [0.0; 3])
    }

    /// The same with its centre elsewhere.
    pub fn moved_sphere(&self, name: &str, centre: [f64; 3]) -> String {
        let corners = [[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]];
        let mut text = String::new();
        for corner in corners {
            let n = corner.map(|c| f64::from(c) / 3_f64.sqrt());
            let p: Vec<f64> = n.iter().zip(centre).map(|(n, c)| n + c).collect();
            writeln!(text, "v {} {} {}", p[0], p[1], p[2]).unwrap();
            writeln!(text, "vn {} {} {}", n[0], n[1], n[2]).unwrap();
        }
        text += "f 1//1 2//2 3//3\nf 1//1 3//3 4//4\nf 1//1 4//4 2//2\nf 2//2 4//4 3//3\n";
        self.write(name, text)
    }

    /// Runs the program.
    pub fn run(&self, args: &[&str]) -> Output {
        let mut program = Command::new(env!("CARGO_BIN_EXE_curvetri"));
        program
            .args(args)
            .current_dir(self.0.path())
            .output()
            .unwrap()
    }

    /// Runs the program, which must succeed.
    pub fn succeeds(&self, args: &[&str]) -> Output {
        let output = self.run(args);
        assert!(output.status.success(), "{args:?}: {}", stderr(&output));
        output
    }

    /// Runs the program, which must fail with this exit code; returns what it says.
    pub fn fails(&self, code: i32, args: &[&str]) -> String {
        let output = self.run(args);
        let text = stderr(&output);
        assert_eq!(output.status.code(), Some(code), "{args:?}: {text}");
        assert!(text.starts_with("curvetri: error: "), "{args:?}: {text}");
        let fault = text.contains("panicked") || text.contains("a fault in curvetri");
        assert!(!fault, "{args:?}: {text}");
        assert_eq!(stdout(&output), "", "an error is no result");
        text
    }
}

/// What a run printed as its result.
pub fn stdout(output: &Output) -> String {
    String::from_utf8(output.stdout.clone()).unwrap()
}

/// What a run said.
pub fn stderr(output: &Output) -> String {
    String::from_utf8(output.stderr.clone()).unwrap()
}
