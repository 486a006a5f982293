//! Features that only the reference device has: RPDOs, production of SYNC and TIME, a second SDO channel, a change of
//! the bit rate.

use crate::rig::{Rig, parse, periods};
use canvass_analyzer::NodeId;
use canvass_bus::{Bus, SimulatedBus};
use canvass_device::Faults;
use canvass_device::models::Model;
use canvass_device::{Device, Memory, Motion};
use canvass_traces::{Duration, Timestamp};

const NONE: [&str; 0] = [];

fn reference() -> Rig {
    powered("reference-301", Some(63))
}

fn powered(model: &str, node: Option<u8>) -> Rig {
    let mut rig = Rig::powered(Model::by_id(model).unwrap(), node, Faults::NONE, &Motion::default());
    rig.run(300);
    rig
}

fn only(frames: Vec<String>, id: &str) -> Vec<String> {
    frames.into_iter().filter(|frame| frame.starts_with(id)).collect()
}

#[test]
fn rpdos_act_in_operational_only() {
    let mut rig = reference();
    assert_eq!(rig.ask("23F#01020304"), NONE);
    assert_eq!(rig.read(0x6200, 1), Ok(0));
    rig.ask("000#013F");
    assert_eq!(rig.ask("23F#01020304"), ["1BF#01020304"], "the inputs are wired to the outputs");
    assert_eq!(rig.read(0x6200, 4), Ok(4));
    for ignored in ["23F#R4", "0000023F#0A0A0A0A"] {
        assert_eq!(rig.ask(ignored), NONE);
    }
}

#[test]
fn a_synchronous_rpdo_waits_for_sync_and_skips_dummies() {
    let mut rig = reference();
    rig.ask("000#013F");
    assert_eq!(rig.ask("43F#C800FF07"), NONE);
    assert_eq!((rig.read(0x2041, 0), rig.read(0x2030, 5)), (Ok(100), Ok(0)));
    rig.ask("080#");
    assert_eq!((rig.read(0x2041, 0), rig.read(0x2030, 5)), (Ok(200), Ok(7)));
    rig.ask("43F#FFFFFF08");
    rig.ask("080#");
    assert_eq!((rig.read(0x2041, 0), rig.read(0x2030, 5)), (Ok(200), Ok(8)), "above its limit: left out");
}

#[test]
fn lengths_of_rpdos() {
    let mut rig = reference();
    rig.ask("000#013F");
    assert_eq!(only(rig.ask("23F#0102"), "0BF"), ["0BF#1082110100000000"], "8210h, PDO 1");
    assert_eq!(rig.read(0x6200, 1), Ok(0));
    assert_eq!(only(rig.ask("23F#0102"), "0BF"), NONE, "once");
    assert_eq!(only(rig.ask("23F#01020304"), "0BF"), ["0BF#0000000000000000"]);
    let frames = rig.ask("23F#0506070809");
    assert_eq!(only(frames, "0BF"), ["0BF#2082110100000000"], "8220h");
    assert_eq!(rig.read(0x6200, 4), Ok(8), "the first bytes act");
}

#[test]
fn the_deadline_of_an_rpdo() {
    let mut rig = reference();
    assert_eq!(rig.write(0x1400, 5, 100, 2), "ok");
    rig.ask("000#013F");
    assert_eq!(only(rig.run(500), "0BF"), NONE, "not before the first one");
    rig.ask("23F#01020304");
    assert_eq!(only(rig.run(100), "0BF"), ["0BF#5082110100000000"]);
    assert_eq!(only(rig.ask("23F#01020304"), "0BF"), ["0BF#0000000000000000"]);
}

#[test]
fn mapping_of_rpdos() {
    let mut rig = reference();
    assert_eq!(rig.write(0x1600, 0, 0, 1), "06010000", "valid");
    assert_eq!(rig.write(0x1400, 1, 0x8000_023F, 4), "ok");
    assert_eq!(rig.write(0x1600, 1, 0x6200_0108, 4), "06010000", "in use");
    assert_eq!(rig.write(0x1600, 0, 0, 1), "ok");
    for (entry, answer) in [
        (0x6000_0108, "06040041"), // an input can't be mapped into an RPDO
        (0x6200_0908, "06020000"),
        (0x0005_0008, "ok"),
        (0x0005_0010, "06040041"), // the length differs from the dummy type
        (0x2040_0020, "06040041"),
        (0x2030_0101, "ok"), // one bit
    ] {
        assert_eq!(rig.write(0x1600, 1, entry, 4), answer, "{entry:08X}");
    }
    assert_eq!(rig.write(0x1600, 0, 9, 1), "06040042");
    assert_eq!(rig.write(0x1400, 1, 0x0000_023F, 4), "06090030", "nothing mapped");
    for (sub, entry) in [(1, 0x2030_0740), (2, 0x2030_0F40)] {
        assert_eq!(rig.write(0x1600, sub, entry, 4), if sub == 1 { "06040041" } else { "ok" });
    }
    assert_eq!(rig.write(0x1600, 1, 0x2030_0E40, 4), "ok");
    assert_eq!(rig.write(0x1600, 0, 2, 1), "06040042", "128 bits");
    assert_eq!(rig.write(0x1400, 2, 252, 1), "06090030", "reserved for RPDOs");
}

#[test]
fn sync_is_produced_and_counted() {
    let mut rig = reference();
    assert_eq!(rig.write(0x1019, 0, 1, 1), "06090030");
    assert_eq!(rig.write(0x1019, 0, 241, 1), "06090030");
    assert_eq!(rig.write(0x1019, 0, 5, 1), "ok");
    assert_eq!(rig.write(0x1006, 0, 10, 4), "06090030", "faster than the device can");
    assert_eq!(rig.write(0x1006, 0, 50_000, 4), "ok");
    assert_eq!(rig.write(0x1019, 0, 0, 1), "08000022", "1006h is not 0");
    assert_eq!(rig.write(0x1005, 0, 0x4000_0080, 4), "ok");
    assert_eq!(rig.write(0x1005, 0, 0x4000_0081, 4), "06090030", "while producing");
    rig.ask("000#013F");
    rig.ask("000#023F");
    assert_eq!(rig.run(500), NONE, "not in stopped");
    rig.send("000#013F");
    let records = rig.records(400);
    let syncs: Vec<_> = records.iter().filter(|record| record.frame.cob_id() == Some(0x080)).cloned().collect();
    let counters: Vec<u8> = syncs.iter().map(|record| record.frame.data()[0]).collect();
    assert_eq!(counters[..7], [1, 2, 3, 4, 5, 1, 2]);
    assert!(periods(&syncs).iter().all(|period| (period - 50.0).abs() < 0.5));
    let pdos = records.iter().filter(|record| record.frame.cob_id() == Some(0x3BF)).count();
    assert_eq!(pdos, syncs.len(), "its own synchronous TPDO follows");
}

#[test]
fn the_sync_start_value() {
    let mut rig = reference();
    assert_eq!(rig.write(0x1802, 6, 3, 1), "06090030", "while valid");
    rig.write(0x1019, 0, 5, 1);
    rig.write(0x1802, 1, 0x8000_03BF, 4);
    assert_eq!(rig.write(0x1802, 6, 241, 1), "06090030");
    assert_eq!(rig.write(0x1802, 6, 3, 1), "ok");
    assert_eq!(rig.write(0x1802, 1, 0x0000_03BF, 4), "ok");
    rig.ask("000#013F");
    let sent: Vec<usize> = (1..=5).map(|n| only(rig.ask(&format!("080#{n:02X}")), "3BF").len()).collect();
    assert_eq!(sent, [0, 0, 1, 1, 1]);
    assert_eq!(only(rig.ask("080#"), "0BF"), ["0BF#4082110000000000"], "8240h");
    assert_eq!(only(rig.ask("080#01"), "0BF"), ["0BF#0000000000000000"]);
}

/// TIME sets the clock: 2026-11-21 is day 15665 after 1984-01-01.
#[test]
fn time_is_consumed_and_produced() {
    let mut rig = reference();
    rig.ask("100#00000000313D");
    let answer = only(rig.ask("63F#4020200000000000"), "5BF");
    assert_eq!(answer, ["5BF#4120200006000000"], "six bytes take segments");
    let segment = only(rig.ask("63F#6000000000000000"), "5BF").remove(0);
    assert!(segment.ends_with("313D00"), "{segment}");
    assert_eq!(rig.write(0x1012, 0, 0x8000_0200, 4), "06090030", "while in use");
    assert_eq!(rig.write(0x1012, 0, 0x4000_0100, 4), "ok");
    let times = only(rig.run(3_050), "100#");
    assert_eq!(times.len(), 3);
    assert!(times.iter().all(|time| time.len() == "100#".len() + 12 && time.ends_with("313D")), "{times:?}");
}

#[test]
fn the_second_sdo_channel_is_a_server_of_its_own() {
    let mut rig = reference();
    assert_eq!(rig.write(0x1201, 1, 0x601, 4), "06090030", "restricted");
    assert_eq!(rig.write(0x1201, 1, 0x6A0, 4), "ok");
    assert_eq!(rig.ask("6A0#4000100000000000"), NONE, "the other COB-ID is not valid yet");
    assert_eq!(rig.write(0x1201, 2, 0x6A1, 4), "ok");
    assert_eq!(rig.write(0x1201, 1, 0x6A2, 4), "06090030", "while valid");
    // Two segmented transfers at the same time, one on each SDO channel.
    assert_eq!(rig.ask("6A0#4008100000000000"), ["6A1#4108100015000000"]);
    assert_eq!(rig.ask("63F#4011200000000000"), ["5BF#4111200005000000"]);
    assert_eq!(rig.ask("6A0#6000000000000000"), ["6A1#0063616E76617373"]);
    assert_eq!(rig.ask("63F#6000000000000000"), ["5BF#0562656E63680000"]);
    assert_eq!(rig.ask("6A0#7000000000000000"), ["6A1#1020726566657265"]);
    rig.send("000#823F");
    rig.run(300);
    assert_eq!(rig.ask("6A0#4000100000000000"), NONE, "off again");
}

#[test]
fn emcy_of_others_and_error_behaviour() {
    let mut rig = reference();
    assert_eq!(rig.write(0x1028, 1, 0x85, 4), "ok");
    rig.ask("085#1020010000000000");
    assert_eq!(only(rig.ask("63F#4021200000000000"), "5BF").len(), 1);
    assert_eq!(only(rig.ask("63F#6000000000000000"), "5BF"), ["5BF#0010200100000000"]);
    assert_eq!(rig.write(0x1029, 1, 3, 1), "06090030");
    for (behaviour, state) in [(0, "7F"), (1, "05"), (2, "04")] {
        let mut rig = reference();
        assert_eq!(rig.write(0x1029, 1, behaviour, 1), "ok");
        rig.write(0x1016, 1, 0x0005_0064, 4);
        rig.write(0x1017, 0, 10, 2);
        rig.ask("000#013F");
        rig.ask("705#05");
        assert_eq!(rig.run(200).last().unwrap(), &format!("73F#{state}"), "{behaviour}");
    }
}

#[test]
fn start_up_and_verification() {
    let mut rig = reference();
    assert_eq!(rig.write(0x1020, 1, 15_665, 4), "ok");
    assert_eq!(rig.write(0x1F80, 0, 0, 4), "ok");
    assert_eq!(rig.read(0x1020, 1), Ok(0), "the configuration has changed");
    assert_eq!(rig.write(0x1010, 1, 0x6576_6173, 4), "ok");
    rig.run(50);
    rig.send("000#813F");
    let frames = rig.run(300);
    assert!(frames.iter().any(|frame| frame.starts_with("1BF")), "operational by itself: {frames:?}");
    assert_eq!(rig.write(0x2042, 1, 1001, 4), "06090036");
    assert_eq!(rig.write(0x2042, 2, 5, 4), "ok");
}

#[test]
fn a_node_id_by_lss_waits_for_reset_communication() {
    let mut rig = reference();
    for frame in ["7E5#0401000000000000", "7E5#1105000000000000", "7E5#0400000000000000"] {
        rig.ask(frame);
    }
    assert_eq!(rig.read(0x1000, 0), Ok(0x000F_0191), "still node 63");
    rig.send("000#823F");
    assert_eq!(rig.run(300), ["705#00"]);
    rig.send("000#8105");
    assert_eq!(rig.run(300), ["73F#00"], "not stored");
}

/// The device is silent for the delay, changes its bit rate, and is silent again. Then only nodes with the new bit rate
/// understand it.
#[test]
fn the_bit_rate_changes() {
    let mut rig = reference();
    rig.write(0x1017, 0, 10, 2);
    for frame in ["7E5#0401000000000000", "7E5#1300020000000000"] {
        rig.ask(frame);
    }
    rig.send("7E5#15F4010000000000");
    assert_eq!(rig.run(5), NONE);
    assert_eq!(rig.run(2_000), NONE, "silent, then at another bit rate");
    assert_eq!(rig.read(0x1000, 0), Err("silence".to_owned()));
    rig.bus.set_bit_rate(500_000).unwrap();
    assert_eq!(rig.run(25).first().unwrap(), "73F#7F");
    assert_eq!(rig.read(0x1000, 0), Ok(0x000F_0191));
    rig.send("000#813F");
    assert_eq!(rig.run(400), NONE, "not stored: back at the bit rate of delivery");
    rig.bus.set_bit_rate(250_000).unwrap();
    assert_eq!(rig.read(0x1000, 0), Ok(0x000F_0191));
}

#[test]
fn what_is_not_stored_is_lost_at_power_off() {
    let mut rig = reference();
    rig.write(0x1017, 0, 500, 2);
    rig.write(0x2041, 0, 500, 2);
    assert_eq!(rig.write(0x1010, 4, 0x6576_6173, 4), "ok");
    rig.run(50);
    rig.bus.power_cycle(0);
    assert_eq!(rig.run(300), ["73F#00"]);
    assert_eq!((rig.read(0x1017, 0), rig.read(0x2041, 0)), (Ok(0), Ok(500)));
}

/// The memory of one device, read from its text by another device, gives both the same values.
#[test]
fn the_memory_outlives_the_device() {
    use canvass_bus::Machine;
    let model = Model::by_id("reference-301").unwrap();
    let new = || Device::new(model, NodeId::new(63), Faults::NONE, 0);
    let mut device = new();
    let mut now = Timestamp(1_000_000_000);
    device.handle_timeout(now);
    for frame in ["63F#2B412000F4010000", "63F#2310100173617665"] {
        device.handle(now, &parse(frame));
        now += Duration::from_millis(100);
        device.handle_timeout(now);
    }
    let text = device.memory().to_string();
    assert!(text.contains("\"2041:00\" = \"0x1F4\""), "{text}");
    let memory: Memory = text.parse().unwrap();
    let mut other = new();
    other.insert_memory(Timestamp::ZERO, &memory).unwrap();
    assert_eq!(other.memory(), memory);
    let mut bus = SimulatedBus::new(250_000);
    bus.attach(Box::new(other));
    let mut rig = Rig { bus };
    rig.run(300);
    assert_eq!(rig.read(0x2041, 0), Ok(500));
    assert!("nonsense".parse::<Memory>().is_err());
    let foreign = text.replace("reference-301", "reference-406").parse().unwrap();
    assert!(new().insert_memory(Timestamp::ZERO, &foreign).unwrap_err().to_string().contains("reference-406"));
}
