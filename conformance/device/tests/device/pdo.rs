//! The times at which TPDOs are sent.

use crate::rig::{Rig, model, periods};
use canvass_device::Motion;
use canvass_traces::Record;

fn of(records: Vec<Record>, cob_id: u16) -> Vec<Record> {
    records.into_iter().filter(|record| record.frame.cob_id() == Some(cob_id)).collect()
}

#[test]
fn at_every_nth_sync() {
    for (transmission, syncs, expected) in [(1, 20, 20), (2, 20, 10), (10, 25, 2), (240, 239, 0), (240, 240, 1)] {
        let mut rig = Rig::new();
        assert_eq!(rig.write(0x1801, 2, transmission, 1), "ok");
        rig.ask("000#013F");
        let mut sent = 0;
        for _ in 0..syncs {
            rig.send("080#");
            sent += of(rig.records(2), 0x2BF).len();
        }
        assert_eq!(sent, expected, "type {transmission}");
    }
}

#[test]
fn not_before_operational_and_not_after() {
    let mut rig = Rig::new();
    assert!(rig.ask("080#").is_empty());
    rig.ask("000#013F");
    assert_eq!(rig.ask("080#"), ["2BF#BA4C0000"]);
    rig.ask("000#023F");
    assert!(rig.ask("080#").is_empty());
    rig.ask("000#803F");
    assert!(rig.ask("080#").is_empty());
}

#[test]
fn acyclic_at_the_sync_after_an_event() {
    let mut rig = Rig::new();
    assert_eq!(rig.write(0x1801, 2, 0, 1), "ok");
    rig.ask("000#013F");
    assert_eq!(rig.ask("080#"), ["2BF#BA4C0000"], "the first value is new");
    assert!(rig.ask("080#").is_empty());
    assert_eq!(rig.write(0x6003, 0, 5, 4), "ok");
    assert_eq!(rig.ask("080#"), ["2BF#05000000"]);
}

#[test]
fn event_timer_is_the_cyclic_timer() {
    let mut rig = Rig::new();
    assert_eq!(rig.write(0x6200, 0, 100, 2), "ok");
    assert_eq!(rig.read(0x1800, 5), Ok(100));
    rig.send("000#013F");
    let records = of(rig.records(1000), 0x1BF);
    assert_eq!(records.len(), 10);
    assert!(periods(&records).iter().all(|period| (period - 100.0).abs() < 0.5), "{:?}", periods(&records));
    assert_eq!(rig.write(0x1800, 5, 50, 2), "ok");
    assert_eq!(rig.read(0x6200, 0), Ok(50));
    assert!(of(rig.records(1000), 0x1BF).len() >= 19);
    assert_eq!(rig.write(0x6200, 0, 0, 2), "ok");
    rig.run(1);
    assert!(of(rig.records(1000), 0x1BF).is_empty());
}

#[test]
fn on_change_with_inhibit_time() {
    let mut rig = Rig::new();
    assert_eq!(rig.write(0x1800, 1, 0x8000_01BF, 4), "ok");
    assert_eq!(rig.write(0x1800, 2, 254, 1), "ok");
    assert_eq!(rig.write(0x1800, 3, 5000, 2), "ok", "500 ms");
    assert_eq!(rig.write(0x1800, 1, 0x0000_01BF, 4), "ok");
    rig.send("000#013F");
    let mut records = of(rig.records(10), 0x1BF);
    for preset in 1..=10 {
        rig.send(&format!("63F#23036000{preset:02X}000000"));
        records.extend(of(rig.records(50), 0x1BF));
    }
    records.extend(of(rig.records(2000), 0x1BF));
    assert!(periods(&records).iter().all(|&period| period >= 499.9), "{:?}", periods(&records));
    assert_eq!(records.last().unwrap().frame.to_string(), "1BF#0A000000", "the last value comes in the end");
}

#[test]
fn a_moving_shaft_is_reported_by_itself() {
    let mut rig = Rig::powered(model(), Some(63), Default::default(), &Motion::constant(0, 60_000));
    rig.run(300);
    rig.write(0x1800, 2, 254, 1);
    rig.send("000#013F");
    let sent = of(rig.records(100), 0x1BF).len();
    assert!((80..=101).contains(&sent), "{sent}");
}

#[test]
fn remote_frames() {
    let mut rig = Rig::new();
    rig.ask("000#013F");
    assert_eq!(rig.ask("1BF#R4"), ["1BF#BA4C0000"]);
    rig.write(0x1801, 2, 252, 1);
    assert!(rig.ask("2BF#R4").is_empty(), "nothing sampled yet");
    assert!(rig.ask("080#").is_empty());
    rig.write(0x6003, 0, 7, 4);
    assert_eq!(rig.ask("2BF#R4"), ["2BF#BA4C0000"], "the value of the SYNC");
    assert_eq!(rig.write(0x1800, 1, 0x4000_01BF, 4), "ok");
    assert!(rig.ask("1BF#R4").is_empty());
}
