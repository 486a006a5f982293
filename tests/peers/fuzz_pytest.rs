//! The test for pytest that `canvass fuzz --reproducers` writes fails on a device with the fault, and passes on a device
//! without it: python-canopen sees the devices through python-can's SLCAN over TCP.

use std::io::{BufRead, BufReader};
use std::net::TcpListener;
use std::path::Path;
use std::process::{Child, Command, Output, Stdio};

const CANVASS: &str = env!("CARGO_BIN_EXE_canvass");

/// A process that is ended with this value.
struct Ended(Child);

impl Drop for Ended {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// A simulated device with these options in a process, and the address of its bus.
fn simulate(options: &[&str]) -> (Ended, String) {
    let address = TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap();
    let mut command = Command::new(CANVASS);
    command.args(["simulate", "reference-301", &format!("slcan:listen://{address}")]).args(options);
    let mut child = command.stdin(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap();
    let mut line = String::new();
    BufReader::new(child.stderr.take().unwrap()).read_line(&mut line).unwrap();
    (Ended(child), format!("socket://{address}"))
}

/// Runs the tests in the folder on a device with these options.
fn pytest(folder: &Path, options: &[&str]) -> Output {
    let (_device, channel) = simulate(options);
    Command::new(crate::python::PYTHON)
        .args(["-m", "pytest", "-q", "-p", "no:cacheprovider"])
        .arg(folder)
        .env("CAN_INTERFACE", "slcan")
        .env("CAN_CHANNEL", channel)
        .env("CAN_BITRATE", "250000")
        .output()
        .unwrap_or_else(|error| panic!("{error}; cargo xtask peers installs the peers that these tests need"))
}

#[test]
fn python_canopen_shows_the_violations_too() {
    for fault in ["sdo-toggle-unchecked", "sdo-unknown-command-silent", "heartbeat-period-doubled"] {
        let folder = tempfile::tempdir().unwrap();
        let bus = format!("sim:reference-301+{fault}");
        let fuzz = ["fuzz", &bus, "--seed", "1", "--runs", "2000", "--stop-at-first", "--reproducers"];
        let fuzzed = Command::new(CANVASS).args(fuzz).arg(folder.path()).output().unwrap();
        assert_eq!(fuzzed.status.code(), Some(1), "{}", String::from_utf8_lossy(&fuzzed.stderr));
        let (faulty, healthy) = (pytest(folder.path(), &["--fault", fault]), pytest(folder.path(), &[]));
        let told = |output: &Output| String::from_utf8_lossy(&output.stdout).into_owned();
        assert_eq!(faulty.status.code(), Some(1), "{fault}: {}", told(&faulty));
        assert_eq!(healthy.status.code(), Some(0), "{fault}: {}", told(&healthy));
    }
}
