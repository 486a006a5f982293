//! The measurement of an encoder: position, scaling, preset, speed, work area.

use crate::rig::{Rig, model};
use canvass_device::Motion;
use canvass_device::models::Model;
use proptest::prelude::*;

fn moving(milli_rpm: i64) -> Rig {
    let mut rig = Rig::powered(model(), Some(63), Default::default(), &Motion::constant(0, milli_rpm));
    rig.run(300);
    rig
}

fn reference() -> Rig {
    let model = Model::by_id("reference-406").unwrap();
    let mut rig = Rig::powered(model, Some(63), Default::default(), &Motion::still(0x4CBA));
    rig.run(300);
    rig
}

/// 6300h with two overlapping cams, hysteresis and polarity.
#[test]
fn cams() {
    let mut rig = reference();
    for (index, value) in [(0x6310, 100), (0x6320, 200), (0x6311, 150), (0x6321, 300)] {
        assert_eq!(rig.write(index, 1, value, 4), "ok");
    }
    assert_eq!((rig.write(0x6330, 1, 10, 2), rig.write(0x6301, 1, 0b11, 1)), ("ok".to_owned(), "ok".to_owned()));
    let mut at = |position| {
        rig.write(0x6003, 0, position, 4);
        rig.read(0x6300, 1)
    };
    let states = [99, 100, 149, 150, 200, 210, 211, 201, 300, 301].map(|position| at(position).unwrap());
    assert_eq!(states, [0, 1, 1, 3, 3, 3, 2, 2, 2, 0]);
    assert_eq!(rig.write(0x6302, 1, 0b101, 1), "ok");
    assert_eq!(rig.read(0x6300, 1), Ok(1), "inverted where enabled");
    assert_eq!(rig.write(0x6301, 1, 0, 1), "ok");
    assert_eq!(rig.read(0x6300, 1), Ok(0));
}

/// 2120h holds the temperature limits of Kübler's encoders. In devices of other manufacturers its meaning is unknown.
#[test]
fn limits_of_the_temperature_are_kueblers() {
    let eds = include_str!("../../models/kuebler-sendix-58x8.eds");
    let another = eds.replace("0x00000013", "0x0000002A");
    for (text, errors) in [(eds, 1), (another.as_str(), 0)] {
        let model = Model::generic("my.eds", text.as_bytes()).unwrap();
        let mut rig = Rig::powered(&model, Some(63), Default::default(), &Motion::still(0));
        rig.run(300);
        let heard = rig.ask("63F#2F20210350000000");
        assert!(heard.contains(&"5BF#6020210300000000".to_owned()), "{heard:?}");
        let reported = heard.iter().filter(|frame| frame.starts_with("0BF#0042")).count();
        assert_eq!(reported, errors, "{heard:?}");
    }
}

/// A preset in 6009h changes 6008h and 6004h.
#[test]
fn high_precision() {
    let mut rig = reference();
    rig.dialogue(&[
        ("2109600008000000", "6009600000000000"),
        ("00E8030000000000", "2000000000000000"),
        ("1D00000000000000", "3000000000000000"),
        ("4008600000000000", "4108600008000000"),
        ("6000000000000000", "00E8030000000000"),
        ("7000000000000000", "1D00000000000000"),
    ]);
    assert_eq!(rig.read(0x6004, 0), Ok(1000));
    assert_eq!(rig.read(0x600C, 0), Ok(0x4CBA));
    rig.dialogue(&[
        ("2109600008000000", "6009600000000000"),
        ("0000000002000000", "2000000000000000"),
        ("1D00000000000000", "8009600030000906"),
    ]);
}

#[test]
fn preset_and_offset() {
    let mut rig = Rig::new();
    assert_eq!(rig.read(0x6004, 0), Ok(0x4CBA));
    assert_eq!(rig.write(0x6003, 0, 100, 4), "ok");
    assert_eq!(rig.read(0x6004, 0), Ok(100));
    assert_eq!(rig.read(0x6509, 0), Ok(100_u32.wrapping_sub(0x4CBA)));
    rig.send("000#813F");
    rig.run(300);
    assert_eq!(rig.read(0x6004, 0), Ok(0x4CBA), "not stored");
    rig.write(0x6003, 0, 100, 4);
    assert_eq!(rig.write(0x1010, 1, 0x6576_6173, 4), "ok");
    rig.send("000#813F");
    rig.run(300);
    assert_eq!(rig.read(0x6004, 0), Ok(100));
}

#[test]
fn the_code_sequence_mirrors() {
    let mut rig = Rig::new();
    rig.write(0x6000, 0, 5, 2);
    assert_eq!(rig.read(0x6004, 0), Ok(0x0200_0000 - 0x4CBA));
    assert_eq!(rig.read(0x6500, 0), Ok(5));
}

#[test]
fn scaling() {
    let mut rig = Rig::new();
    assert_eq!(rig.write(0x6001, 0, 4096, 4), "ok");
    assert_eq!(rig.read(0x6004, 0), Ok(0x4CBA / 2));
    assert_eq!(rig.write(0x6002, 0, 4095, 4), "06090030", "less than one revolution");
    assert_eq!(rig.write(0x6002, 0, 8192, 4), "ok");
    assert_eq!(rig.read(0x6004, 0), Ok(0x4CBA / 2 % 8192));
    assert_eq!(rig.write(0x6001, 0, 8192, 4), "ok");
    assert_eq!(rig.write(0x6003, 0, 8192, 4), "06090030", "outside the active range");
    assert_eq!(rig.write(0x6000, 0, 0, 2), "ok");
    assert_eq!(rig.read(0x6004, 0), Ok(0x4CBA), "the physical position");
}

#[test]
fn speed_and_its_sign() {
    let mut rig = moving(100_000);
    assert_eq!(rig.read(0x6030, 1), Ok(100));
    rig.write(0x6000, 0, 5, 2);
    assert_eq!(rig.read(0x6030, 1), Ok(0xFF9C));
    rig.write(0x6000, 0, 0x2004, 2);
    rig.write(0x6001, 0, 36, 4);
    assert_eq!(rig.read(0x6030, 1), Ok(60), "units per second: 100 / 60 * 36");
}

#[test]
fn overspeed_is_a_warning() {
    let mut rig = moving(12_001_000);
    assert_eq!(rig.read(0x6505, 0), Ok(1));
    assert_eq!(rig.read(0x1001, 0), Ok(9));
}

#[test]
fn work_area() {
    let mut rig = Rig::new();
    assert_eq!(rig.read(0x6400, 1), Ok(0));
    rig.write(0x6402, 1, 0x1000, 4);
    assert_eq!(rig.read(0x6400, 1), Ok(0b011));
    rig.write(0x6401, 2, 0x8000, 4);
    assert_eq!(rig.read(0x6400, 2), Ok(0b101));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// Whatever values the device accepts, the position stays in its range, and 6004h = scaled position + 6509h.
    #[test]
    fn the_position_is_in_its_range(
        operating in prop::sample::select(vec![0_u32, 1, 4, 5, 0x1004]), units: u16, range: u32, preset: u32, rest: i32,
    ) {
        let mut rig = Rig::powered(model(), Some(63), Default::default(), &Motion::still(rest.into()));
        rig.run(300);
        rig.write(0x6000, 0, operating, 2);
        rig.write(0x6001, 0, u32::from(units), 4);
        rig.write(0x6002, 0, range >> 7, 4);
        let range = if operating & 4 == 0 { 0x0200_0000 } else { rig.read(0x6002, 0).unwrap() };
        let before = rig.read(0x6004, 0).unwrap();
        prop_assert!(before < range);
        if rig.write(0x6003, 0, preset >> 7, 4) == "ok" {
            prop_assert_eq!(rig.read(0x6004, 0), Ok(preset >> 7));
            let offset = rig.read(0x6509, 0).unwrap() as i32;
            prop_assert_eq!((i64::from(before) + i64::from(offset)).rem_euclid(range.into()), i64::from(preset >> 7));
        }
    }
}
