//! Each need is met by the objects that it names, and by no fewer.

use super::*;
use crate::need::Need;
use crate::scripted::{Row, assert_needs, unmet};

#[test]
fn needs_are_the_objects_that_they_name() {
    let read: [(&'static Need, &[(u16, u8)]); 8] = [
        (&EMCY_OBJECT, &[(0x1014, 0)]),
        (&SERVER_PARAMETER, &[(0x1200, 1)]),
        (&STORE_OBJECT, &[(0x1010, 1)]),
        (&ERROR_HISTORY, &[(0x1003, 0)]),
        (&SYNC, &[(0x1005, 0)]),
        (&RPDO, &[(0x1400, 1), (0x1600, 0)]),
        (&HEARTBEAT_CONSUMER, &[(0x1016, 1)]),
        (&STORE, &[(0x1010, 1)]),
    ];
    for (need, objects) in read {
        assert_needs(need, objects, false);
    }
    let written: [(&'static Need, &[(u16, u8)]); 9] = [
        (&TIME, &[(0x1012, 0)]),
        (&EMCY_ID, &[(0x1014, 0)]),
        (&EMCY_INHIBIT, &[(0x1015, 0)]),
        (&SECOND_SERVER, &[(0x1201, 1), (0x1201, 2)]),
        (&VERIFY_CONFIGURATION, &[(0x1020, 1), (0x1020, 2)]),
        (&SYNC_COUNTER, &[(0x1019, 0)]),
        (&DYNAMIC_MAPPING, &[(0x1800, 1), (0x1A00, 0), (0x1A00, 1)]),
        (&ERROR_BEHAVIOUR, &[(0x1029, 1)]),
        (&START_UP, &[(0x1F80, 0)]),
    ];
    for (need, objects) in written {
        assert_needs(need, objects, true);
    }
}

fn row(index: u16, sub: u8, value: &[u8], writable: bool) -> Row {
    ((index, sub), value.to_vec(), writable)
}

/// Bit 0 of 1010h:01: on command; bit 1: by itself (CiA 301, 7.5.2.13).
#[test]
fn storing_on_command_is_told_from_storing_by_itself() {
    for (value, met) in [(0, true), (1, true), (2, false), (3, true), (6, false), (7, true)] {
        let why = unmet(&STORE, &[row(0x1010, 1, &[value, 0, 0, 0], false)]);
        assert_eq!(why.is_none(), met, "{value}: {why:?}");
    }
}

/// A heartbeat can be set, is fixed, or there is none; guarding shows the state where there is none.
#[test]
fn a_state_shows_by_heartbeat_or_guarding() {
    let (settable, fixed, off) =
        (row(0x1017, 0, &[0, 0], true), row(0x1017, 0, &[0xE8, 3], false), row(0x1017, 0, &[0, 0], false));
    let (guard, life, consumer) =
        (row(0x100C, 0, &[0, 0], true), row(0x100D, 0, &[0], true), row(0x1016, 1, &[0; 4], true));
    let met = |rows: &[&Row]| {
        let rows: Vec<Row> = rows.iter().map(|row| (*row).clone()).collect();
        let needs: [&'static Need; 4] = [&HEARTBEAT, &VISIBLE_STATE, &GUARDING, &MONITORING];
        needs.map(|need| unmet(need, &rows).is_none())
    };
    assert_eq!(met(&[]), [false, false, false, false]);
    assert_eq!(met(&[&settable]), [true, true, false, false]);
    assert_eq!(met(&[&fixed]), [false, true, false, false]);
    assert_eq!(met(&[&off]), [false, false, false, false]);
    assert_eq!(met(&[&guard]), [false, true, true, false]);
    assert_eq!(met(&[&guard, &life]), [false, true, true, true]);
    assert_eq!(met(&[&settable, &guard, &life]), [true, true, true, true]);
    assert_eq!(met(&[&fixed, &guard, &life]), [false, true, false, false]);
    assert_eq!(met(&[&fixed, &consumer]), [false, true, false, true]);
    assert_eq!(unmet(&HEARTBEAT, &[fixed]).as_deref(), Some("the period is fixed: 1017h is 1 s and can't be written"));
    assert_eq!(unmet(&HEARTBEAT, &[off]).as_deref(), Some("the device has no 1017h that can be written"));
}

/// A SYNC producer takes bit 30 of 1005h.
#[test]
fn a_sync_producer_can_be_switched_on() {
    let (id, period) = (row(0x1005, 0, &[0x80, 0, 0, 0], true), row(0x1006, 0, &[0; 4], true));
    assert_eq!(unmet(&SYNC_PRODUCER, &[id.clone(), period.clone()]), None);
    assert!(unmet(&SYNC_PRODUCER, std::slice::from_ref(&id)).is_some());
    assert!(unmet(&SYNC_PRODUCER, &[id, row(0x1006, 0, &[0; 4], false)]).is_some());
    assert!(unmet(&SYNC_PRODUCER, &[row(0x1005, 0, &[0x80, 0, 0, 0], false), period]).is_some());
}

#[test]
fn objects_that_serve_a_case() {
    let (name, heartbeat) = (row(0x1008, 0, b"CANV", false), row(0x1017, 0, &[0, 0], true));
    let device = row(0x1000, 0, &[0x91, 1, 0, 0], false);
    let met = |need: &'static Need, rows: &[&Row]| {
        unmet(need, &rows.iter().map(|row| (*row).clone()).collect::<Vec<_>>()).is_none()
    };
    assert!(met(&NAME, &[&name]) && !met(&NAME, &[&heartbeat]));
    assert!(met(&SCRATCH_OBJECT, &[&heartbeat]) && !met(&SCRATCH_OBJECT, &[&name]));
    // Four bytes need no segments, and this server knows no blocks.
    assert!(!met(&SEGMENTED_UPLOAD, &[&name]) && !met(&LONG_SCRATCH, &[&name]));
    for need in [&BLOCK_UPLOAD, &BLOCK_DOWNLOAD, &BLOCK_CRC] {
        assert!(!met(need, &[&device, &heartbeat]), "{need:?}");
    }
    // Switched on, with an object in it; switched off; empty.
    let tpdo = |valid: u8, count: u8| {
        [
            row(0x1800, 1, &[0xBF, 1, 0, valid], true),
            row(0x1A00, 0, &[count], true),
            row(0x1A00, 1, &[8, 0, 1, 0x10], true),
        ]
    };
    for (valid, count) in [(0x40, 1), (0xC0, 1), (0x40, 0), (0xC0, 0)] {
        assert_eq!(unmet(&TPDO, &tpdo(valid, count)), None, "{valid:02X} {count}");
    }
    assert!(unmet(&TPDO, &tpdo(0x40, 1)[..1]).is_some());
    let [mut id, count, entry] = tpdo(0xC0, 1);
    id.2 = false;
    assert!(unmet(&TPDO, &[id, count, entry]).is_some_and(|why| why.contains("can't be written")));
    assert!(unmet(&EVENT_TIMER, &tpdo(0x40, 1)).is_some());
    assert_eq!(unmet(&EVENT_TIMER, &[&tpdo(0x40, 1)[..], &[row(0x1800, 5, &[0, 0], true)]].concat()), None);
}
