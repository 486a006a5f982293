//! SLCAN over a pair of pseudo-terminals and over TCP, between two programs of ours and with python-can.

use crate::interface::ip;
use crate::python::{python, script};
use crate::running::{Running, brief, canvass, run, simulate, text};
use std::process::Command;
use std::time::Duration;

const MODEL: &str = "kuebler-sendix-58x8";

/// A serial line with two ends.
fn pty_pair(name: &str) -> (Running, String, String) {
    let ends = ["a", "b"].map(|end| format!("/tmp/canvass-{name}-{end}"));
    let mut line = Running::start(python(&["line", &ends[0], &ends[1]]));
    line.says("ready");
    let [a, b] = ends;
    (line, a, b)
}

fn sdo(bus: &str) -> String {
    let output = run(&["sdo", "read", bus, "63", "1008"]);
    format!("{}{}", text(&output.stdout), text(&output.stderr))
}

#[test]
fn over_a_pty_pair() {
    let (_line, a, b) = pty_pair("ours");
    let device = simulate(MODEL, &format!("slcan:{a}@250k"), &[]);
    let said = sdo(&format!("slcan:{b}@250k"));
    assert!(said.contains("Kuebler Sendix Encoder"), "{said}");
    assert_eq!(device.interrupt().status, 0);
}

#[test]
fn over_tcp() {
    let device = simulate(MODEL, "slcan:listen://127.0.0.1:20711", &[]);
    let bus = "slcan:tcp://127.0.0.1:20711@250k";
    let tested = run(&["test", bus, "--device", MODEL, "--select", "301/sdo/upload", "--format", "json"]);
    let report: serde_json::Value = serde_json::from_slice(&tested.stdout).unwrap();
    assert_eq!(tested.status.code(), Some(0), "{}", brief(&report));
    assert_eq!(device.interrupt().status, 0);
}

/// The kernel's own SLCAN driver uses our simulated adapter: it sets the bit rate and opens the channel.
#[test]
fn with_the_kernels_driver() {
    if std::env::var_os("CANVASS_VCAN_OUT").is_none() {
        // Another machine may have interfaces of its own, and lack this driver.
        return;
    }
    let (_line, a, b) = pty_pair("kernel");
    let device = simulate(MODEL, &format!("slcan:{a}"), &[]);
    let attach = |args: &[&str]| assert!(Command::new("slcan_attach").args(args).status().unwrap().success());
    // The device at the other end of the line keeps the port open, so that the interface stays.
    attach(&["-n", "slcan0", &b]);
    ip(&["link", "set", "slcan0", "up", "type", "can", "bitrate", "250000"]);
    let said = sdo("slcan0");
    assert!(said.contains("Kuebler Sendix Encoder"), "{said}");
    assert_eq!(device.interrupt().status, 0);
    attach(&["-d", &b]);
}

/// python-can's slcan uses our simulated adapter.
#[test]
fn with_python_can() {
    let (_line, a, b) = pty_pair("python");
    let mut device = Running::start(canvass(&["simulate", MODEL, &format!("slcan:{a}@250k")]));
    device.says("on ");
    std::thread::sleep(Duration::from_millis(500));
    let said = script(&["slcan", &b]);
    assert!(said.contains("5BF#4300100096010200"), "{said}");
    device.interrupt();
}
