//! Messages as text, in the words of the standards, and the meaning of the bits in their numbers.

// `cfg(test)` changes nothing here, but tells clippy that a test may unwrap.
#![cfg(test)]

use canvass_analyzer::network::sdo::{Direction, Mode, Side, Violation};
use canvass_analyzer::wire::case_marker::Verdict;
use canvass_analyzer::wire::emcy::{Emcy, EmcyCode, ErrorRegister};
use canvass_analyzer::wire::flying_master::FlyingMaster;
use canvass_analyzer::wire::layer_setting::Protocol;
use canvass_analyzer::wire::lss::{self, Bound, ConfigureCommand, Lss, Part};
use canvass_analyzer::wire::pdo::{TransmissionType, extract, insert};
use canvass_analyzer::wire::sdo::{Expedited, Request, Response, Segment};
use canvass_analyzer::wire::{Malformed, Wire};
use canvass_traces::CanId;

/// The parts of the LSS address and the bounds of "identify remote slave" by their names in CiA 305.
#[test]
fn layer_setting_in_words() {
    assert_eq!(Part::ALL.map(Part::name), ["vendor-ID", "product code", "revision number", "serial number"]);
    assert_eq!(
        Bound::ALL.map(Bound::name),
        [
            "vendor-ID",
            "product code",
            "lowest revision number",
            "highest revision number",
            "lowest serial number",
            "highest serial number"
        ]
    );
    use ConfigureCommand::{BitTiming, NodeId, Store};
    for (command, errors) in [
        (NodeId, [Some("successful"), Some("node-ID out of range"), None, Some("manufacturer-specific error")]),
        (BitTiming, [Some("successful"), Some("bit rate not supported"), None, Some("manufacturer-specific error")]),
        (
            Store,
            [
                Some("successful"),
                Some("storing not supported"),
                Some("storage media access error"),
                Some("manufacturer-specific error"),
            ],
        ),
    ] {
        assert_eq!([0, 1, 2, 255].map(|error| command.error_name::<Lss>(error)), errors, "{command:?}");
        assert_eq!(command.error_name::<Lss>(3), None);
    }
    let request = |bytes: [u8; 8]| lss::Request::read(&bytes).unwrap().to_string();
    for (bytes, text) in [
        ([0x04, 0, 0, 0, 0, 0, 0, 0], "switch state global: waiting"),
        ([0x04, 1, 0, 0, 0, 0, 0, 0], "switch state global: configuration"),
        ([0x04, 2, 0, 0, 0, 0, 0, 0], "switch state global: reserved mode 2"),
        ([0x11, 5, 0, 0, 0, 0, 0, 0], "configure node-ID 5"),
        ([0x11, 255, 0, 0, 0, 0, 0, 0], "configure node-ID: none"),
        ([0x13, 0, 0, 0, 0, 0, 0, 0], "configure bit timing: 1000 kbit/s"),
        ([0x13, 0, 1, 0, 0, 0, 0, 0], "configure bit timing: 800 kbit/s"),
        ([0x13, 0, 5, 0, 0, 0, 0, 0], "configure bit timing: reserved index 5"),
        ([0x13, 0, 8, 0, 0, 0, 0, 0], "configure bit timing: 10 kbit/s"),
        ([0x13, 0, 9, 0, 0, 0, 0, 0], "configure bit timing: automatic bit rate detection"),
        ([0x13, 0, 10, 0, 0, 0, 0, 0], "configure bit timing: reserved index 10"),
        ([0x13, 128, 3, 0, 0, 0, 0, 0], "configure bit timing: table 128, index 3"),
        ([0x15, 0xE8, 3, 0, 0, 0, 0, 0], "activate bit timing, delay 1000 ms"),
        ([0x17, 0, 0, 0, 0, 0, 0, 0], "store configuration"),
        ([0x43, 1, 0, 0, 0, 0, 0, 0], "switch state selective: serial number 00000001h"),
        ([0x48, 1, 0, 0, 0, 0, 0, 0], "identify remote slave: lowest revision number 00000001h"),
        ([0x4C, 0, 0, 0, 0, 0, 0, 0], "identify non-configured remote slave"),
        ([0x51, 0, 0, 0, 0, 128, 0, 0], "Fastscan: begin"),
        ([0x51, 1, 0, 0, 0, 31, 3, 0], "Fastscan: serial number 00000001h down to bit 31, next part 0"),
        ([0x51, 1, 0, 0, 0, 31, 4, 0], "Fastscan: reserved part 00000001h down to bit 31, next part 0"),
        ([0x5C, 0, 0, 0, 0, 0, 0, 0], "inquire revision number"),
        ([0x5E, 0, 0, 0, 0, 0, 0, 0], "inquire node-ID"),
        ([0x99, 0, 0, 0, 0, 0, 0, 0], "unknown command specifier 99h"),
    ] {
        assert_eq!(request(bytes), text);
    }
    let response = |bytes: [u8; 8]| {
        let response = lss::Response::read(&bytes).unwrap();
        (response.to_string(), response.says_too_much())
    };
    for (bytes, text, too_much) in [
        ([0x11, 0, 0, 0, 0, 0, 0, 0], "configure node-ID: successful", false),
        ([0x13, 1, 0, 0, 0, 0, 0, 0], "configure bit timing: bit rate not supported", false),
        ([0x17, 3, 0, 0, 0, 0, 0, 0], "store configuration: reserved error 3", false),
        ([0x11, 255, 7, 0, 0, 0, 0, 0], "configure node-ID: manufacturer-specific error 7", false),
        ([0x11, 255, 0, 0, 0, 0, 0, 0], "configure node-ID: manufacturer-specific error 0", false),
        ([0x11, 0, 1, 0, 0, 0, 0, 0], "configure node-ID: successful 1", true),
        ([0x11, 254, 1, 0, 0, 0, 0, 0], "configure node-ID: reserved error 254 1", true),
        ([0x44, 0, 0, 0, 0, 0, 0, 0], "switched to configuration", false),
        ([0x4F, 0, 0, 0, 0, 0, 0, 0], "slave identified", false),
        ([0x50, 0, 0, 0, 0, 0, 0, 0], "non-configured slave identified", false),
        ([0x5D, 1, 0, 0, 0, 0, 0, 0], "serial number 00000001h", false),
        ([0x5E, 255, 0, 0, 0, 0, 0, 0], "node-ID: none", false),
        ([0x5E, 5, 0, 0, 0, 0, 0, 0], "node-ID 5", false),
        ([0x99, 0, 0, 0, 0, 0, 0, 0], "unknown command specifier 99h", false),
    ] {
        assert_eq!(response(bytes), (text.to_owned(), too_much));
    }
}

/// The command specifiers that only one of the two protocols has (CiA 305 and CiA 205-2).
#[test]
fn command_specifiers_belong_to_one_protocol() {
    use Protocol::{Lmt, Lss};
    let of = |range: std::ops::RangeInclusive<u8>| range.map(|byte| Protocol::of(&[byte, 0])).collect::<Vec<_>>();
    for (range, protocol) in [
        (0x00..=0x00, None),
        (0x01..=0x03, Some(Lmt)),
        (0x04..=0x04, None),
        (0x05..=0x09, Some(Lmt)),
        (0x0A..=0x23, None),
        (0x24..=0x26, Some(Lmt)),
        (0x27..=0x3F, None),
        (0x40..=0x44, Some(Lss)),
        (0x45..=0x45, None),
        (0x46..=0x4C, Some(Lss)),
        (0x4D..=0x4E, None),
        (0x4F..=0x51, Some(Lss)),
        (0x52..=0x59, None),
        (0x5A..=0x5E, Some(Lss)),
        (0x5F..=0xFF, None),
    ] {
        assert!(of(range.clone()).iter().all(|found| *found == protocol), "{range:02X?}");
    }
    assert_eq!(Protocol::of(&[]), None);
}

/// CiA 301, 7.2.7.1 and 7.5.2.2: the class of an error and its bit in the error register.
#[test]
fn classes_of_errors_have_their_bits() {
    for (code, bits) in [
        (0x1000, 0x00),
        (0x2000, 0x02),
        (0x2310, 0x02),
        (0x3000, 0x04),
        (0x3210, 0x04),
        (0x4000, 0x08),
        (0x4210, 0x08),
        (0x5000, 0x00),
        (0x6000, 0x00),
        (0x7000, 0x00),
        (0x8000, 0x00),
        (0x8100, 0x10),
        (0x8130, 0x10),
        (0x8210, 0x10),
        (0x82FF, 0x10),
        (0x8300, 0x00),
        (0x9000, 0x00),
        (0xFF00, 0x00),
    ] {
        assert_eq!(EmcyCode(code).register_bits(), bits, "{code:04X}h");
    }
    assert_eq!((EmcyCode(0x00FF).is_reset(), EmcyCode(0x0100).is_reset()), (true, false));
    assert_eq!(ErrorRegister(0x81).names().collect::<Vec<_>>(), ["generic", "manufacturer"]);
    assert_eq!(ErrorRegister(0x7E).names().count(), 6);
}

/// The table of transmission types in CiA 301.
#[test]
fn transmission_types() {
    for (raw, cycle, reserved, text) in [
        (0, None, false, "0 (at the SYNC after an event)"),
        (1, Some(1), false, "1 (at every SYNC)"),
        (4, Some(4), false, "4 (at every 4th SYNC)"),
        (240, Some(240), false, "240 (at every 240th SYNC)"),
        (241, None, true, "241 (reserved)"),
        (251, None, true, "251 (reserved)"),
        (252, None, false, "252 (sampled at SYNC, sent on RTR)"),
        (253, None, false, "253 (sent on RTR)"),
        (254, None, false, "254 (manufacturer-specific event)"),
        (255, None, false, "255 (event of the device profile)"),
    ] {
        let kind = TransmissionType(raw);
        assert_eq!((kind.cycle(), kind.is_reserved_for_tpdo(), kind.to_string().as_str()), (cycle, reserved, text));
    }
}

/// Bit 0 is the lowest bit of the first byte. 64 bits that begin within a byte extend into a ninth byte.
#[test]
fn bits_of_a_payload() {
    let bytes = [0x01, 0x23, 0x45, 0x67, 0x89, 0xAB, 0xCD, 0xEF, 0x5A, 0xA5];
    for (offset, bits, value) in [
        (0, 8, Some(0x01)),
        (4, 8, Some(0x30)),
        (0, 64, Some(0xEFCD_AB89_6745_2301)),
        (8, 64, Some(0x5AEF_CDAB_8967_4523)),
        (4, 64, Some(0xAEFC_DAB8_9674_5230)),
        (12, 64, Some(0x55AE_FCDA_B896_7452)),
        (16, 64, Some(0xA55A_EFCD_AB89_6745)),
        (17, 64, None),
        (79, 1, Some(1)),
        (80, 1, None),
        (80, 0, Some(0)),
        (0, 65, None),
    ] {
        assert_eq!(extract(&bytes, offset, bits), value, "{bits} bits from {offset}");
    }
    let mut payload = [0xFF; 4];
    assert!(insert(&mut payload, 4, 8, 0x0A5) && insert(&mut payload, 16, 8, 0x3C));
    assert_eq!(payload, [0x5F, 0xFA, 0x3C, 0xFF]);
    assert!(insert(&mut payload, 8, 4, 0) && insert(&mut payload, 28, 4, 0x17));
    assert_eq!(payload, [0x5F, 0xF0, 0x3C, 0x7F]);
    assert!(!insert(&mut payload, 0, 65, 0) && !insert(&mut payload, 25, 8, 0) && !insert(&mut payload, 32, 8, 0));
    assert_eq!(payload, [0x5F, 0xF0, 0x3C, 0x7F]);
    let mut long = [0; 8];
    assert!(insert(&mut long, 0, 64, 0x0102_0304_0506_0708));
    assert_eq!(long, [8, 7, 6, 5, 4, 3, 2, 1]);
    assert!(insert(&mut long, 56, 8, 0xAA) && insert(&mut long, 40, 16, 0xBBCC));
    assert_eq!(long, [8, 7, 6, 5, 4, 0xCC, 0xBB, 0xAA]);
}

#[test]
fn transfers_in_words() {
    assert_eq!([Direction::Upload, Direction::Download].map(|it| it.to_string()), ["upload", "download"]);
    let modes = [Mode::Expedited, Mode::Segmented, Mode::Block].map(|it| it.to_string());
    assert_eq!(modes, ["expedited", "segmented", "block"]);
    assert_eq!([Side::Client, Side::Server].map(|it| it.to_string()), ["client", "server"]);
    let object = canvass_analyzer::Multiplexer::new(0x1000, 0);
    for (violation, name, text) in [
        (Violation::Toggle, "toggle", "toggle bit not alternated"),
        (Violation::Multiplexer(object), "multiplexer", "answer names 1000h:00"),
        (Violation::Size { announced: 2, received: 1 }, "size", "1 bytes transferred, but 2 announced"),
        (Violation::Crc { sent: 1, calculated: 2 }, "crc", "CRC 0001h does not match the data, expected 0002h"),
        (Violation::Sequence { expected: 1, found: 2 }, "sequence", "segment 2, expected 1"),
        (Violation::Unexpected, "unexpected", "unexpected in this state"),
    ] {
        assert_eq!((violation.name(), violation.to_string().as_str()), (name, text));
    }
}

#[test]
fn other_services_in_words() {
    for (priority, level) in [(0, "high"), (1, "medium"), (2, "low"), (3, "reserved")] {
        let message = FlyingMaster::ActiveMaster { priority, node: 9 };
        assert_eq!(message.to_string(), format!("active master is node 9, priority {priority} ({level})"));
        assert_eq!(message.to_frame().data(), [priority, 9]);
        assert_eq!(FlyingMaster::read(0x071, &[priority, 9]), Ok(message));
    }
    let unknown = FlyingMaster::read(0x077, &[1, 2]);
    assert_eq!(unknown, Err(Malformed { offset: 0, expected: "a CAN-ID of flying master, 071h to 076h" }));
    assert!(Emcy::read(&[]).unwrap().is_empty() && !Emcy::read(&[0]).unwrap().is_empty());
    let names = [1, 3, 4, 5, 2].map(|raw| Verdict(raw).name());
    assert_eq!(names, [Some("pass"), Some("warning"), Some("fail"), Some("skipped"), None]);
}

/// A segment has up to seven bytes (`000tnnnc`).
#[test]
fn segments_hold_seven_bytes() {
    assert!(Segment::new(false, &[0; 8], false).is_none());
    for length in 0..=7 {
        let data = &[1, 2, 3, 4, 5, 6, 7][..length];
        let frame = Request::DownloadSegment(Segment::new(true, data, true).unwrap()).to_frame(0x605);
        assert_eq!((frame.len(), frame.data()[0]), (8, 0x11 | (7 - length as u8) << 1));
        assert_eq!(&frame.data()[1..=length], data);
        assert!(frame.data()[1 + length..].iter().all(|byte| *byte == 0));
        assert_eq!(frame.id(), CanId::standard(0x605).unwrap());
        // The counted bytes must be present, and no more are read.
        let Ok(Request::DownloadSegment(segment)) = Request::read(&frame.data()[..=length]) else { panic!("{length}") };
        assert_eq!((segment.data(), segment.toggle, segment.last), (data, true, true));
        if length > 0 {
            let short = Request::read(&frame.data()[..length]);
            let expected = "the data that the command byte announces";
            assert_eq!(short, Err(Malformed { offset: 1, expected }), "{length}");
        }
    }
}

/// The messages that name their object (CiA 301, 7.2.4.3).
#[test]
fn messages_name_their_object() {
    let object = |frame: [u8; 8]| {
        let told = (Request::read(&frame).unwrap().multiplexer(), Response::read(&frame).unwrap().multiplexer());
        (told.0.map(|at| at.to_string()), told.1.map(|at| at.to_string()))
    };
    let named = || Some("1F50h:01".to_owned());
    for (command, request, response) in [
        (0x00, None, None),
        (0x23, named(), None),
        (0x40, named(), named()),
        (0x60, None, named()),
        (0x80, named(), named()),
        (0xA0, named(), named()),
        (0xA1, None, None),
        (0xA2, None, None),
        (0xC0, named(), named()),
        (0xC1, None, None),
        (0xE0, None, None),
    ] {
        assert_eq!(object([command, 0x50, 0x1F, 1, 9, 0, 0, 0]), (request, response), "{command:02X}");
    }
    let lengths = [0, 1, 4, 5].map(|length| Expedited::new(&vec![7; length]).is_some());
    assert_eq!(lengths, [false, true, true, false]);
}
