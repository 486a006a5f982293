//! Each need is met by the objects that it names, and by no fewer.

use super::*;
use crate::bench::{Options, Target};
use crate::need::Need;
use crate::need::tests::{asked, assert_needs, unmet};
use crate::scripted::{NODE, Row, described, dictionary, frame, with_bench};
use crate::verdict::Stop;
use canvass_analyzer::NodeId;
use canvass_device::models::Model;
use canvass_traces::{Duration, Frame};
use std::cell::RefCell;
use std::rc::Rc;

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

/// Bit 0 of 1010h:01 means storing on command, bit 1 autonomous storing; the others are 0 (CiA 301, 7.5.2.13).
#[test]
fn storing_on_command_is_told_from_storing_by_itself() {
    for (value, met) in [(0, true), (1, true), (2, false), (3, true), (6, true), (7, true)] {
        let why = unmet(&STORE, &[row(0x1010, 1, &[value, 0, 0, 0], false)]);
        assert_eq!(why.is_none(), met, "{value}: {why:?}");
    }
}

/// A heartbeat is configurable, fixed, or absent; without heartbeat, guarding shows the state.
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

/// A SYNC producer accepts bit 30 of 1005h.
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
    // Four bytes need no segments, and this server does not support blocks.
    assert!(!met(&SEGMENTED_UPLOAD, &[&name]) && !met(&LONG_SCRATCH, &[&name]));
    for need in [&BLOCK_UPLOAD, &BLOCK_DOWNLOAD, &BLOCK_CRC] {
        assert!(!met(need, &[&device, &heartbeat]), "{need:?}");
    }
    // A PDO that is on and mapped, one that is off, and an empty one.
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

fn unknown() -> Target {
    Target::unknown(NodeId::new(NODE).unwrap())
}

/// The requests that a device got, in order.
type Asked = Rc<RefCell<Vec<String>>>;

/// A device with these values. A request that begins with one of the texts in `answers` gets the answer beside the
/// text, or none if that answer is empty. All requests are recorded in `asked`.
fn but(
    rows: &[Row],
    answers: &'static [(&'static str, &'static str)],
    asked: &Asked,
) -> impl FnMut(&Frame) -> Vec<(Duration, Frame)> + use<> {
    let (mut others, asked) = (dictionary(rows.to_vec()), Rc::clone(asked));
    move |request| {
        let text = request.to_string();
        asked.borrow_mut().push(text.clone());
        match answers.iter().find(|(begin, _)| text.starts_with(begin)) {
            Some((_, "")) => Vec::new(),
            Some((_, answer)) => vec![(Duration::from_millis(1), frame(answer))],
            None => others(request),
        }
    }
}

/// The result of asking for a need, and the frames sent.
fn sent(
    need: &'static Need,
    rows: &[Row],
    answers: &'static [(&'static str, &'static str)],
) -> (Result<(), Stop>, Vec<String>) {
    let log = Asked::default();
    let met = asked(need, but(rows, answers, &log), &unknown(), &Options::default());
    let log = log.borrow().clone();
    (met, log)
}

/// The request that begins a transfer, and the abort that ends it: the bench then makes sure that the server is idle.
fn begun_and_aborted(log: &[String]) -> [&str; 2] {
    let abort = log.iter().position(|frame| frame.starts_with("63F#80")).unwrap();
    [&log[abort - 1], &log[abort]]
}

fn actual(met: Result<(), Stop>) -> Option<String> {
    met.err().map(|stop| stop.reason().actual)
}

/// Block download is recognised by its confirmation, and its CRC by a bit of the confirmation; 0504 0001h means that it
/// is not supported, and any other refusal is a breach. The transfer is aborted before any data.
#[test]
fn block_downloads_are_known_by_their_confirmation() {
    const WITH: &[(&str, &str)] = &[("63F#C6171000", "5BF#A41710007F000000")];
    const WITHOUT: &[(&str, &str)] = &[("63F#C6171000", "5BF#A01710007F000000")];
    const NONE: &[(&str, &str)] = &[("63F#C6171000", "5BF#8017100001000405")];
    const WRONG: &[(&str, &str)] = &[("63F#C6171000", "5BF#8017100013000706")];
    let heartbeat = [row(0x1017, 0, &[0, 0], true)];
    let (met, log) = sent(&BLOCK_DOWNLOAD, &heartbeat, WITH);
    assert_eq!(met, Ok(()));
    assert_eq!(begun_and_aborted(&log), ["63F#C617100002000000", "63F#8017100000000008"]);
    assert_eq!(sent(&BLOCK_CRC, &heartbeat, WITH).0, Ok(()));
    assert_eq!(sent(&BLOCK_DOWNLOAD, &heartbeat, WITHOUT).0, Ok(()));
    let crc = actual(sent(&BLOCK_CRC, &heartbeat, WITHOUT).0);
    assert_eq!(crc.as_deref(), Some("the SDO server checks no CRC of block downloads"));
    for need in [&BLOCK_DOWNLOAD, &BLOCK_CRC] {
        let why = actual(sent(need, &heartbeat, NONE).0).unwrap();
        let abort = "abort 0504 0001h command specifier not valid or unknown";
        assert_eq!(why, format!("the block download to 1017h:00 is answered by {abort}"));
        assert!(matches!(sent(need, &heartbeat, WRONG).0, Err(Stop::Breach(_))), "{need:?}");
        let why = unmet(need, &[row(0x1000, 0, &[0; 4], false)]);
        assert_eq!(why.as_deref(), Some("the device has no object that can be written without consequence"));
    }
}

/// If no value is long, the device type is read in blocks; the tester waits for answers to its abort before the case
/// begins.
#[test]
fn block_uploads_are_known_by_their_confirmation() {
    const KNOWN: &[(&str, &str)] = &[("63F#A4001000", "5BF#C600100004000000")];
    let device_type = [row(0x1000, 0, &[0x91, 1, 0, 0], false)];
    let (met, log) = sent(&BLOCK_UPLOAD, &device_type, KNOWN);
    assert_eq!(met, Ok(()));
    assert_eq!(begun_and_aborted(&log), ["63F#A400100001000000", "63F#8000100000000008"]);
    let begun = with_bench(but(&device_type, KNOWN, &Asked::default()), |bench| {
        let request = canvass_analyzer::wire::sdo::Request::upload(canvass_analyzer::Multiplexer::new(0x1000, 0));
        super::block::begun(bench, canvass_analyzer::Multiplexer::new(0x1000, 0), &request, "a read of").unwrap();
        bench.now()
    });
    assert_eq!(begun, canvass_traces::Timestamp::ZERO + Duration::from_millis(1 + 50));
}

/// A server whose objects have at most four bytes need not support segments, and says so by 0504 0001h; any other
/// refusal concerns the value.
#[test]
fn segmented_downloads_are_known_unless_the_command_is() {
    const TAKEN: &[(&str, &str)] = &[("63F#21171000", "5BF#6017100000000000")];
    const UNKNOWN: &[(&str, &str)] = &[("63F#21171000", "5BF#8017100001000405")];
    const TOO_LONG: &[(&str, &str)] = &[("63F#21171000", "5BF#8017100012000706")];
    let heartbeat = [row(0x1017, 0, &[0, 0], true)];
    let (met, log) = sent(&SEGMENTED_DOWNLOAD, &heartbeat, TAKEN);
    assert_eq!((met, begun_and_aborted(&log)[0]), (Ok(()), "63F#2117100004000000"));
    assert_eq!(sent(&SEGMENTED_DOWNLOAD, &heartbeat, TOO_LONG).0, Ok(()));
    assert_eq!(
        actual(sent(&SEGMENTED_DOWNLOAD, &heartbeat, UNKNOWN).0).as_deref(),
        Some(
            "no object has more than four bytes, and the segmented download to 1017h:00 is answered by abort 0504 0001h \
             command specifier not valid or unknown"
        )
    );
    // A value of five bytes needs segments in both directions, so the server is not asked.
    const FIVE: &[(&str, &str)] = &[("63F#40081000", "5BF#4108100005000000"), ("63F#60", "5BF#0541424344450000")];
    let (met, log) = sent(&SEGMENTED_DOWNLOAD, &[], FIVE);
    assert!(met.is_ok() && !log.iter().any(|request| request.starts_with("63F#21")), "{log:?}");
    let text = described(&[("2000", "DataType=0x0009")]);
    let log = Asked::default();
    let met = asked(&SEGMENTED_DOWNLOAD, but(&[], &[], &log), &text, &Options::default());
    assert_eq!((met, log.borrow().len()), (Ok(()), 0));
    assert_eq!(asked(&LONG_SCRATCH, dictionary(Vec::new()), &text, &Options::default()), Ok(()));
}

/// If the description says that 1017h can be written and the device refuses the write, that is a breach. Without such a
/// description the refusal only means that the device does not meet the need.
#[test]
fn a_heartbeat_time_that_can_not_be_written_breaks_its_description() {
    let met = |lines: &str, rows: &[Row]| {
        asked(&HEARTBEAT, dictionary(rows.to_vec()), &described(&[("1017", lines)]), &Options::default())
    };
    let (fixed, settable) = ([row(0x1017, 0, &[0xE8, 3], false)], [row(0x1017, 0, &[0, 0], true)]);
    assert!(matches!(met("DataType=0x0006", &fixed), Err(Stop::Breach(_))));
    assert!(matches!(met("DataType=0x0006", &[]), Err(Stop::Breach(_))), "it is not there at all");
    assert_eq!(met("DataType=0x0006", &settable), Ok(()));
    let constant = actual(met("DataType=0x0006\nAccessType=ro", &fixed));
    assert_eq!(constant.as_deref(), Some("the period is fixed: 1017h is 1 s and can't be written"));
}

/// The tester acts as a neighbour of the device: one of four node-IDs must be free.
#[test]
fn a_heartbeat_consumer_needs_a_vacant_neighbour() {
    let consumer = |neighbours: &'static [u8]| {
        let mut others = dictionary(vec![row(0x1016, 1, &[0; 4], true)]);
        let script = move |request: &Frame| {
            let heartbeats = neighbours.iter().map(|node| frame(&format!("7{node:02X}#05")));
            heartbeats.map(|heartbeat| (Duration::from_micros(10), heartbeat)).chain(others(request)).collect()
        };
        actual(asked(&HEARTBEAT_CONSUMER, script, &unknown(), &Options::default()))
    };
    assert_eq!(consumer(&[0x3D, 0x3E, 0x40]), None);
    let full = consumer(&[0x3D, 0x3E, 0x40, 0x41]);
    assert_eq!(full.as_deref(), Some("every node-ID next to that of the device is in use"));
}

/// Some devices monitor other nodes only after 1016h is stored: their manual says so, and cases that store nothing do
/// not apply.
#[test]
fn a_manual_says_that_monitoring_acts_once_it_is_stored() {
    let stored = Model::all().iter().find(|model| model.sheet().network.heartbeat_consumer_needs_store).unwrap();
    let (consumer, guard) =
        (row(0x1016, 1, &[0; 4], true), [row(0x100C, 0, &[0, 0], true), row(0x100D, 0, &[0], true)]);
    let met = |model: &str, rows: &[Row]| {
        let target = Target { model: model.to_owned(), ..unknown() };
        actual(asked(&MONITORING, dictionary(rows.to_vec()), &target, &Options::default()))
    };
    assert_eq!(met("reference-301", std::slice::from_ref(&consumer)), None);
    assert_eq!(
        met(stored.id(), std::slice::from_ref(&consumer)).as_deref(),
        Some("the device monitors other nodes only after 1016h is stored, as its manual says")
    );
    assert_eq!(met(stored.id(), &guard), None, "guarding acts at once");
    assert_eq!(met("reference-301", &[]).as_deref(), Some("the device has no 1016h:01"));
}

/// A changeable mapping is useful only with an object for it.
#[test]
fn a_mapping_needs_an_object() {
    const RECEIVED: [(&str, &str); 3] =
        [("1400sub1", "DataType=0x0007"), ("1600sub0", "DataType=0x0005"), ("1600sub1", "DataType=0x0007")];
    const SENT: [(&str, &str); 3] =
        [("1800sub1", "DataType=0x0007"), ("1A00sub0", "DataType=0x0005"), ("1A00sub1", "DataType=0x0007")];
    let met = |need: &'static Need, sections: &[(&str, &str)]| {
        let rows = vec![row(0x2000, 0, &[1], true)];
        actual(asked(need, dictionary(rows), &described(sections), &Options::default()))
    };
    let object = ("2000", "DataType=0x0005\nPDOMapping=1");
    let fixed = |sections: [(&'static str, &'static str); 3], at: usize| {
        let mut sections = sections.to_vec();
        sections[at].1 = "DataType=0x0007\nAccessType=ro";
        [&sections[..], &[object]].concat()
    };
    assert_eq!(met(&RPDO_MAPPING, &[&RECEIVED[..], &[object]].concat()), None);
    assert_eq!(
        met(&RPDO_MAPPING, &RECEIVED).as_deref(),
        Some("the description names no object that an RPDO can carry and an SDO can read")
    );
    assert_eq!(met(&RPDO_MAPPING, &fixed(RECEIVED, 2)).as_deref(), Some("1600h:01 can't be written"));
    assert_eq!(met(&CHANGEABLE, &[&SENT[..], &[object]].concat()), None);
    assert_eq!(met(&CHANGEABLE, &SENT).as_deref(), Some("none"));
    assert_eq!(met(&CHANGEABLE, &fixed(SENT, 0)).as_deref(), Some("1800h:01 can't be written"));
}

/// A device that can't produce SYNC refuses bit 30 as the standard allows; any other refusal is a breach. A device that
/// can produce SYNC gets its COB-ID back.
#[test]
fn a_sync_producer_is_left_off() {
    const REFUSED: &[(&str, &str)] = &[("63F#2305100080000040", "5BF#8005100030000906")];
    const TOLERATED: &[(&str, &str)] = &[("63F#2305100080000040", "5BF#8005100000000008")];
    const WRONG: &[(&str, &str)] = &[("63F#2305100080000040", "5BF#8005100041000406")];
    let rows = [row(0x1005, 0, &[0x80, 0, 0, 0], true), row(0x1006, 0, &[0; 4], true)];
    for refusal in [REFUSED, TOLERATED] {
        assert_eq!(actual(sent(&SYNC_PRODUCER, &rows, refusal).0).as_deref(), Some("bit 30 of 1005h can't be set"));
    }
    assert!(matches!(sent(&SYNC_PRODUCER, &rows, WRONG).0, Err(Stop::Breach(_))));
    let (met, log) = sent(&SYNC_PRODUCER, &rows, &[]);
    let written: Vec<&String> = log.iter().filter(|request| request.starts_with("63F#23051000")).collect();
    assert_eq!((met, written.len()), (Ok(()), 3), "its own value, with the bit, and its own again");
    assert_eq!((written[1].as_str(), written[2].as_str()), ("63F#2305100080000040", "63F#2305100080000000"));
}

/// The missing object is named as far as it is known: a timer only if there is a PDO that could have it.
#[test]
fn what_is_lacking_is_named() {
    assert_eq!(unmet(&EVENT_TIMER, &[]).as_deref(), Some("the device has no 1800h:01"));
    assert_eq!(unmet(&EVENT_TIMER, &[row(0x1800, 1, &[0; 4], true)]).as_deref(), Some("the device has no 1800h:05"));
    assert_eq!(unmet(&NAME, &[]).as_deref(), Some("the device has no 1008h, 1009h or 100Ah"));
    assert_eq!(unmet(&EMPTY_VALUE, &[]).as_deref(), Some("no object that was found is an empty string"));
    let application = "no application object that the tester knows can be written without consequence";
    assert_eq!(unmet(&APPLICATION_PARAMETER, &[]).as_deref(), Some(application));
    assert_eq!(unmet(&APPLICATION_PARAMETER, &[row(0x6402, 0, &[0; 4], true)]), None);
    let empty = described(&[("2000", "DataType=0x0009\nAccessType=ro")]);
    assert_eq!(asked(&EMPTY_VALUE, |_: &Frame| Vec::new(), &empty, &Options::default()), Ok(()));
}
