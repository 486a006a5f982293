//! Behaviour of TR-Electronic's devices that differs from the standards (manual 004).

use crate::bench::Bench;
use canvass_device::{Motion, MotionSpec};

const NONE: [&str; 0] = [];
const SCALING: u32 = 4;

fn rotary() -> Bench {
    Bench::new("tr-c65")
}

/// Guards a device once with a life time of 200 ms, and sends no further guarding request until the device reports the
/// loss.
fn lose_master(bench: &mut Bench) -> Vec<String> {
    bench.write(0x100C, 0, 100, 2).unwrap();
    bench.write(0x100D, 0, 2, 1).unwrap();
    assert_eq!(bench.ask("701#R").len(), 1);
    bench.run(300)
}

/// 12.3.1: reading 1001h clears the newest error. After the last error 1001h is 0 and EMCY 0000h is sent.
#[test]
fn reading_the_error_register_clears_the_history() {
    for (model, register) in [("tr-c65", 0x01), ("tr-lmp30", 0x20)] {
        let mut bench = Bench::new(model);
        assert_eq!(lose_master(&mut bench), [format!("081#0081{register:02X}0000000000")]);
        // EMCY 0000h reports that the master is back; after its second loss the history has two errors.
        assert_eq!(bench.ask("701#R"), ["701#FF", "081#0000000000000000"]);
        assert_eq!(bench.run(300).len(), 1);
        assert_eq!(bench.read(0x1003, 0), Ok(2), "all are counted, one is shown");
        assert_eq!(bench.read(0x1003, 1), Ok(0x8100));
        assert_eq!(bench.read(0x1003, 2), Err(0x0609_0011));
        let first = bench.ask("601#4001100000000000");
        assert_eq!(first, [format!("581#4F011000{register:02X}000000")], "one error is left");
        assert_eq!(bench.read(0x1003, 0), Ok(1));
        let mut second = bench.ask("601#4001100000000000");
        second.sort();
        assert_eq!(second, ["081#0000000000000000", &format!("581#4F011000{register:02X}000000")]);
        assert_eq!((bench.read(0x1003, 0), bench.read(0x1003, 1)), (Ok(0), Ok(0)));
        assert_eq!(bench.ask("601#4001100000000000"), ["581#4F01100000000000"], "nothing is left to be said");
    }
}

/// 12.3.2: writing 0 to 1003h:00 and reset communication clear the history.
#[test]
fn the_history_is_cleared() {
    let mut bench = rotary();
    lose_master(&mut bench);
    assert_eq!(bench.write(0x1003, 0, 1, 1), Err(0x0800_0000));
    let sent = bench.ask("601#2F03100000000000");
    assert!(sent.contains(&"081#0000000000000000".to_owned()), "{sent:?}");
    assert_eq!((bench.read(0x1001, 0), bench.read(0x1003, 0)), (Ok(0), Ok(0)));
    let mut bench = rotary();
    lose_master(&mut bench);
    assert_eq!(bench.reset("82"), ["701#00", "081#0000000000000000"]);
    assert_eq!((bench.read(0x1001, 0), bench.read(0x1003, 0)), (Ok(0), Ok(0)));
}

/// 8.14: the device sends no heartbeat, guarding answer, SDO or PDO for about 3 s, and does not make up for them later.
#[test]
fn silent_while_storing() {
    for model in ["tr-c65", "tr-lmp30"] {
        let mut bench = Bench::new(model);
        bench.write(0x6200, 0, 10, 2).unwrap();
        assert!(bench.ask("000#0101").len() >= 4, "a TPDO every 10 ms");
        let begin = bench.ask("601#2310100173617665");
        assert_eq!(begin, NONE);
        for frame in ["601#4000100000000000", "701#R", "281#R", "080#", "000#8001", "601#4000100000000000"] {
            assert_eq!(bench.ask(frame), NONE, "{frame}");
        }
        assert_eq!(bench.run(2_700), NONE);
        let end = bench.run(60);
        assert!(end.contains(&"581#6010100100000000".to_owned()), "{end:?}");
        assert!(end.iter().filter(|frame| frame.starts_with("181#")).count() <= 6, "{end:?}");
        assert_eq!(bench.ask("701#R").iter().filter(|frame| *frame == "701#05").count(), 1, "NMT was not heard");
    }
}

/// A power failure during a store leaves the old values.
#[test]
fn power_off_while_storing() {
    let mut bench = rotary();
    bench.write(0x6000, 0, SCALING, 2).unwrap();
    bench.write(0x6001, 0, 100, 4).unwrap();
    bench.ask("601#2310100173617665");
    bench.run(2_000);
    bench.power_cycle();
    assert_eq!(bench.read(0x6001, 0), Ok(4096));
}

/// 5.4: only rotary devices send a boot-up message.
#[test]
fn boot_up() {
    assert_eq!(Bench::started("tr-c65", 1).1, ["701#00"]);
    let (mut linear, start) = Bench::started("tr-lmp30", 1);
    assert_eq!(start, NONE);
    assert_eq!((linear.reset("81"), linear.reset("82"), linear.power_cycle()), (vec![], vec![], vec![]));
    assert_eq!(linear.read(0x1000, 0), Ok(0x0008_0196));
    assert_eq!(rotary().reset("82"), ["701#00"]);
}

/// 7.1, 7.2, 11: both TPDOs answer remote frames, and the second TPDO also SYNC; neither is sent before operational.
#[test]
fn remote_frames() {
    for model in ["tr-c65", "tr-lmp30"] {
        let mut bench = Bench::new(model);
        for frame in ["181#R", "281#R", "080#"] {
            assert_eq!(bench.ask(frame), NONE, "{frame} in pre-operational");
        }
        assert_eq!(bench.ask("000#0101"), ["181#BA4C0000"], "once after the start");
        assert_eq!(bench.run(500), NONE, "6200h is 0");
        assert_eq!(bench.ask("181#R"), ["181#BA4C0000"]);
        assert_eq!(bench.ask("281#R"), ["281#BA4C0000"]);
        assert_eq!(bench.ask("080#"), ["281#BA4C0000"]);
        assert_eq!(bench.ask("080#01"), NONE, "8.6: SYNC has no data");
        bench.ask("000#0201");
        assert_eq!(bench.ask("281#R"), NONE);
    }
}

/// 8.6: bit 31 of 1005h makes the device consume SYNC.
#[test]
fn cob_id_of_sync() {
    let mut bench = rotary();
    bench.ask("000#0101");
    bench.write(0x1005, 0, 0x8000_0085, 4).unwrap();
    assert_eq!((bench.ask("080#"), bench.ask("085#")), (vec![], vec!["281#BA4C0000".to_owned()]));
    bench.write(0x1005, 0, 0x0000_0085, 4).unwrap();
    assert_eq!(bench.ask("085#"), NONE);
    assert_eq!(bench.write(0x1005, 0, 0xC000_0080, 4), Err(0x0800_0000), "it can't produce SYNC");
}

/// 7.1: 6200h is the only event of TPDO 1.
#[test]
fn the_first_tpdo_is_cyclic() {
    let mut bench = rotary();
    bench.write(0x6200, 0, 100, 2).unwrap();
    bench.device.set_motion(bench.now, Motion::constant(0, 60_000));
    assert_eq!(bench.ask("000#0101").len(), 1);
    assert_eq!(bench.run(1_000).len(), 10, "not on every change of a moving shaft");
    bench.write(0x6200, 0, 0, 2).unwrap();
    assert_eq!(bench.run(1_000), NONE);
}

/// 9.1: values of 6000h, 6003h and 6200h take effect and are stored at once.
#[test]
fn stored_at_once() {
    let mut bench = rotary();
    bench.write(0x6000, 0, 1, 2).unwrap();
    bench.write(0x6200, 0, 256, 2).unwrap();
    bench.write(0x6003, 0, 1_000, 4).unwrap();
    assert_eq!((bench.read(0x6004, 0), bench.read(0x6500, 0)), (Ok(1_000), Ok(1)));
    let offset = bench.read(0x6509, 0);
    bench.power_cycle();
    assert_eq!((bench.read(0x6000, 0), bench.read(0x6003, 0), bench.read(0x6200, 0)), (Ok(1), Ok(1_000), Ok(256)));
    assert_eq!((bench.read(0x6004, 0), bench.read(0x6509, 0)), (Ok(1_000), offset));
    // A value that only 1010h stores is lost.
    bench.write(0x100C, 0, 500, 2).unwrap();
    bench.power_cycle();
    assert_eq!(bench.read(0x100C, 0), Ok(0));
}

/// 9.1: values of 6001h and 6002h take effect only when they are stored.
#[test]
fn scaling_acts_when_stored() {
    let mut bench = rotary();
    bench.write(0x6000, 0, SCALING, 2).unwrap();
    assert_eq!((bench.read(0x6501, 0), bench.read(0x6502, 0)), (Ok(4096), Ok(4096)));
    bench.write(0x6001, 0, 2048, 4).unwrap();
    bench.write(0x6002, 0, 2048 * 512, 4).unwrap();
    assert_eq!((bench.read(0x6001, 0), bench.read(0x6004, 0)), (Ok(2048), Ok(0x4CBA)), "written, but not in use");
    bench.save();
    assert_eq!(bench.read(0x6004, 0), Ok(0x4CBA / 2));
    assert_eq!((bench.read(0x6501, 0), bench.read(0x6502, 0)), (Ok(2048), Ok(512)), "9.1.5.2, 9.1.5.4");
    bench.power_cycle();
    assert_eq!((bench.read(0x6001, 0), bench.read(0x6004, 0)), (Ok(2048), Ok(0x4CBA / 2)));
    bench.write(0x6001, 0, 1024, 4).unwrap();
    bench.power_cycle();
    assert_eq!(bench.read(0x6001, 0), Ok(2048), "what was not stored is lost");
}

/// 9.1.1: the scaling bit must be set before 6001h and 6002h change; clearing it restores their defaults.
#[test]
fn the_scaling_bit_guards() {
    let mut bench = rotary();
    assert_eq!(bench.write(0x6001, 0, 2048, 4), Err(0x0601_0000));
    assert_eq!(bench.write(0x6002, 0, 2048, 4), Err(0x0601_0000));
    bench.write(0x6000, 0, SCALING, 2).unwrap();
    bench.write(0x6001, 0, 2048, 4).unwrap();
    bench.save();
    bench.write(0x6001, 0, 1024, 4).unwrap();
    bench.write(0x6000, 0, 0, 2).unwrap();
    let defaults = (Ok(4096), Ok(16_777_216));
    assert_eq!((bench.read(0x6001, 0), bench.read(0x6002, 0)), defaults);
    assert_eq!(bench.read(0x6004, 0), Ok(0x4CBA));
    bench.power_cycle();
    assert_eq!((bench.read(0x6001, 0), bench.read(0x6002, 0)), defaults, "the stored ones are gone too");
    // 9.1.1: bits 1 and 3 to 15 are reserved.
    for bit in (1..16).filter(|bit| *bit != 2) {
        assert_eq!(bench.write(0x6000, 0, 1 << bit, 2), Err(0x0800_0000), "bit {bit}");
    }
}

/// 8.14, 9.1.5.5: 1010h checks the limits and fails; 6503h, 1001h and an EMCY report this.
#[test]
fn limits_are_checked_when_stored() {
    let mut bench = rotary();
    bench.write(0x6000, 0, SCALING, 2).unwrap();
    for (index, wrong, right) in [(0x6001, 8_193, 8_192), (0x6002, 15, 16), (0x6002, 33_554_433, 33_554_432)] {
        bench.write(index, 0, wrong, 4).unwrap();
        let sent = bench.save();
        assert_eq!(sent, ["081#0010210000000000", "581#8010100106000006"], "{index:04X} = {wrong}");
        assert_eq!((bench.read(0x6503, 0), bench.read(0x1003, 1)), (Ok(1 << 13), Ok(0x1000)));
        bench.write(index, 0, right, 4).unwrap();
        let sent = bench.save();
        assert!(sent.contains(&"581#6010100100000000".to_owned()), "{sent:?}");
        assert_eq!((bench.read(0x6503, 0), bench.read(index, 0)), (Ok(0), Ok(right)));
        bench.ask("601#2F03100000000000");
    }
}

/// 12.2: the abort codes of the device.
#[test]
fn abort_codes() {
    for model in ["tr-c65", "tr-lmp30"] {
        let mut bench = Bench::new(model);
        for (index, sub, value, len, code) in [
            (0x1000, 0, 0, 4, 0x0601_0000),
            (0x1800, 1, 0, 4, 0x0601_0000),
            (0x1A00, 0, 0, 1, 0x0601_0000),
            (0x1010, 1, 0x7361_7665, 4, 0x0800_0000),
            (0x1010, 1, 0, 4, 0x0800_0000),
            (0x1010, 2, 0, 4, 0x0609_0011),
            (0x1003, 2, 0, 4, 0x0609_0011),
            (0x6003, 0, 0x0200_0000, 4, 0x0800_0000),
        ] {
            assert_eq!(bench.write(index, sub, value, len), Err(code), "{index:04X}h:{sub:02X} = {value:X}h");
        }
        // The device follows DS-301 V3.0, which does not have these objects.
        for index in [0x1006, 0x1011, 0x1014, 0x1015, 0x1016, 0x1017, 0x1029, 0x1801, 0x1A01] {
            assert_eq!(bench.read(index, 0), Err(0x0602_0000), "{index:04X}h");
        }
    }
    assert_eq!(rotary().read(0x1018, 0), Err(0x0602_0000));
}

/// 9.1.2: a preset is from 0 to the measuring length - 1.
#[test]
fn preset_of_a_linear_encoder() {
    let mut bench = Bench::new("tr-lmp30");
    assert_eq!(bench.write(0x6003, 0, 100_000, 4), Err(0x0800_0000));
    bench.write(0x6003, 0, 99_999, 4).unwrap();
    assert_eq!(bench.read(0x6004, 0), Ok(99_999));
    bench.device.set_motion(bench.now, Motion::still(0x4CBA + 1));
    assert_eq!(bench.read(0x6004, 0), Ok(0), "the end of the measuring range");
    bench.write(0x6000, 0, SCALING, 2).unwrap();
    assert_eq!(bench.write(0x6001, 0, 2, 4), Err(0x0800_0000), "fixed to 1");
}

/// 9.1.5.3: a step is 0.01 mm. 10 mm/s are 1000 steps a second.
#[test]
fn a_linear_encoder_moves_by_millimetres() {
    let mut bench = Bench::new("tr-lmp30");
    let Ok(MotionSpec::Known(motion)) = "mm/s=10".parse() else { panic!("no motion") };
    bench.device.set_motion(bench.now, motion);
    let (began, first) = (bench.now, bench.read(0x6004, 0).unwrap());
    bench.run(1_000);
    let (ended, last) = (bench.now, bench.read(0x6004, 0).unwrap());
    let rate = f64::from(last - first) / ended.since(began).as_millis();
    assert!((0.98..1.02).contains(&rate), "{rate} steps in a millisecond");
}

/// 7.1: the inhibit time can be written although the COB-ID, and so bit 31, is read-only.
#[test]
fn inhibit_time() {
    let mut bench = rotary();
    bench.write(0x1800, 3, 500, 2).unwrap();
    bench.write(0x6200, 0, 10, 2).unwrap();
    let mut sent = bench.ask("000#0101");
    sent.extend(bench.run(960));
    assert!((18..=21).contains(&sent.len()), "one in 50 ms: {}", sent.len());
}

/// 4.6.1.1: reset node sets the profile parameters to their defaults, even if other values are stored; power-on loads
/// the stored values.
#[test]
fn reset_node_restores_the_profile() {
    let mut bench = rotary();
    bench.write(0x6000, 0, SCALING, 2).unwrap();
    bench.write(0x6001, 0, 2048, 4).unwrap();
    bench.write(0x6200, 0, 256, 2).unwrap();
    bench.write(0x100C, 0, 500, 2).unwrap();
    bench.save();
    bench.reset("81");
    let values = |bench: &mut Bench| [0x6000, 0x6001, 0x6200, 0x100C].map(|index| bench.read(index, 0).unwrap());
    assert_eq!(values(&mut bench), [0, 4096, 0, 500]);
    bench.power_cycle();
    assert_eq!(values(&mut bench), [SCALING, 2048, 256, 500]);
    bench.reset("82");
    assert_eq!(values(&mut bench), [SCALING, 2048, 256, 500], "reset communication leaves them");
}

/// 4.6.1.2: the loss of the master brings the device into pre-operational.
#[test]
fn life_guarding() {
    let mut bench = rotary();
    bench.write(0x100C, 0, 100, 2).unwrap();
    bench.write(0x100D, 0, 3, 1).unwrap();
    bench.ask("000#0101");
    assert_eq!(bench.run(1_000), NONE, "not before the first remote frame");
    assert_eq!(bench.ask("701#R"), ["701#05"]);
    assert_eq!(bench.ask("701#R"), ["701#85"], "the toggle bit");
    assert_eq!(bench.run(250), NONE);
    assert_eq!(bench.run(20), ["081#0081010000000000"], "after 300 ms");
    assert_eq!(bench.ask("701#R"), ["701#7F", "081#0000000000000000"]);
    // 8.11: a guard time of 0 switches the monitoring off; the device still answers guarding.
    bench.write(0x100C, 0, 0, 2).unwrap();
    assert_eq!(bench.ask("701#R"), ["701#FF"]);
    assert_eq!(bench.run(1_000), NONE);
}

/// 8.7 to 8.9: the device sends names in segments, even short names.
#[test]
fn names_come_in_segments() {
    let mut bench = Bench::new("tr-lmp30");
    assert_eq!(bench.ask("601#4009100000000000"), ["581#4109100003000000"]);
    assert_eq!(bench.ask("601#6000000000000000"), ["581#09312E3000000000"]);
    assert_eq!(bench.read_bytes(0x1008, 0), Ok(b"LMP30".to_vec()));
    assert_eq!(bench.read_bytes(0x100A, 0), Ok(b"5022.01".to_vec()));
}

/// 8.10, 8.13: the device shows the node-ID of the DIP switches, and nothing on the bus can change it.
#[test]
fn node_id_of_dip_switches() {
    let (mut bench, start) = Bench::started("tr-c65", 64);
    assert_eq!(start, ["740#00"]);
    assert_eq!(bench.read_from(64, 0x100B, 0), Ok(64));
    assert_eq!(bench.read_from(64, 0x100E, 0), Ok(0x740));
    bench.power_cycle();
    assert_eq!(bench.read_from(64, 0x100B, 0), Ok(64));
}
