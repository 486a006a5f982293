//! Captures for the tests, and their pages.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::Command;

/// A candump log that is being written.
#[derive(Default)]
pub struct Log {
    text: String,
    frames: Vec<(u64, String)>,
}

impl Log {
    /// Adds a frame at a time in microseconds.
    pub fn at(&mut self, us: u64, frame: &str) -> &mut Self {
        self.frames.push((us, frame.to_owned()));
        self
    }

    /// An SDO request and its answer `later` microseconds after the request.
    pub fn sdo(&mut self, us: u64, node: u8, request: &str, answer: &str, later: u64) -> &mut Self {
        self.at(us, &format!("6{node:02X}#{request}")).at(us + later, &format!("5{:02X}#{answer}", 0x80 + node))
    }

    /// The text of the log, all on one channel.
    pub fn on(&mut self, channel: &str) -> &str {
        self.frames.sort_by_key(|frame| frame.0);
        for (us, frame) in self.frames.drain(..) {
            writeln!(self.text, "({}.{:06}) {channel} {frame}", 1_700_000_000 + us / 1_000_000, us % 1_000_000)
                .unwrap();
        }
        &self.text
    }
}

/// The traffic of an encoder for `seconds` seconds: a client reads its mapping, and the encoder sends its position
/// every 10 ms.
pub fn machine(seconds: u64) -> Log {
    let mut log = Log::default();
    let end = seconds * 1_000_000;
    log.at(1_000, "703#00");
    for (n, (request, answer)) in [
        ("4000100000000000", "4300100096010200"),
        ("4018100100000000", "4318100113000000"),
        ("4001180100000000", "4301180183020000"),
        ("40011A0000000000", "4F011A0001000000"),
        ("40011A0100000000", "43011A0120000460"),
    ]
    .into_iter()
    .enumerate()
    {
        log.sdo(20_000 + n as u64 * 5_000, 3, request, answer, 900);
    }
    log.at(100_000, "000#0103");
    for us in (150_000..end).step_by(10_000) {
        let position = (us / 10_000 * 7 % 4_096) as u32;
        log.at(us, &format!("283#{:08X}", position.swap_bytes()));
    }
    for us in (110_000..end).step_by(100_000) {
        log.at(us + 37, "703#05").at(us + 51, "701#05");
    }
    for us in (500_000..end).step_by(500_000) {
        log.sdo(us + 333, 3, "4004600000000000", "4304600010200000", 700 + us / 1_000 % 977);
    }
    log
}

/// The machine with an error that comes and goes, a restart of the encoder by itself, and a request for an object that
/// the encoder lacks.
pub fn faulty() -> Log {
    let mut log = machine(40);
    log.at(12_000_123, "083#1081110000000000").at(12_400_123, "083#0000000000000000");
    log.at(20_000_123, "703#00").at(20_300_123, "000#0103");
    log.sdo(30_100_777, 3, "4099600000000000", "8099600000000206", 1_200);
    log
}

/// A folder with the page of a capture; it is deleted after the test.
pub struct Page {
    folder: tempfile::TempDir,
    pub path: PathBuf,
}

impl Page {
    /// The page of `canvass diagnose` for a log, whose file gets this name.
    pub fn of(log: &str, name: &str) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let capture = folder.path().join(name);
        std::fs::write(&capture, log).unwrap();
        let path = folder.path().join("page.html");
        let arguments = ["diagnose", "--fail-on", "never", "--format", "html", "--format-in", "candump"];
        made(Command::new(env!("CARGO_BIN_EXE_canvass")).args(arguments).arg("--output").arg(&path).arg(&capture));
        Self { folder, path }
    }

    /// The page of a conformance run.
    pub fn of_test(bus: &str) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("page.html");
        let report = format!("html={}", path.display());
        made(Command::new(env!("CARGO_BIN_EXE_canvass")).args(["test", bus, "--report", &report]));
        Self { folder, path }
    }

    /// The folder of the capture.
    pub fn folder(&self) -> &Path {
        self.folder.path()
    }
}

/// Runs the program, which may end with findings.
fn made(command: &mut Command) {
    let output = command.output().unwrap();
    let status = output.status.code();
    assert!(matches!(status, Some(0 | 1)), "{status:?}: {}", String::from_utf8_lossy(&output.stderr));
}
