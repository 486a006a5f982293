//! Behaviour of Kübler's encoders that differs from other devices.

use crate::rig::Rig;
use canvass_device::Faults;
use canvass_device::Motion;
use canvass_device::models::Model;

fn powered(model: &str, milli_rpm: i64) -> Rig {
    let model = Model::by_id(model).unwrap();
    let node = model.default_node().map_or(63, |node| node.raw());
    let mut rig = Rig::powered(model, Some(node), Faults::NONE, &Motion::constant(0x4CBA, milli_rpm));
    rig.run(300);
    rig
}

/// 6001h and 6002h refuse a measuring range of less than one revolution and keep their old values; 6002h = 0 is 2^32.
#[test]
fn units_and_range() {
    for model in ["kuebler-sendix-58x8", "kuebler-sendix-f58", "kuebler-sendix-f58m", "kuebler-sendix-m58"] {
        let mut rig = powered(model, 0);
        rig.write(0x6000, 0, 4, 2);
        assert_eq!(rig.write(0x6001, 0, 0x1000, 4), "ok");
        assert_eq!(rig.write(0x6002, 0, 0xFFF, 4), "06090030", "{model}");
        assert_eq!(rig.write(0x6002, 0, 0x1000, 4), "ok");
        assert_eq!(rig.write(0x6001, 0, 0x1001, 4), "06090030", "{model}");
        assert_eq!((rig.read(0x6001, 0), rig.read(0x6002, 0)), (Ok(0x1000), Ok(0x1000)));
    }
    let mut rig = powered("kuebler-sendix-f58", 0);
    assert_eq!(rig.write(0x6002, 0, 0, 4), "ok");
    assert_eq!(rig.write(0x6003, 0, 0xFFFF_FFFF, 4), "ok");
    assert_eq!(rig.read(0x6004, 0), Ok(0xFFFF_FFFF));
}

#[test]
fn bits_of_the_operating_parameters() {
    // Since V4.1 all bits are reserved except 0, 2, 12 and 14.
    assert_eq!(powered("kuebler-sendix-f58m", 0).write(0x6000, 0, 0x2004, 2), "06090030");
    assert_eq!(powered("kuebler-sendix-m58", 0).write(0x6000, 0, 0x1004, 2), "ok");
    assert_eq!(powered("kuebler-sendix-f58", 0).write(0x6000, 0, 0x2004, 2), "ok");
    // Speed in units per second by bit 12, from 6004h: 1 revolution per second of 8192 units.
    let mut rig = powered("kuebler-sendix-f58m", 60_000);
    assert_eq!(rig.read(0x6030, 1), Ok(60));
    assert_eq!(rig.write(0x6031, 1, 1, 2), "ok");
    assert_eq!(rig.write(0x6000, 0, 0x1004, 2), "ok");
    assert_eq!(rig.read(0x6030, 1), Ok(8192));
    assert_eq!(rig.write(0x6031, 3, 3, 2), "ok");
    assert_eq!(rig.write(0x6031, 4, 2, 2), "ok");
    assert_eq!(rig.read(0x6030, 1), Ok(12_288), "gear 3 : 2");
    assert_eq!(rig.write(0x6031, 1, 2, 2), "ok");
    assert_eq!(rig.read(0x6030, 1), Ok(0x80000 * 3 / 2), "raw steps of 600Ch");
    assert_eq!(rig.read(0x6040, 1), Ok(0));
    assert_eq!(rig.write(0x6031, 2, 4, 2), "06090032", "5 ms at least");
}

/// Channel A and channel B add up to the full scale at every position of the wire, including its end.
#[test]
fn redundant_channels() {
    for (model, full_scale, width) in [("kuebler-c100", 47_000, 2), ("kuebler-d125", 100_000, 4)] {
        let mut rig = powered(model, 60_000);
        rig.send("000#0104");
        let records = rig.records(60_000);
        let tpdos: Vec<_> = records.iter().filter(|record| record.frame.cob_id() == Some(0x184)).collect();
        assert!(tpdos.len() >= 599, "every 100 ms, {}", tpdos.len());
        let number = |bytes: &[u8]| bytes.iter().rev().fold(0_u64, |number, &byte| number << 8 | u64::from(byte));
        let mut last = 0;
        for tpdo in tpdos {
            let (a, b) = tpdo.frame.data().split_at(width);
            assert_eq!((number(a) + number(b), b.len()), (full_scale, width), "{model}");
            assert!(number(a) >= last);
            last = number(a);
        }
        assert_eq!(last, full_scale, "pulled out to its end");
    }
}

#[test]
fn angles() {
    let mut rig = powered("kuebler-c100", 0);
    let z = |rig: &mut Rig, setting: &str| {
        rig.ask(&format!("604#{setting}"));
        rig.ask("000#8004");
        rig.ask("000#0104").into_iter().find_map(|frame| frame.strip_prefix("284#").map(str::to_owned)).unwrap()
    };
    assert_eq!(z(&mut rig, "2F03300001000000"), "E803B888", "10 and 350 degrees");
    assert_eq!(z(&mut rig, "2F04300001000000"), "E80318FC", "10 and -10 degrees");
    assert_eq!(z(&mut rig, "2F05300000000000"), "E803E803", "the same way");
    assert_eq!(z(&mut rig, "2F03300000000000"), "18FC18FC", "counter-clockwise");
    assert_eq!(z(&mut rig, "2F10300001000000"), "00000000", "zero point set");
    assert_eq!(z(&mut rig, "2F10300000000000"), "18FC18FC", "and reset");
}

/// The checksum covers the bytes of the raw position, little-endian, and starts with 1021h.
#[test]
fn raw_position() {
    let mut rig = powered("kuebler-sendix-f58", 0);
    assert_eq!(rig.read(0x2160, 0), Ok(0x4CBA));
    assert_eq!(rig.read(0x2161, 0), Ok(!0x4CBA));
    let crc = [0xBA_u8, 0x4C, 0, 0].iter().fold(0x1021_u16, |crc, &byte| {
        (0..8).fold(crc ^ u16::from(byte) << 8, |crc, _| if crc & 0x8000 == 0 { crc << 1 } else { crc << 1 ^ 0x1021 })
    });
    assert_eq!(rig.read(0x2162, 0), Ok(u32::from(crc)));
}

/// Without a node-ID, M58 sends nothing and handles LSS only. Values stored by LSS outlive a reset.
#[test]
fn unconfigured() {
    let model = Model::by_id("kuebler-sendix-m58").unwrap();
    assert_eq!(model.default_node(), None);
    let mut rig = Rig::powered(model, None, Faults::NONE, &Motion::still(0));
    assert!(rig.run(10_000).is_empty());
    assert!(rig.ask("000#0100").is_empty());
    assert!(rig.ask("7E5#4C00000000000000").iter().any(|frame| frame.starts_with("7E4#50")), "identifies itself");
}
