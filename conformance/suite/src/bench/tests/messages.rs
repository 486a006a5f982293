//! SDO transfers, single messages, and the objects that serve a case.

#![cfg(test)]

use super::super::objects::NAMES;
use super::super::sdo::{DEVICE_TYPE, number};
use super::super::traffic::{is_from, is_tpdo};
use super::on_device;
use crate::scripted::{frame, table, with_bench};
use crate::situation::Situation;
use crate::verdict::{Check, Stop};
use canvass_analyzer::wire::sdo::{AbortCode, Request, Response};
use canvass_analyzer::{Multiplexer, NodeId};
use canvass_bus::client::{Outcome, Violation};
use canvass_bus::observation::Observation;
use canvass_traces::{Duration, Frame};

const HEARTBEAT_TIME: Multiplexer = Multiplexer::new(0x1017, 0);

#[test]
fn transfers_say_what_they_were() {
    on_device(|bench| {
        let read = bench.upload(DEVICE_TYPE).unwrap();
        assert_eq!(
            (read.what.as_str(), read.multiplexer, read.responses.len()),
            ("upload of 1000h:00", DEVICE_TYPE, 1)
        );
        assert!(!read.is_silent() && read.abort().is_none());
        assert_eq!(read.clone().under("in stopped").what, "upload of 1000h:00 in stopped");
        let value = read.value().unwrap();
        assert_eq!((bench.read(DEVICE_TYPE), bench.read_number(DEVICE_TYPE)), (Ok(value.clone()), Ok(number(&value))));
        let written = bench.download(HEARTBEAT_TIME, &[0xE8, 3]).unwrap();
        assert_eq!((written.what.as_str(), written.outcome), ("download of 2 bytes to 1017h:00", Outcome::Downloaded));
        let written = bench.download_segmented(HEARTBEAT_TIME, &[0xE9, 3]).unwrap();
        assert_eq!((written.what.as_str(), written.responses.len()), ("segmented download of 2 bytes to 1017h:00", 2));
        assert_eq!(bench.read_number(HEARTBEAT_TIME), Ok(1_001));
        let refused = bench.download(DEVICE_TYPE, &[0]).unwrap();
        assert_eq!(refused.what, "download of 1 byte to 1000h:00");
        assert!(refused.abort().is_some() && refused.expect_confirmation().is_err());
        assert!(bench.write(DEVICE_TYPE, &[0; 4]).is_err_and(|stop| matches!(stop, Stop::Inconclusive(_))));
        // The bench puts the earlier value back, once.
        let remains = bench.finish();
        assert_eq!((remains.notes, bench.read_number(HEARTBEAT_TIME)), (Vec::new(), Ok(0)));
    });
    assert_eq!((number(&[]), number(&[1, 2]), number(&[1, 2, 3, 4, 5])), (0, 0x0201, 0x0403_0201));
}

#[test]
fn values_are_expected() {
    on_device(|bench| {
        bench.write(HEARTBEAT_TIME, &[0xE8, 3]).unwrap();
        bench.expect_value(HEARTBEAT_TIME, &[0xE8, 3], "it is kept").unwrap();
        bench.expect_unchanged(HEARTBEAT_TIME, &[0xE8, 3]).unwrap();
        bench.expect_served("after that").unwrap();
        assert_eq!(bench.take_breaches(None), []);
        bench.expect_unchanged(HEARTBEAT_TIME, &[0xE9, 3]).unwrap();
        let found = bench.take_breaches(None);
        assert_eq!((found.len(), found[0].subject), (1, HEARTBEAT_TIME.into()));
        assert_eq!(
            (found[0].duty(), found[0].found_text()),
            ("1017h:00 keeps its value".to_owned(), "E8 03".to_owned())
        );
        assert!(found[0].seen.is_some());
        assert!(bench.expect_value(Multiplexer::new(0x5FFF, 0), &[0], "x").is_err());
    });
}

/// The client aborts a transfer with a silent server, and one with a server that breaks the protocol.
#[test]
fn a_transfer_that_fails_is_aborted() {
    const ROWS: &[(&str, &str)] =
        &[("63F#4001100000000000", "5BF#6001100000000000"), ("63F#4002100000000000", "5BF#43")];
    with_bench(table(ROWS), |bench| {
        let sent = |bench: &mut super::Bench<'_>| {
            bench.drain().unwrap();
            let texts: Vec<String> = bench.evidence().frames().map(|exhibit| exhibit.text.clone()).collect();
            texts.last().cloned().unwrap_or_default()
        };
        let silent = bench.upload(DEVICE_TYPE).unwrap();
        assert!(silent.is_silent() && silent.responses.is_empty());
        assert_eq!(sent(bench), "63F#8000100000000405");
        let wrong = bench.upload(Multiplexer::new(0x1001, 0)).unwrap();
        assert!(matches!(wrong.outcome, Outcome::Violated(_)) && wrong.responses.len() == 1);
        assert_eq!(sent(bench), "63F#8001100000000008");
        let short = bench.upload(Multiplexer::new(0x1002, 0)).unwrap();
        assert!(matches!(short.outcome, Outcome::Violated(Violation::Malformed(_))), "{short:?}");
        assert_eq!((bench.knowledge.served(), bench.answers()), (0, Ok(false)));
    });
    on_device(|bench| {
        bench.upload(DEVICE_TYPE).unwrap();
        bench.upload(Multiplexer::new(0x5FFF, 0)).unwrap();
        assert_eq!((bench.knowledge.served(), bench.answers()), (2, Ok(true)));
    });
}

#[test]
fn a_reply_is_judged() {
    const ROWS: &[(&str, &str)] = &[
        ("63F#4000100000000000", "5BF#4300100096010200"),
        ("63F#4001100000000000", "5BF#8001100000000206"),
        ("63F#4002100000000000", "5BF#43"),
    ];
    with_bench(table(ROWS), |bench| {
        let mut reply = |index| bench.exchange(&Request::upload(Multiplexer::new(index, 0)), "a read").unwrap();
        let (right, refused, short, none) = (reply(0x1000), reply(0x1001), reply(0x1002), reply(0x1003));
        assert!(right.actual().contains("43 00 10 00 96 01 02 00"), "{}", right.actual());
        assert_eq!(refused.actual(), "abort 0602 0000h object does not exist in the object dictionary");
        assert_eq!((short.actual(), none.actual()), ("an unreadable response (43)".to_owned(), "no answer".to_owned()));
        assert_eq!(refused.observation(), Observation::Abort(AbortCode::NO_OBJECT));
        assert!(matches!(right.observation(), Observation::Named(_)));
        assert!(matches!((short.observation(), none.observation()), (Observation::Frame(_), Observation::Silence)));
        assert_eq!(
            [&right, &refused, &short, &none].map(|reply| reply.abort()),
            [None, Some(AbortCode::NO_OBJECT), None, None]
        );
        assert_eq!((refused.refused(Situation::MissingObject), none.expect_silence()), (Ok(()), Ok(())));
        assert!(right.refused(Situation::MissingObject).is_err() && right.expect_silence().is_err());
        let is_value = |reply: &super::super::sdo::Reply| -> Check {
            reply.expect("the value", |response| matches!(response, Response::InitiateUpload { .. }))
        };
        assert_eq!((is_value(&right), is_value(&none).is_err(), is_value(&refused).is_err()), (Ok(()), true, true));
    });
}

/// Only frames that the device sends are reported as its own.
#[test]
fn frames_of_the_device_are_known() {
    let node = NodeId::new(63).unwrap();
    for (text, own, tpdo) in [
        ("0BF#00", true, false),
        ("1BF#00", true, true),
        ("2BF#00", true, true),
        ("3BF#00", true, true),
        ("4BF#00", true, true),
        ("5BF#00", true, false),
        ("73F#00", true, false),
        ("23F#00", false, false),
        ("63F#00", false, false),
        ("1BE#00", false, true),
        ("080#", false, false),
    ] {
        let frame = frame(text);
        assert_eq!((is_from(node, &frame), is_tpdo(frame.cob_id().unwrap())), (own, tpdo), "{text}");
    }
}

/// Objects that are written for a test have two values, and the report names the chosen object.
#[test]
fn scratch_objects_differ_from_what_they_hold() {
    on_device(|bench| {
        let found = bench.scratch_objects().unwrap();
        assert!(found.len() > 2, "{found:?}");
        for scratch in &found {
            assert_ne!(scratch.value, scratch.other, "{scratch:?}");
            assert_eq!(scratch.value.len(), scratch.other.len(), "{scratch:?}");
            assert_eq!(bench.read(scratch.multiplexer), Ok(scratch.value.clone()));
            bench.write(scratch.multiplexer, &scratch.other).unwrap();
        }
        let two = bench.scratch(&[2]).unwrap();
        assert_eq!(two.value.len(), 2);
        assert!(matches!(bench.scratch(&[3]), Err(Stop::NotApplicable(reason)) if reason.duty.contains("3 bytes")));
        let remains = bench.finish();
        assert_eq!(remains.uses.len(), 1);
        assert_eq!((remains.uses[0].multiplexer, remains.uses[0].purpose), (two.multiplexer, "written and read back"));
        for scratch in &found {
            assert_eq!(bench.read(scratch.multiplexer), Ok(scratch.value.clone()), "it is put back");
        }
    });
}

#[test]
fn long_objects_are_read_in_segments() {
    on_device(|bench| {
        let names = bench.names().unwrap();
        assert_eq!(names.iter().map(|name| name.0).collect::<Vec<_>>(), NAMES);
        let long = bench.long_object(5).unwrap().unwrap();
        assert!(bench.read(long).unwrap().len() >= 5);
        let texts = bench.long_objects(5, 2).unwrap();
        assert_eq!(texts.len(), 2);
        assert_ne!(texts[0], texts[1]);
        assert_eq!(bench.long_objects(5, 0), Ok(Vec::new()));
        assert_eq!(bench.long_object(100_000), Ok(None));
    });
}

/// The description decides without a request whether an object exists; without a description the device decides.
#[test]
fn objects_are_there_or_not() {
    on_device(|bench| {
        let missing = Multiplexer::new(0x5FFF, 0);
        assert_eq!((bench.has(DEVICE_TYPE), bench.has(missing)), (Ok(true), Ok(false)));
        assert_eq!((bench.can_write(DEVICE_TYPE), bench.can_write(HEARTBEAT_TIME)), (Ok(false), Ok(true)));
        assert_eq!((bench.described(DEVICE_TYPE), bench.described(missing)), (Some(true), Some(false)));
        assert_eq!(bench.evidence().frames().count(), 0, "no frame was needed");
        assert_eq!(bench.has_all(&[DEVICE_TYPE, HEARTBEAT_TIME]), Ok(Ok(())));
        assert_eq!(bench.has_all(&[DEVICE_TYPE, missing]), Ok(Err("the device has no 5FFFh:00".to_owned())));
        assert_eq!(bench.can_write_all(&[HEARTBEAT_TIME]), Ok(Ok(())));
        assert_eq!(bench.can_write_all(&[DEVICE_TYPE]), Ok(Err("1000h:00 can't be written".to_owned())));
        assert_eq!(bench.vacant_neighbour(), Some(bench.node().raw() + 1));
    });
    const ROWS: &[(&str, &str)] = &[
        ("63F#4000100000000000", "5BF#4300100096010200"),
        ("63F#2300100096010200", "5BF#8000100002000106"),
        ("63F#4001100000000000", "5BF#8001100000000206"),
        ("63F#4002100000000000", "5BF#8002100011000906"),
        ("63F#4003100000000000", "5BF#8003100001000106"),
        ("63F#4017100000000000", "5BF#4B17100000000000"),
        ("63F#2B17100000000000", "5BF#6017100000000000"),
    ];
    with_bench(table(ROWS), |bench| {
        let mut there = |index| bench.has(Multiplexer::new(index, 0)).unwrap();
        assert_eq!([0x1000, 0x1001, 0x1002, 0x1003, 0x1004].map(&mut there), [true, false, false, true, false]);
        let mut writable = |index| bench.can_write(Multiplexer::new(index, 0)).unwrap();
        assert_eq!([0x1000, 0x1001, 0x1003, 0x1017].map(&mut writable), [false, false, false, true]);
        assert_eq!(bench.described(DEVICE_TYPE), None);
    });
}

/// Notes and measurements of a case are in its report; the next case begins without them.
#[test]
fn notes_and_measurements_belong_to_their_case() {
    on_device(|bench| {
        bench.begin();
        bench.note("a note");
        bench.measure("an answer", Duration::from_millis(3));
        bench.count("frames", 7);
        bench.uses(DEVICE_TYPE, "read");
        bench.uses(DEVICE_TYPE, "read");
        bench.upload(DEVICE_TYPE).unwrap();
        let remains = bench.finish();
        assert_eq!((remains.notes, remains.uses.len()), (vec!["a note".to_owned()], 1));
        let told: Vec<String> = remains.measurements.iter().map(ToString::to_string).collect();
        assert_eq!(told, ["an answer: 3 ms", "frames: 7"]);
        assert_eq!(remains.evidence.frames().count(), 2);
        let remains = bench.finish();
        assert!(remains.notes.is_empty() && remains.measurements.is_empty() && remains.uses.is_empty());
        assert_eq!(remains.evidence.frames().count(), 0);
        bench.note("another");
        bench.begin();
        assert!(bench.finish().notes.is_empty());
    });
}

/// Errors that nobody provoked are noted.
#[test]
fn emergencies_are_noted_unless_they_are_expected() {
    let noted = |expected: bool| {
        let script = |request: &Frame| match request.to_string().as_str() {
            "123#01" => ["0BF#3081110000000000", "0BF#0000000000000000", "0BE#3081110000000000"]
                .map(|text| (Duration::from_millis(1), frame(text)))
                .to_vec(),
            _ => Vec::new(),
        };
        with_bench(script, |bench| {
            if expected {
                bench.expect_emergencies();
            }
            bench.send_bytes(0x123, &[1]).unwrap();
            bench.listen(Duration::from_millis(5)).unwrap();
            bench.finish().notes
        })
    };
    assert_eq!(noted(true), Vec::<String>::new());
    let notes = noted(false);
    assert!(notes.len() == 1 && notes[0].contains("8130h"), "{notes:?}");
}

/// Of a long upload of any kind, 256 answers are kept.
#[test]
fn of_a_long_upload_the_first_answers_are_kept() {
    let kept = |segments: usize| {
        let mut sent = 0;
        let script = move |request: &Frame| {
            let answer = match request.bytes()[0] {
                0x40 => "5BF#4000200000000000".to_owned(),
                command @ (0x60 | 0x70) => {
                    sent += 1;
                    let last = u8::from(sent == segments);
                    format!("5BF#{:02X}41424344454647", command & 0x10 | last)
                }
                _ => return Vec::new(),
            };
            vec![(Duration::from_micros(10), frame(&answer))]
        };
        with_bench(script, |bench| {
            let attempt = bench.upload(Multiplexer::new(0x2000, 0)).unwrap();
            let responses = attempt.responses.len();
            (attempt.value().unwrap().len(), responses)
        })
    };
    assert_eq!((kept(254), kept(255), kept(256)), ((254 * 7, 255), (255 * 7, 256), (256 * 7, 256)));
}

/// Both 1010h and 1011h may take as long as writing the memory does.
#[test]
fn restoring_has_the_patience_of_storing() {
    let took = |index: u16| {
        with_bench(table(&[]), |bench| {
            let begun = bench.now();
            assert!(bench.upload(Multiplexer::new(index, 1)).unwrap().is_silent());
            bench.now().since(begun)
        })
    };
    let [before, store, restore, after] = [0x100F, 0x1010, 0x1011, 0x1012].map(took);
    let (usual, long) = (Duration::from_secs(1), Duration::from_secs(10));
    assert_eq!((before, store, restore, after), (usual, long, long, usual));
}

/// For a message that must not be answered the wait is the time of silence, for others the response time.
#[test]
fn a_message_is_waited_for_by_what_it_is() {
    with_bench(table(&[]), |bench| {
        let request = Request::upload(DEVICE_TYPE);
        let mut took = |unanswered: bool| {
            let begun = bench.now();
            let reply = match unanswered {
                true => bench.send_unanswered(&request, "an abort"),
                false => bench.exchange(&request, "a read"),
            };
            assert_eq!(reply.unwrap().observation(), Observation::Silence);
            bench.now().since(begun)
        };
        assert_eq!((took(true), took(false)), (Duration::from_millis(200), Duration::from_secs(1)));
    });
}

/// Only frames of others since the given time count as heard.
#[test]
fn what_was_heard_is_looked_up() {
    let script = |request: &Frame| match request.to_string().as_str() {
        "123#" => [10, 20, 30].map(|ms| (Duration::from_millis(ms), frame(&format!("1BF#{ms:02X}")))).to_vec(),
        _ => Vec::new(),
    };
    with_bench(script, |bench| {
        bench.send_bytes(0x123, &[]).unwrap();
        bench.listen(Duration::from_millis(40)).unwrap();
        let since = |ms: u64| bench.heard_since(canvass_traces::Timestamp::ZERO + Duration::from_millis(ms)).len();
        assert_eq!([0, 10, 11, 20, 30, 31].map(since), [3, 3, 2, 2, 1, 0]);
    });
}

/// A device that was given another node-ID is not another participant of the bus.
#[test]
fn traffic_with_a_node_id_that_was_given_is_the_devices_own() {
    let foreign = |given: bool, text: &'static str| {
        let script = move |_: &Frame| vec![(Duration::from_millis(1), frame(text))];
        with_bench(script, |bench| {
            if given {
                bench.gives_node_id(5);
            }
            bench.send_bytes(0x123, &[]).unwrap();
            bench.listen(Duration::from_millis(5)).unwrap();
            bench.traffic.clients.foreign().loudest().is_some()
        })
    };
    assert_eq!((foreign(false, "185#00"), foreign(true, "185#00"), foreign(true, "186#00")), (true, false, true));
    assert!(foreign(true, "205#00"), "an RPDO of it comes from others");
    assert_eq!((foreign(false, "1BF#00"), foreign(true, "1BF#00")), (false, false));
}
