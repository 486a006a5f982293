//! SLCAN over a pty pair and over TCP, between two of ours and with python-can.

use crate::interface::ip;
use crate::python::{python, script};
use crate::running::{Running, canvass, eventually, run, simulate, text};
use std::process::{Command, Stdio};
use std::time::Duration;

const MODEL: &str = "kuebler-sendix-58x8";

/// Two ends of one line.
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
    assert_eq!(tested.status.code(), Some(0), "{report:#}");
    assert_eq!(device.interrupt().status, 0);
}

/// The kernel's own SLCAN driver as the program at our adapter's end. It sets the bit rate and opens the channel.
#[test]
fn with_the_kernels_driver() {
    if std::env::var_os("CANVASS_VCAN_OUT").is_none() {
        // Another machine may have interfaces of its own, and no such driver.
        return;
    }
    let (_line, a, b) = pty_pair("kernel");
    let device = simulate(MODEL, &format!("slcan:{a}"), &[]);
    let mut attach = Command::new("slcan_attach");
    let _attached = Running::start({
        attach.args(["-w", &b]).stdin(Stdio::null());
        attach
    });
    eventually("the interface is there", || std::path::Path::new("/sys/class/net/slcan0").exists());
    ip(&["link", "set", "slcan0", "up", "type", "can", "bitrate", "250000"]);
    let said = sdo("slcan0");
    assert!(said.contains("Kuebler Sendix Encoder"), "{said}");
    assert_eq!(device.interrupt().status, 0);
}

/// python-can's slcan as a program at our adapter's end, and as an adapter's user at ours.
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
