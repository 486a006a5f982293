//! The output of `doctor` on this machine.

use crate::interface::Interface;
use crate::running::{run, text};

#[test]
fn the_doctor_sees_interfaces() {
    let bus = Interface::new("vdoctor");
    let said = text(&run(&["doctor"]).stdout);
    assert!(said.contains("✔ SocketCAN    the kernel has AF_CAN and CAN_RAW"), "{said}");
    assert!(said.contains("✔ interface    vdoctor: virtual, up"), "{said}");
    bus.down();
    let said = text(&run(&["doctor"]).stdout);
    assert!(
        said.contains("✘ interface    vdoctor: virtual, down") && said.contains("ip link set vdoctor up"),
        "{said}"
    );
}

/// Compares the output of `doctor` before the modules were loaded, if this kernel was booted for the tests.
#[test]
fn the_doctor_says_why_there_is_no_can() {
    let Ok(folder) = std::env::var("CANVASS_VCAN_OUT") else { return };
    let said = std::fs::read_to_string(format!("{folder}/doctor-without-can")).unwrap();
    // The machine has Debian's modules in another folder, and loads them itself.
    let why = "✘ SocketCAN    no CAN is loaded, and the modules of kernel ";
    assert!(said.contains(why) && said.contains("-amd64 does not exist): install them"), "{said}");
}
