//! Interfaces with a controller and a bit rate: `can0` and `can1`, which QEMU emulates on one bus.

use crate::interface::ip;
use crate::running::{eventually, run, simulate, text};
use serde_json::Value;

const MODEL: &str = "reference-301";

/// Whether the interfaces exist: only the tests' own machine has them.
fn are_here() -> bool {
    std::env::var_os("CANVASS_VCAN_OUT").is_some()
}

fn up(interface: &str, bit_rate: &str) {
    ip(&["link", "set", interface, "down"]);
    ip(&["link", "set", interface, "up", "type", "can", "bitrate", bit_rate]);
}

fn bit_rate(interface: &str) -> String {
    ip(&["-details", "link", "show", interface]).split_once("bitrate ").unwrap().1.chars().take(6).collect()
}

/// The verdicts of cases that need to know the bit rate of the bus.
fn bit_rate_cases(bus: &str) -> Vec<(String, String)> {
    let args =
        ["test", bus, "--device", MODEL, "--select", "305/bit-timing", "--allow", "bit-rate", "--format", "json"];
    let ran = run(&args);
    let report: Value =
        serde_json::from_slice(&ran.stdout).unwrap_or_else(|error| panic!("{error}: {}", text(&ran.stderr)));
    let text = |case: &Value, key: &str| case[key].as_str().unwrap().to_owned();
    report["cases"].as_array().unwrap().iter().map(|case| (text(case, "id"), text(case, "verdict"))).collect()
}

#[test]
fn a_bit_rate_is_asked_for_known_and_changed() {
    if !are_here() {
        return;
    }
    let down = text(&run(&["sdo", "read", "can0", "10", "1000"]).stderr);
    assert!(down.contains("can0 is down: ip link set can0 up type can bitrate 250000"), "{down}");
    up("can0", "250000");
    up("can1", "250000");
    let device = simulate(MODEL, "can1", &[]);
    let doctor = text(&run(&["doctor"]).stdout);
    assert!(doctor.contains("✔ interface    can0: controller, up, 250 kbit/s, error-active"), "{doctor}");
    // With heartbeats, the tester requests no state by remote frames. QEMU's SJA1000 handles the announced data byte of
    // a remote frame wrongly, so that the following frames are garbage.
    let heartbeats = run(&["sdo", "write", "can0", "10", "1017", "500"]);
    assert!(heartbeats.status.success(), "{}", text(&heartbeats.stderr));

    let found = bit_rate_cases("can0");
    assert_eq!(found, bit_rate_cases(&format!("sim:{MODEL}")));
    assert!(found.contains(&("305/bit-timing/activate".to_owned(), "pass".to_owned())), "{found:?}");

    // The device changes its bit rate, and sets its interface to the same bit rate.
    let changed = run(&["lss", "configure", "can0", "--bit-rate", "500k", "--activate", "100ms"]);
    assert!(changed.status.success(), "{}", text(&changed.stderr));
    eventually("the interface of the device has 500 kbit/s", || bit_rate("can1") == "500000");
    up("can0", "500000");
    // The device stays silent for a second delay.
    let reads = || text(&run(&["sdo", "read", "can0", "10", "1000"]).stdout).contains("1000h:00");
    eventually("the device answers at 500 kbit/s", reads);
    let ended = device.interrupt();
    assert!(ended.status == 0 && !ended.stderr.contains("went down"), "{}", ended.stderr);
    ip(&["link", "set", "can0", "down"]);
    ip(&["link", "set", "can1", "down"]);
}
