//! Behaviour of the Ax58x that differs from the standards (manual 001).

use crate::bench::Bench;
use canvass_device::Motion;

const NONE: [&str; 0] = [];

fn ax58() -> Bench {
    Bench::new("lika-ax58")
}

/// 5.8.1: 100Ch and 100Dh are fixed. The device monitors its master from the first remote frame on, until reset node.
#[test]
fn life_guarding_is_always_on() {
    let mut bench = ax58();
    for (index, len) in [(0x100C, 2), (0x100D, 1)] {
        assert_eq!(bench.write(index, 0, 0, len), Err(0x0601_0002));
    }
    assert_eq!(bench.run(20_000), NONE, "nobody has guarded yet");
    assert_eq!(bench.ask("701#R"), ["701#7F"]);
    assert_eq!(bench.run(4_900), NONE);
    assert_eq!(bench.run(100), ["081#0010110000000000"]);
    assert_eq!((bench.read(0x1001, 0), bench.read(0x1003, 0), bench.read(0x1003, 1)), (Ok(0x11), Ok(1), Ok(0x1000)));
    assert_eq!(bench.ask("701#R"), ["701#FF"], "the master is back, and the error stays");
    assert_eq!((bench.read(0x1001, 0), bench.read(0x1003, 0)), (Ok(0x11), Ok(1)), "reading changes nothing");
    assert_eq!(bench.write(0x1003, 0, 1, 1), Err(0x0609_0030));
    bench.write(0x1003, 0, 0, 1).unwrap();
    assert_eq!((bench.read(0x1001, 0), bench.read(0x1003, 0)), (Ok(0x11), Ok(0)), "only the history");
    assert_eq!(bench.reset("81"), ["701#00"]);
    assert_eq!(bench.read(0x1001, 0), Ok(0));
    assert_eq!(bench.ask("701#R"), ["701#7F"]);
    assert_eq!(bench.run(5_000), ["081#0010110000000000"]);
    assert_eq!(bench.reset("81"), ["701#00"]);
    assert_eq!((bench.read(0x1001, 0), bench.read(0x1003, 0)), (Ok(0), Ok(0)), "reset node deletes the error");
}

/// The device has neither LSS nor heartbeat.
#[test]
fn what_it_does_not_have() {
    let mut bench = ax58();
    for index in [0x1006, 0x1016, 0x1017, 0x1029, 0x6503, 0x6505] {
        assert_eq!(bench.read(index, 0), Err(0x0602_0000), "{index:04X}h");
    }
    for frame in ["7E5#0401000000000000", "7E5#5E00000000000000", "7E5#2400000000000000"] {
        assert_eq!(bench.ask(frame), NONE);
    }
}

/// 5.8.2: node-ID and bit rate are written, take effect at reset node, and are then stored. Without the store the old
/// values are back after power-off.
#[test]
fn node_id_and_bit_rate() {
    let mut bench = ax58();
    bench.write(0x3001, 0, 5, 1).unwrap();
    bench.write(0x3000, 0, 3, 1).unwrap();
    assert_eq!(bench.read(0x3001, 0), Ok(5));
    assert_eq!(bench.device.bit_rate_kbit(), 500, "not before a reset");
    assert_eq!(bench.reset("82"), ["701#00"], "the node-ID not by reset communication");
    assert_eq!(bench.device.bit_rate_kbit(), 125);
    assert_eq!(bench.reset("81"), ["705#00"], "with the new node-ID");
    assert_eq!((bench.read_from(5, 0x3001, 0), bench.read_from(5, 0x3000, 0)), (Ok(5), Ok(3)));
    assert_eq!(bench.read_from(5, 0x1800, 1), Ok(0x4000_0185), "COB-IDs follow");
    assert_eq!(bench.power_cycle(), ["701#00"], "not stored");
    assert_eq!(bench.device.bit_rate_kbit(), 500);
    assert_eq!(bench.read(0x3000, 0), Ok(5));
    bench.write(0x3001, 0, 5, 1).unwrap();
    bench.reset("81");
    assert_eq!(bench.ask("605#2310100173617665"), ["585#6010100100000000"]);
    bench.run(100);
    assert_eq!(bench.power_cycle(), ["705#00"], "stored");
    for (index, wrong) in [(0x3000, 8), (0x3001, 0), (0x3001, 128)] {
        let request = format!("605#2F{:02X}3000{wrong:02X}000000", index & 0xFF);
        assert!(bench.ask(&request)[0].starts_with("585#80"), "{index:04X}h = {wrong}");
    }
}

/// 5.8.3, 6: reset node, reset communication and power-off lose values that are not stored, in every area.
#[test]
fn what_is_not_stored_is_lost() {
    let ways: [fn(&mut Bench); 3] =
        [|bench| drop(bench.reset("81")), |bench| drop(bench.reset("82")), |bench| drop(bench.power_cycle())];
    for way in ways {
        let mut bench = ax58();
        let values = |bench: &mut Bench| [0x1015, 0x2104, 0x6001].map(|index| bench.read(index, 0).unwrap());
        let change = |bench: &mut Bench| {
            bench.write(0x1015, 0, 100, 2).unwrap();
            bench.write(0x2104, 0, 200, 4).unwrap();
            bench.write(0x6001, 0, 300, 4).unwrap();
        };
        change(&mut bench);
        way(&mut bench);
        assert_eq!(values(&mut bench), [0, 0x10, 0x1_0000]);
        change(&mut bench);
        bench.save();
        way(&mut bench);
        assert_eq!(values(&mut bench), [100, 200, 300]);
    }
}

/// 5.8.1: restored defaults take effect after a reset, and must be stored.
#[test]
fn restored_defaults_need_a_store() {
    let mut bench = ax58();
    bench.write(0x6001, 0, 300, 4).unwrap();
    bench.save();
    bench.write(0x1011, 1, 0x6461_6F6C, 4).unwrap();
    bench.run(100);
    assert_eq!(bench.read(0x6001, 0), Ok(300), "not before the reset");
    bench.reset("81");
    assert_eq!(bench.read(0x6001, 0), Ok(0x1_0000));
    bench.power_cycle();
    assert_eq!(bench.read(0x6001, 0), Ok(300), "they were not stored");
    bench.write(0x1011, 1, 0x6461_6F6C, 4).unwrap();
    bench.run(100);
    bench.reset("81");
    bench.save();
    bench.power_cycle();
    assert_eq!(bench.read(0x6001, 0), Ok(0x1_0000), "now they were");
}

/// 5.6: TPDO 1 is sent every 6200h ms, TPDO 2 at every n-th SYNC, TPDO 3 is off.
#[test]
fn tpdos() {
    let mut bench = ax58();
    bench.device.set_motion(bench.now, Motion::still(0x4CBA));
    assert_eq!(bench.ask("000#0101"), ["181#BA4C0000"]);
    assert_eq!(bench.run(960).len(), 10, "every 100 ms");
    bench.device.set_motion(bench.now, Motion::constant(0, 60_000));
    let moving = bench.run(1_000);
    assert!((9..=11).contains(&moving.len()), "not on every change of a moving shaft: {}", moving.len());
    bench.write(0x6200, 0, 0xFFFF, 2).unwrap();
    bench.device.set_motion(bench.now, Motion::still(0x4CBA));
    assert_eq!(bench.ask("080#"), ["281#BA4C0000"]);
    assert_eq!(bench.ask("281#R"), NONE, "bit 30 of its COB-ID is set");
    bench.write(0x1801, 2, 3, 1).unwrap();
    let syncs: Vec<usize> = (0..6).map(|_| bench.ask("080#").len()).collect();
    assert_eq!(syncs, [0, 0, 1, 0, 0, 1]);
    // TPDO 1 off, TPDO 3 on.
    bench.write(0x1800, 1, 0xC000_0181, 4).unwrap();
    bench.write(0x6200, 0, 10, 2).unwrap();
    assert_eq!(bench.run(100), NONE);
    bench.write(0x1802, 1, 0x4000_0381, 4).unwrap();
    assert_eq!(bench.ask("080#"), ["381#BA4C0000"]);
    assert_eq!(bench.write(0x6200, 0, 0, 2), Err(0x0609_0032), "1 ms is the least");
}

/// 5.8.2, 5.8.3: bits 12 and 13 are set beyond the limits, and only if the limit switches are enabled.
#[test]
fn limit_switches() {
    let mut bench = ax58();
    let position = 0x4CBA;
    assert_eq!(bench.read(0x6500, 0), Ok(0));
    for (enabled, low, high, expected) in [
        (0x0000, position + 1, position - 1, 0x0000),
        (0x3000, position, position, 0x0000),
        (0x3000, position + 1, position, 0x1000),
        (0x3000, position, position - 1, 0x2000),
        (0x3000, position + 1, position - 1, 0x3000),
        (0x1000, position + 1, position - 1, 0x1000),
        (0x2000, position + 1, position - 1, 0x2000),
        (0x3001, position + 1, u32::MAX, 0x0001),
    ] {
        bench.write(0x6000, 0, enabled, 2).unwrap();
        bench.write(0x2104, 0, low, 4).unwrap();
        bench.write(0x2105, 0, high, 4).unwrap();
        assert_eq!(bench.read(0x6500, 0), Ok(expected), "{enabled:04X}h, {low:X}h, {high:X}h");
    }
    for reserved in [1, 3, 11, 14, 15] {
        assert_eq!(bench.write(0x6000, 0, 1 << reserved, 2), Err(0x0609_0030), "bit {reserved}");
    }
    // Bits 12 and 13 have no effect other than limit switches.
    bench.write(0x6000, 0, 0x3000, 2).unwrap();
    bench.device.set_motion(bench.now, Motion::still(0x1000_0000 + 5));
    assert_eq!(bench.read(0x6004, 0), Ok(5), "the position stays in its range");
}

/// 5.8.3: posTx = 6001h / 6501h * real position, below 6002h.
#[test]
fn scaling() {
    let mut bench = ax58();
    bench.write(0x6001, 0, 4096, 4).unwrap();
    assert_eq!(bench.read(0x6004, 0), Ok(0x4CBA), "scaling is off");
    bench.write(0x6000, 0, 4, 2).unwrap();
    for (real, units, total) in [(0x4CBA, 4096, 0x100_0000), (65_536 * 100 + 777, 1_000, 50_000), (65_535, 1, 7)] {
        bench.write(0x6002, 0, 0x1000_0000, 4).unwrap();
        bench.write(0x6001, 0, units, 4).unwrap();
        bench.write(0x6002, 0, total, 4).unwrap();
        bench.device.set_motion(bench.now, Motion::still(real));
        let expected = (i128::from(units) * i128::from(real) / 65_536) % i128::from(total);
        assert_eq!(bench.read(0x6004, 0).map(i128::from), Ok(expected), "{real}, {units}, {total}");
    }
    assert_eq!((bench.read(0x6501, 0), bench.read(0x6502, 0)), (Ok(65_536), Ok(4_096)), "whatever the scaling");
}

/// 5.7.1: downloads that do not indicate their length.
#[test]
fn downloads_without_length() {
    let mut bench = ax58();
    assert_eq!(bench.ask("601#22016000E8030000"), ["581#6001600000000000"]);
    assert_eq!(bench.read(0x6001, 0), Ok(1_000));
    assert_eq!(bench.ask("601#2200620064000000"), ["581#6000620000000000"]);
    assert_eq!(bench.read(0x6200, 0), Ok(100));
    assert_eq!(bench.ask("601#2200300004000000"), ["581#6000300000000000"]);
    assert_eq!(bench.read(0x3000, 0), Ok(4));
}

/// 5.8.3: 6003h accepts no preset beyond the range.
#[test]
fn preset() {
    let mut bench = ax58();
    assert_eq!(bench.write(0x6003, 0, 0x1000_0000, 4), Err(0x0609_0030));
    bench.write(0x6003, 0, 0x0FFF_FFFF, 4).unwrap();
    assert_eq!(bench.read(0x6004, 0), Ok(0x0FFF_FFFF));
    assert_eq!(bench.read(0x6509, 0), Ok(0x0FFF_FFFF - 0x4CBA));
}
