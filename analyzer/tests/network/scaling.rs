//! Positions and speeds of encoders in the units that their configuration determines.

use crate::trace::Trace;

/// Node 5 answers an SDO upload with four bytes.
fn shows(trace: &mut Trace, address: &str, value: u32) {
    let [a, b, c, d] = value.to_le_bytes();
    trace.say(&format!("605#40 {address} 00 00 00 00"));
    trace.say(&format!("585#43 {address} {a:02X} {b:02X} {c:02X} {d:02X}"));
}

fn position(trace: &mut Trace) -> String {
    trace.say("605#40 04 60 00 00 00 00 00");
    trace.say("585#43 04 60 00 BA 4C 00 00").text
}

const DEVICE_TYPE: &str = "00 10 00";
const OPERATING: &str = "00 60 00";
const UNITS: &str = "01 60 00";
const RESOLUTION: &str = "01 65 00";
const LINEAR_STEP: &str = "05 60 01";

#[test]
fn degrees_of_a_rotary_encoder() {
    let mut trace = Trace::new();
    shows(&mut trace, DEVICE_TYPE, 0x0002_0196);
    assert!(position(&mut trace).ends_with("= 19642 steps"), "neither resolution is known");
    shows(&mut trace, UNITS, 3600);
    assert!(position(&mut trace).ends_with("= 19642 steps (1964.2°)"));
    shows(&mut trace, RESOLUTION, 8192);
    shows(&mut trace, OPERATING, 0);
    assert!(position(&mut trace).ends_with("= 19642 steps (863.173828°)"), "without scaling, 6501h counts");
    shows(&mut trace, OPERATING, 4);
    assert!(position(&mut trace).ends_with("= 19642 steps (1964.2°)"));
    shows(&mut trace, UNITS, 0);
    assert!(position(&mut trace).ends_with("= 19642 steps"), "nothing divides by zero");
}

/// TR-Electronic manual 004: 6501h = 10 000 is 0.01 mm.
#[test]
fn millimetres_of_a_linear_encoder() {
    let mut trace = Trace::new();
    shows(&mut trace, DEVICE_TYPE, 0x0008_0196);
    shows(&mut trace, RESOLUTION, 10_000);
    assert!(position(&mut trace).ends_with("= 19642 steps (196.42 mm)"));
    shows(&mut trace, LINEAR_STEP, 1_000);
    assert!(position(&mut trace).ends_with("= 19642 steps (19.642 mm)"), "6005h:01 is what is configured");
}

#[test]
fn other_profiles_have_no_positions() {
    let mut trace = Trace::new();
    shows(&mut trace, DEVICE_TYPE, 0x0002_0191);
    shows(&mut trace, UNITS, 3600);
    let said = trace.say("585#43 04 60 00 BA 4C 00 00");
    assert_eq!((said.service(), said.text.contains("steps")), ("sdo", false));
}

/// The position in a PDO follows the configuration too.
#[test]
fn process_data_follow_the_configuration() {
    let mut trace = Trace::new();
    shows(&mut trace, DEVICE_TYPE, 0x0002_0196);
    shows(&mut trace, "00 1A 00", 1);
    shows(&mut trace, "00 1A 01", 0x6004_0020);
    assert_eq!(trace.say("185#BA 4C 00 00").text, "TPDO 1: 6004h:00 Position value = 19642 steps");
    shows(&mut trace, UNITS, 3600);
    assert_eq!(trace.say("185#BA 4C 00 00").text, "TPDO 1: 6004h:00 Position value = 19642 steps (1964.2°)");
}

fn speed(trace: &mut Trace) -> String {
    trace.say("605#40 30 60 01 00 00 00 00");
    trace.say("585#4B 30 60 01 F6 FF 00 00").text
}

#[test]
fn speeds_have_the_unit_of_the_speed_format() {
    let mut trace = Trace::new();
    shows(&mut trace, DEVICE_TYPE, 0x0002_0196);
    assert!(speed(&mut trace).ends_with("= -10"), "no unit is known");
    shows(&mut trace, "18 10 01", 0x13);
    shows(&mut trace, "07 65 00", 0x0102_0302);
    shows(&mut trace, OPERATING, 0);
    assert!(speed(&mut trace).ends_with("= -10 rpm"));
    shows(&mut trace, OPERATING, 0x2000);
    assert!(speed(&mut trace).ends_with("= -10 steps/s"));
    // From version 4.1 on, the bit is bit 12.
    shows(&mut trace, "07 65 00", 0x0102_0401);
    assert!(speed(&mut trace).ends_with("= -10 rpm"));
}

#[test]
fn speeds_are_multiplied_and_divided() {
    let mut trace = Trace::new();
    shows(&mut trace, DEVICE_TYPE, 0x0002_0196);
    shows(&mut trace, "31 60 03", 2);
    shows(&mut trace, "31 60 04", 5);
    assert!(speed(&mut trace).ends_with("= -25 steps/s"));
    shows(&mut trace, "31 60 03", 0);
    assert!(speed(&mut trace).ends_with("= -10"));
}
