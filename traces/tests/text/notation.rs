use crate::frames::any_frame;
use canvass_traces::*;
use proptest::prelude::*;

fn id(raw: u32) -> CanId {
    CanId::standard(raw).unwrap()
}

fn frame(text: &str) -> Frame {
    parse_frame(text).unwrap_or_else(|error| panic!("{text}: {error}")).frame
}

#[test]
fn every_kind_of_frame() {
    let data = [0x40, 0, 0x60, 0, 0, 0, 0, 0];
    assert_eq!(frame("63F#4000600000000000"), Frame::full(id(0x63F), data));
    assert_eq!(frame("63f#40.00.60.00.00.00.00.00"), Frame::full(id(0x63F), data));
    assert_eq!(frame("123#"), Frame::new(id(0x123), &[]).unwrap());
    assert_eq!(frame("0000063F#01"), Frame::new(CanId::extended(0x63F).unwrap(), &[1]).unwrap());
    assert_eq!(frame("1FFFFFFF#01"), Frame::new(CanId::extended(0x1FFF_FFFF).unwrap(), &[1]).unwrap());
    assert_eq!(frame("20000004#0008"), Frame::error(ErrorClass(4), &[0, 8]).unwrap());
    assert_eq!(frame("701#R"), Frame::remote(id(0x701), 0).unwrap());
    assert_eq!(frame("701#r0"), Frame::remote(id(0x701), 0).unwrap());
    assert_eq!(frame("701#R8"), Frame::remote(id(0x701), 8).unwrap());
    assert_eq!(frame("701#R8_C"), Frame::remote(id(0x701), 8).unwrap().with_raw_dlc(12));
    assert_eq!(frame("123#1122334455667788_e").dlc(), 14);
    assert_eq!(frame("123#1122334455667788").dlc(), 8);
}

#[test]
fn can_fd_by_old_and_new_tools() {
    for (text, flags) in [("0", 0), ("1", 1), ("3", 3), ("4", 0), ("5", 1), ("6", 2), ("7", 3)] {
        let read = frame(&format!("123##{text}AABB"));
        assert_eq!(read, Frame::fd(id(0x123), Flags::from_bits(flags), &[0xAA, 0xBB]).unwrap());
    }
    assert_eq!(frame("123##1.AA.BB"), frame("123##5AABB"));
    assert_eq!(parse_frame(&format!("123##4{}", "5A".repeat(64))).unwrap().data(), [0x5A; 64]);
}

#[test]
fn can_xl_has_five_digits() {
    let record = parse_frame("45123#81:02:12345678#11223344").unwrap();
    let xl = XlHeader { vcid: 0x45, sec: true, rrs: false, sdt: 2, af: 0x1234_5678 };
    assert_eq!(record.xl_header(), Some(xl));
    assert_eq!((record.frame.id(), record.data()), (id(0x123), &[0x11, 0x22, 0x33, 0x44][..]));
    assert_eq!(parse_frame(&format!("00001#80:00:00000000#{}", "5A".repeat(2048))).unwrap().data().len(), 2048);
}

#[test]
fn mistakes_are_located() {
    for (text, position, expected) in [
        ("", 0, "hex digit of the id"),
        ("12", 2, "hex digit of the id or '#'"),
        ("12#11", 0, "3 digits"),
        ("0123#11", 0, "3 digits"),
        ("123456789#11", 8, "'#' after the id"),
        ("12G#11", 2, "hex digit of the id"),
        ("800#11", 0, "at most 7FF"),
        ("40000001#11", 0, "at most 1FFFFFFF"),
        ("123#1", 5, "second hex digit"),
        ("123#112", 7, "second hex digit"),
        ("123#11.", 7, "byte of two hex digits"),
        ("123#11g", 6, "the end of the text"),
        ("123#112233445566778899", 20, "at most 8 data bytes"),
        ("123#1122334455667788_8", 21, "9 to F"),
        ("123#11_9", 6, "the end of the text"),
        ("123#R9", 5, "0 to 8"),
        ("123#R5_9", 6, "the end of the text"),
        ("123##", 5, "CAN FD flags"),
        ("123##R", 5, "CAN FD flags"),
        ("123##5112233445566778899", 24, "length that CAN FD has"),
        ("20000004#R", 9, "the end of the text"),
        ("45123#01:02:12345678#11", 6, "bit 80"),
        ("45F23#81:02:12345678#11", 6, "priority"),
        ("45123#81:02:12345678#", 21, "at least one byte"),
        ("123#11 ", 6, "the end of the text"),
    ] {
        let error = parse_frame(text).expect_err(text);
        assert_eq!(error.position, position, "{text}: {error}");
        assert!(error.expected.contains(expected), "{text}: {error}");
    }
    let shown = parse_frame("123#11gg").unwrap_err().to_string();
    assert_eq!(shown, "at position 7: expected the end of the text after the frame, found \"gg\"");
}

proptest! {
    #[test]
    fn what_is_written_is_read_back(record in any_frame()) {
        let text = record.notation().to_string();
        prop_assert_eq!(parse_frame(&text), Ok(record.clone()), "{}", text);
        if !record.frame.is_head() && !record.frame.is_xl() {
            prop_assert_eq!(record.frame.to_string(), text);
        }
    }

    #[test]
    fn no_text_is_too_strange(text in "\\PC*", hex in "[0-9A-Fa-f]{0,9}#?[#R]?[0-9A-F._:]{0,40}") {
        for text in [text, hex] {
            if let Err(error) = parse_frame(&text) {
                prop_assert!(error.position <= text.len());
            }
        }
    }
}
