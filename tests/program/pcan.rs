//! Every command that takes a bus works on a channel of PEAK's library. A stand-in for that library connects to a
//! simulated device in another process.
#![cfg(any(windows, target_os = "linux"))]

use crate::live::Device;
use crate::running::{Run, finished};
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use tempfile::TempDir;

const ROOT: &str = env!("CARGO_MANIFEST_DIR");
const BUS: &str = "pcan:PCAN_USBBUS1@250k";

/// A folder with the stand-in library, and the bus to which it connects.
struct Installed {
    folder: TempDir,
    /// The local TCP port of the bus.
    port: String,
}

impl Installed {
    /// Connects the channel to the bus `slcan:tcp://HOST:PORT`.
    fn before(bus: &str) -> Self {
        let folder = tempfile::tempdir().unwrap();
        install(folder.path());
        let port = bus.rsplit(':').next().unwrap().to_owned();
        Self { folder, port }
    }

    fn command(&self, args: &[&str]) -> Command {
        let mut command = Command::new(self.program());
        command.args(args).current_dir(ROOT).env("PCAN_STAND_IN", &self.port).stdin(Stdio::null());
        command.env("LD_LIBRARY_PATH", self.folder.path());
        command
    }

    /// The program to run. On Windows it is a copy beside the stand-in library, because Windows looks for libraries in
    /// the folder of the program.
    fn program(&self) -> PathBuf {
        let built = PathBuf::from(env!("CARGO_BIN_EXE_canvass"));
        if !cfg!(windows) {
            return built;
        }
        let beside = self.folder.path().join("canvass.exe");
        if !beside.exists() {
            std::fs::copy(built, &beside).unwrap();
        }
        beside
    }

    fn run(&self, args: &[&str]) -> Run {
        finished(self.command(args).output().unwrap())
    }
}

/// Compiles the stand-in. For Windows it was compiled before, as there is no compiler under Wine.
fn install(folder: &Path) {
    if cfg!(windows) {
        std::fs::copy(format!("{ROOT}/target/windows/PCANBasic.dll"), folder.join("PCANBasic.dll")).unwrap();
        return;
    }
    let source = format!("{ROOT}/conformance/bus/tests/pcan/stand_in.c");
    let library = folder.join("libpcanbasic.so");
    let built = Command::new("cc").args(["-shared", "-fPIC", "-o"]).arg(library).args([&source, "-lpthread"]).status();
    assert!(built.unwrap().success());
}

fn json(run: &Run) -> Value {
    serde_json::from_str(&run.stdout).unwrap_or_else(|error| panic!("{error}: {}{}", run.stdout, run.stderr))
}

/// The device behind SLCAN takes one client after the other, and needs a moment between them.
#[test]
fn a_device_is_found_asked_commanded_and_recorded() {
    let device = Device::of("kuebler-sendix-58x8", &[]);
    let pcan = Installed::before(&device.bus);
    let scan = json(&pcan.run(&["scan", BUS, "--format", "json", "--no-lss"]));
    assert_eq!(scan["nodes"][0]["node"], 63, "{scan}");
    let read = pcan.run(&["sdo", "read", BUS, "63", "1008", "--device", "kuebler-sendix-58x8"]);
    assert!(read.stdout.contains("Kuebler Sendix Encoder"), "{}{}", read.stdout, read.stderr);
    let written = pcan.run(&["sdo", "write", BUS, "63", "1017", "1000"]);
    assert_eq!(written.status, 0, "{}", written.stderr);
    let reset = pcan.run(&["nmt", BUS, "reset-node", "63"]);
    assert!(reset.stdout.contains("boot-up"), "{}{}", reset.stdout, reset.stderr);
    let sent = pcan.run(&["send", BUS, "63F#4000100000000000"]);
    assert!(sent.stdout.contains("5BF"), "{}{}", sent.stdout, sent.stderr);
    let lss = json(&pcan.run(&["lss", "inquire", BUS, "--format", "json"]));
    assert_eq!(lss["vendor_id"], 0x13, "{lss}");
    pcan.run(&["sdo", "write", BUS, "63", "1017", "50"]);
    let seen = pcan.run(&["monitor", BUS, "--for", "2s"]);
    assert!(seen.stdout.contains("heartbeat"), "{}{}", seen.stdout, seen.stderr);
    let log = pcan.folder.path().join("bus.log");
    let record = pcan.run(&["record", BUS, log.to_str().unwrap(), "--for", "2s"]);
    assert_eq!(record.status, 0, "{}", record.stderr);
    assert!(std::fs::read_to_string(&log).unwrap().contains("PCAN_USBBUS1 73F#"), "{}", record.stderr);
    let silent = pcan.run(&["sdo", "read", "pcan:usbbus1@250k+listen-only", "63", "1008"]);
    assert!(silent.status == 3 && silent.stderr.contains("only listens"), "{}", silent.stderr);
}

#[test]
fn a_device_is_tested_and_attacked() {
    let device = Device::of("kuebler-sendix-58x8", &[]);
    let pcan = Installed::before(&device.bus);
    let of_model = ["--device", "kuebler-sendix-58x8", "--format", "json"];
    let tested = json(&pcan.run(&[&["test", BUS, "--select", "301/sdo/upload"], &of_model[..]].concat()));
    assert_eq!(tested["summary"]["fail"], 0, "{tested:#}");
    assert!(tested["summary"]["pass"].as_u64() > Some(0) && tested["host"]["lost"] == 0, "{tested:#}");
    let fuzzed = pcan.run(&[&["fuzz", BUS, "--target", "sdo", "--for", "3s"], &of_model[..]].concat());
    assert!(json(&fuzzed)["executions"].as_u64() > Some(0), "{}", fuzzed.stderr);
}

/// The reverse setup: the simulated device uses the library, and `monitor` is at the other end.
#[test]
fn a_simulated_device_is_at_the_adapter() {
    let address = std::net::TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap().to_string();
    let listener = format!("slcan:listen://{address}");
    let mut watching = crate::running::command(&["monitor", &listener, "--for", "8s"]);
    let mut watching = watching.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let pcan = Installed::before(&address);
    let simulate = || {
        let mut command = pcan.command(&["simulate", "kuebler-sendix-58x8", BUS]);
        command.stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap()
    };
    let mut simulating = simulate();
    while watching.try_wait().unwrap().is_none() {
        // `monitor` did not listen yet, so that the simulation ended.
        if simulating.try_wait().unwrap().is_some() {
            simulating = simulate();
        }
        std::thread::sleep(std::time::Duration::from_millis(100));
    }
    let seen = finished(watching.wait_with_output().unwrap());
    simulating.kill().unwrap();
    simulating.wait().unwrap();
    assert!(seen.stdout.contains("73F") && seen.stdout.contains("boot-up"), "{}{}", seen.stdout, seen.stderr);
}

#[test]
fn the_doctor_and_errors_say_what_there_is() {
    let device = Device::of("kuebler-sendix-58x8", &[]);
    let pcan = Installed::before(&device.bus);
    let doctor = pcan.run(&["doctor"]).stdout;
    assert!(doctor.contains("PCAN-Basic") && doctor.contains("version 4.9.0.942: PCAN_USBBUS1 (PCAN-USB)"), "{doctor}");
    let absent = pcan.run(&["scan", "pcan:PCAN_USBBUS2@250k"]);
    assert_eq!(absent.status, 3, "{}", absent.stderr);
    assert!(absent.stderr.contains("PCAN_USBBUS2") && absent.stderr.contains("plug it in"), "{}", absent.stderr);
    for (bus, status, says) in [
        ("pcan:PCAN_USBBUS1", 2, "pcan:PCAN_USBBUS1@250k"),
        ("pcan:PCAN_USBBUS99@250k", 2, "PCAN_USBBUS1"),
        ("pcan:PCAN_USBBUS1@123456", 3, "125k"),
    ] {
        let wrong = pcan.run(&["scan", bus]);
        assert_eq!((wrong.status, wrong.stderr.contains(says)), (status, true), "{bus}: {}", wrong.stderr);
    }
    // Without the library, the program reports that it is missing.
    let missing = crate::running::run(&["scan", BUS]);
    assert!(missing.status == 3 && missing.stderr.contains("PCAN-Basic"), "{}", missing.stderr);
    let doctor = crate::running::run(&["doctor"]).stdout;
    assert!(doctor.contains("not installed: only pcan:CHANNEL needs it"), "{doctor}");
}
