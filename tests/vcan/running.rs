//! Processes that run at the same time as a test.

use serde_json::Value;
use std::io::{BufRead, BufReader, Read};
use std::process::{Child, ChildStderr, Command, Output, Stdio};
use std::time::{Duration, Instant};

/// The program with these arguments, in the project's folder.
pub fn canvass(args: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_canvass"));
    command.args(args).current_dir(env!("CARGO_MANIFEST_DIR")).stdin(Stdio::null());
    command
}

/// Runs the program to its end.
pub fn run(args: &[&str]) -> Output {
    canvass(args).output().unwrap()
}

/// The verdict of each case in a report, in one line each, for the message of a failed test.
pub fn brief(report: &Value) -> String {
    let cases = report["cases"].as_array().into_iter().flatten();
    let lines = cases.map(|case| format!("{} {} {}", case["verdict"], case["id"], case["reason"]));
    let lines: Vec<String> = lines.filter(|line| !line.starts_with("\"not_applicable")).collect();
    format!("{}\n{}", report["summary"], lines.join("\n"))
}

pub fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

/// A process that is killed at the end of the test, if it has not ended before.
pub struct Running {
    child: Child,
    stderr: Option<BufReader<ChildStderr>>,
}

impl Running {
    pub fn start(mut command: Command) -> Self {
        let mut child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        let stderr = child.stderr.take().map(BufReader::new);
        Self { child, stderr }
    }

    /// Waits for a line on standard error that contains these words.
    pub fn says(&mut self, words: &str) -> String {
        let stderr = self.stderr.as_mut().unwrap();
        let mut all = String::new();
        loop {
            let mut line = String::new();
            assert!(stderr.read_line(&mut line).unwrap() > 0, "expected \"{words}\", found \"{all}\"");
            if line.contains(words) {
                return line;
            }
            all += &line;
        }
    }

    /// Waits for the n-th line on standard output that contains one of these words.
    pub fn prints(&mut self, words: &[&str], n: usize) {
        let stdout = BufReader::new(self.child.stdout.take().unwrap());
        let lines = stdout.lines().map(Result::unwrap).filter(|line| words.iter().any(|words| line.contains(words)));
        assert_eq!(lines.take(n).count(), n, "lines with one of {words:?}");
    }

    /// Waits for the n-th line on standard output that contains `word`, counted from the first line that contains
    /// `first`.
    pub fn prints_after(&mut self, first: &str, word: &str, n: usize) {
        let stdout = BufReader::new(self.child.stdout.take().unwrap());
        let lines = stdout.lines().map(Result::unwrap).skip_while(|line| !line.contains(first));
        assert_eq!(lines.filter(|line| line.contains(word)).take(n).count(), n, "lines with {word} after {first}");
    }

    pub fn signal(&self, signal: &str) {
        let status = Command::new("kill").args([signal, &self.child.id().to_string()]).status().unwrap();
        assert!(status.success());
    }

    /// Waits for the end of the process; returns its output.
    pub fn finish(mut self) -> Ended {
        let mut stdout = Vec::new();
        // Standard error is so short that it fits into its pipe.
        self.child.stdout.take().unwrap().read_to_end(&mut stdout).unwrap();
        let mut stderr = String::new();
        self.stderr.take().unwrap().read_to_string(&mut stderr).unwrap();
        let status = self.child.wait().unwrap();
        Ended { status: status.code().unwrap_or(-1), stdout: text(&stdout), stderr }
    }

    pub fn has_ended(&mut self) -> bool {
        self.child.try_wait().unwrap().is_some()
    }

    /// Ends the process as Ctrl-C does.
    pub fn interrupt(self) -> Ended {
        self.signal("-INT");
        self.finish()
    }

    pub fn kill(mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// The result of a process that has ended.
pub struct Ended {
    pub status: i32,
    pub stdout: String,
    pub stderr: String,
}

/// A simulated device that has booted.
pub fn simulate(model: &str, bus: &str, more: &[&str]) -> Running {
    let mut device = Running::start(canvass(&[&["simulate", model, bus], more].concat()));
    device.says("on ");
    // The device needs this time for its initialisation.
    std::thread::sleep(Duration::from_millis(600));
    device
}

/// Waits until the condition holds.
pub fn eventually(what: &str, mut is_so: impl FnMut() -> bool) {
    let begun = Instant::now();
    while !is_so() {
        assert!(begun.elapsed() < Duration::from_secs(60), "{what}");
        std::thread::sleep(Duration::from_millis(50));
    }
}
