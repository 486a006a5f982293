//! Runs the program in a folder.

use std::io::{ErrorKind, Write};
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use tempfile::TempDir;

/// A folder in which the program runs.
pub struct Folder(TempDir);

impl Folder {
    pub fn new() -> Self {
        Self(TempDir::new().unwrap())
    }

    /// Adds a file with this content to the folder.
    pub fn with(self, name: &str, content: impl AsRef<[u8]>) -> Self {
        std::fs::write(self.path(name), content).unwrap();
        self
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    pub fn read(&self, name: &str) -> String {
        String::from_utf8(std::fs::read(self.path(name)).unwrap()).unwrap()
    }

    pub fn command(&self, args: &str) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_canvass"));
        command.args(args.split_whitespace()).current_dir(self.0.path());
        command
    }

    /// Status, standard output and standard error of a run without standard input.
    pub fn run(&self, args: &str) -> (i32, String, String) {
        ended(&self.command(args).stdin(Stdio::null()).output().unwrap())
    }

    /// Status, standard output and standard error of a run with this standard input.
    pub fn run_with_input(&self, args: &str, input: &[u8]) -> (i32, String, String) {
        let mut command = self.command(args);
        command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
        let mut child = command.spawn().unwrap();
        let written = child.stdin.take().unwrap().write_all(input);
        // A program that ends for another reason need not read its input.
        if let Err(error) = written {
            assert_eq!(error.kind(), ErrorKind::BrokenPipe);
        }
        ended(&child.wait_with_output().unwrap())
    }

    /// Runs the program, which must succeed. Returns standard error.
    pub fn good(&self, args: &str) -> String {
        let (status, _, errors) = self.run(args);
        assert_eq!(status, 0, "{args}: {errors}");
        errors
    }
}

pub fn ended(output: &Output) -> (i32, String, String) {
    let text = |bytes: &[u8]| String::from_utf8(bytes.to_vec()).unwrap();
    (output.status.code().unwrap_or(-1), text(&output.stdout), text(&output.stderr))
}

/// The path of a sample of canvass-traces.
pub fn sample(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("traces/samples").join(name)
}
