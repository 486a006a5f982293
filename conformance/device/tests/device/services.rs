//! Storing and LSS.

use crate::rig::{Rig, model};
use canvass_device::Motion;

const SAVE: u32 = 0x6576_6173;
const LOAD: u32 = 0x6461_6F6C;

fn reset(rig: &mut Rig, command: &str) {
    rig.send(&format!("000#{command}3F"));
    rig.run(300);
}

#[test]
fn stored_by_groups() {
    let mut rig = Rig::new();
    let change = |rig: &mut Rig| {
        rig.write(0x1017, 0, 2000, 2);
        rig.write(0x6001, 0, 100, 4);
        rig.write(0x2140, 1, 7, 4);
    };
    let values = |rig: &mut Rig| (rig.read(0x1017, 0), rig.read(0x6001, 0), rig.read(0x2140, 1));
    change(&mut rig);
    reset(&mut rig, "82");
    assert_eq!(values(&mut rig), (Ok(0), Ok(100), Ok(7)), "only communication parameters");
    change(&mut rig);
    assert_eq!(rig.write(0x1010, 2, SAVE, 4), "ok");
    reset(&mut rig, "81");
    assert_eq!(values(&mut rig), (Ok(2000), Ok(0x2000), Ok(0)));
    change(&mut rig);
    assert_eq!(rig.write(0x1010, 1, SAVE, 4), "ok");
    reset(&mut rig, "81");
    assert_eq!(values(&mut rig), (Ok(2000), Ok(100), Ok(7)));
    assert_eq!(rig.write(0x1011, 3, LOAD, 4), "ok");
    assert_eq!(values(&mut rig), (Ok(2000), Ok(100), Ok(7)), "not before the next reset");
    reset(&mut rig, "81");
    assert_eq!(values(&mut rig), (Ok(2000), Ok(0x2000), Ok(7)));
    assert_eq!(rig.read(0x1010, 1), Ok(1));
}

#[test]
fn storing_takes_time_and_a_reset_before_its_end_leaves_the_old_values() {
    let mut rig = Rig::new();
    rig.write(0x6001, 0, 100, 4);
    rig.send("63F#2310100173617665");
    assert!(rig.run(14).is_empty());
    rig.send("000#813F");
    rig.run(300);
    assert_eq!(rig.read(0x6001, 0), Ok(0x2000));
}

#[test]
fn a_new_node_id_needs_its_own_store() {
    let mut rig = Rig::new();
    rig.write(0x2101, 0, 5, 1);
    rig.write(0x1010, 1, SAVE, 4);
    reset(&mut rig, "81");
    assert_eq!(rig.read(0x2101, 0), Ok(63));
    rig.write(0x2101, 0, 5, 1);
    assert_eq!(rig.write(0x2105, 0, SAVE, 4), "ok");
    rig.send("000#823F");
    assert_eq!(rig.run(300), ["73F#00"], "not by reset communication");
    rig.send("000#813F");
    assert_eq!(rig.run(300), ["705#00"]);
    assert_eq!(rig.ask("605#4000180100000000"), ["585#4300180185010000"], "COB-IDs follow");
}

#[test]
fn lss_addresses() {
    let none: [&str; 0] = [];
    let mut rig = Rig::new();
    assert_eq!(rig.ask("7E5#5A00000000000000"), none, "waiting");
    for frame in ["7E5#4013000000000000", "7E5#4101206858000000", "7E5#4266000000000000"] {
        assert_eq!(rig.ask(frame), none);
    }
    assert_eq!(rig.ask("7E5#4300000000000000"), none, "another serial number");
    for frame in ["7E5#4013000000000000", "7E5#4101206858000000", "7E5#4266000000000000"] {
        rig.ask(frame);
    }
    assert_eq!(rig.ask(&format!("7E5#43{}000000", serial())), ["7E4#4400000000000000"]);
    assert_eq!(rig.ask("7E5#5A00000000000000"), ["7E4#5A13000000000000"]);
    assert_eq!(rig.ask("7E5#5D00000000000000"), [format!("7E4#5D{}000000", serial())]);
    for bad in ["00", "80", "FE"] {
        assert_eq!(rig.ask(&format!("7E5#11{bad}000000000000")), ["7E4#1101000000000000"]);
    }
    assert_eq!(rig.ask("7E5#1300050000000000"), ["7E4#1301000000000000"], "reserved");
    assert_eq!(rig.ask("7E5#5F00000000000000"), none);
    rig.ask("000#013F");
    assert_eq!(rig.ask("7E5#5A00000000000000"), none, "this device knows no LSS when operational");
}

#[test]
fn what_lss_does_not_store_is_lost() {
    let mut rig = Rig::new();
    for frame in ["7E5#0401000000000000", "7E5#1105000000000000", "7E5#0400000000000000"] {
        rig.ask(frame);
    }
    assert_eq!(rig.run(300), ["705#00"]);
    rig.send("000#8105");
    assert_eq!(rig.run(300), ["73F#00"]);
}

fn serial() -> String {
    let serial = Rig::new().read(0x1018, 4).unwrap().to_le_bytes();
    serial.iter().map(|byte| format!("{byte:02X}")).collect()
}

#[test]
fn identify_remote_slave() {
    let mut rig = Rig::new();
    let mut ask = |low: &str, high: &str| -> Vec<String> {
        let revision = [format!("48{low}"), format!("49{high}")];
        let frames = ["4613000000", "4701206858", &revision[0], &revision[1], "4A00000000", "4BFFFFFFFF"];
        frames.iter().flat_map(|frame| rig.ask(&format!("7E5#{frame}000000"))).collect()
    };
    assert_eq!(ask("66000000", "66000000"), ["7E4#4F00000000000000"]);
    assert!(ask("67000000", "FF000000").is_empty());
    assert!(ask("00000000", "65000000").is_empty());
}

#[test]
fn fastscan_finds_a_device_without_node_id() {
    let mut rig = Rig::powered(model(), None, Default::default(), &Motion::default());
    assert!(rig.run(1000).is_empty(), "no boot-up without node-ID");
    assert_eq!(rig.ask("7E5#4C00000000000000"), ["7E4#5000000000000000"]);
    let mut scan = |id: u32, check: u8, sub: u8, next: u8| {
        let id: String = id.to_le_bytes().iter().map(|byte| format!("{byte:02X}")).collect();
        !rig.ask(&format!("7E5#51{id}{check:02X}{sub:02X}{next:02X}")).is_empty()
    };
    assert!(scan(0, 0x80, 0, 0));
    assert!(!scan(0, 32, 0, 0) && !scan(0, 127, 0, 0) && !scan(0, 31, 4, 0) && !scan(0, 31, 0, 9));
    let mut found = [0_u32; 4];
    for part in 0..4_u8 {
        let id = &mut found[usize::from(part)];
        for bit in (0..32).rev() {
            if !scan(*id, bit, part, part) {
                *id |= 1 << bit;
            }
        }
        assert!(scan(*id, 0, part, (part + 1) % 4));
    }
    assert_eq!(&found[..3], [0x13, 0x5868_2001, 102]);
    assert_eq!(rig.ask("7E5#5E00000000000000"), ["7E4#5EFF000000000000"], "configuring now");
    assert_eq!(rig.ask("7E5#1105000000000000"), ["7E4#1100000000000000"]);
    rig.send("7E5#0400000000000000");
    assert_eq!(rig.run(300), ["705#00"]);
}
