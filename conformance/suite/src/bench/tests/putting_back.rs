//! A device is left as it was found: values that differ are written back, and values that can't be put back are
//! reported.

#![cfg(test)]

use super::super::restore::STORE;
use super::super::state::HEARTBEAT_TIME;
use super::super::{Bench, Options, dictionary, interrupted, restore, rewrite};
use crate::comparison::{Change, Nature};
use crate::journal::Interrupted;
use crate::scripted::{Row, ScriptedBus, described, dictionary, frame, with_bench, with_target};
use crate::touch::Touch;
use crate::verdict::Judged;
use canvass_analyzer::dictionary::configuration::{Download, companions, ordered};
use canvass_analyzer::{Multiplexer, NodeId};
use canvass_bus::observation::Subject;
use canvass_traces::{Direction, Duration, Frame};
use std::cell::RefCell;
use std::collections::BTreeMap;
use std::rc::Rc;

const GUARD_TIME: Multiplexer = Multiplexer::new(0x100C, 0);

fn row(index: u16, sub: u8, value: &[u8]) -> Row {
    ((index, sub), value.to_vec(), true)
}

fn original(index: u16, sub: u8, value: &[u8]) -> Download {
    Download { at: Multiplexer::new(index, sub), value: value.to_vec() }
}

/// The tester's frames after the first `since` frames, in short: `1017:00=E803` for a write, `NMT 81 3F`.
fn sent(bench: &mut Bench<'_>, since: usize) -> Vec<String> {
    bench.uncancelled(|bench| bench.drain()).unwrap();
    let own = bench.evidence().frames().skip(since).filter(|exhibit| exhibit.record.direction == Direction::Tx);
    let told = own.filter_map(|exhibit| {
        let [command, low, high, sub, value @ ..] = exhibit.record.frame.bytes();
        match exhibit.record.frame.cob_id()? {
            0 => Some(format!("NMT {command:02X} {low:02X}")),
            _ if command & 0xE3 == 0x23 => {
                let bytes = 4 - usize::from(command >> 2 & 3);
                let value: String = value.iter().take(bytes).map(|byte| format!("{byte:02X}")).collect();
                Some(format!("{high:02X}{low:02X}:{sub:02X}={value}"))
            }
            _ => None,
        }
    });
    told.collect()
}

fn seen(bench: &mut Bench<'_>) -> usize {
    bench.uncancelled(|bench| bench.drain()).unwrap();
    bench.evidence().frames().count()
}

/// The reaction of a scripted device to writes.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Takes {
    All,
    /// Refuses writes, but has its values again after a reset.
    AfterReset,
    /// Refuses writes always.
    Nothing,
}

/// The values of a scripted device, shared with the test.
type Values = Rc<RefCell<BTreeMap<(u16, u8), Vec<u8>>>>;

/// A device with a device type and 1010h, with these values now, and with the values `default` after a reset.
fn device(values: &Values, default: &[Row], takes: Takes) -> impl FnMut(&Frame) -> Vec<(Duration, Frame)> + use<> {
    let (values, default) = (Rc::clone(values), default.to_vec());
    move |request| {
        let mut rows: Vec<Row> = vec![row(0x1000, 0, &[0x91, 1, 0, 0])];
        rows.extend(values.borrow().iter().map(|(at, value)| (*at, value.clone(), takes == Takes::All)));
        match request.data() {
            [0x81, 63] => {
                if takes == Takes::AfterReset {
                    values.borrow_mut().extend(default.iter().map(|(at, value, _)| (*at, value.clone())));
                }
                vec![(Duration::from_millis(1), frame("73F#00"))]
            }
            [command, low, high, sub, data @ ..] if command & 0xE3 == 0x23 && takes == Takes::All => {
                let at = (u16::from_le_bytes([*low, *high]), *sub);
                if let Some(value) = values.borrow_mut().get_mut(&at) {
                    *value = data[..4 - usize::from(command >> 2 & 3)].to_vec();
                }
                dictionary(rows)(request)
            }
            _ => dictionary(rows)(request),
        }
    }
}

fn values(rows: &[Row]) -> Values {
    Rc::new(RefCell::new(rows.iter().map(|(at, value, _)| (*at, value.clone())).collect()))
}

/// PDOs are off while they are changed (CiA 301, 7.5.2.37 and 7.5.2.38), as is an EMCY; SYNC is not produced then, and
/// TIME neither produced nor consumed.
#[test]
fn each_communication_object_is_off_while_it_is_written() {
    let written = |originals: &[Download]| -> Vec<String> {
        let text = |Download { at, value }: Download| format!("{at} {value:02X?}");
        ordered(originals, &[]).into_iter().map(text).collect()
    };
    let emcy = [original(0x1014, 0, &[0xBF, 0, 0, 0]), original(0x1015, 0, &[5, 0])];
    assert_eq!(written(&emcy), ["1014h:00 [BF, 00, 00, 80]", "1015h:00 [05, 00]", "1014h:00 [BF, 00, 00, 00]"]);
    let sync =
        [original(0x1019, 0, &[10]), original(0x1006, 0, &[1, 0, 0, 0]), original(0x1005, 0, &[0x80, 0, 0, 0x40])];
    assert_eq!(
        written(&sync),
        ["1005h:00 [80, 00, 00, 00]", "1006h:00 [01, 00, 00, 00]", "1019h:00 [0A]", "1005h:00 [80, 00, 00, 40]"]
    );
    assert_eq!(
        written(&[original(0x1012, 0, &[0, 1, 0, 0xC0])]),
        ["1012h:00 [00, 01, 00, 00]", "1012h:00 [00, 01, 00, C0]"]
    );
    // The first and the last PDO of each direction.
    for (communication, mapping) in [(0x1400, 0x1600), (0x15FF, 0x17FF), (0x1800, 0x1A00), (0x19FF, 0x1BFF)] {
        let pdo = [
            original(mapping, 1, &[8, 0, 1, 0x10]),
            original(mapping, 0, &[1]),
            original(communication, 1, &[0x81, 1, 0, 0]),
            original(communication, 2, &[1]),
        ];
        let order: Vec<(Multiplexer, u8)> =
            ordered(&pdo, &[]).into_iter().map(|Download { at, value }| (at, value.last().copied().unwrap())).collect();
        let [id, kind] = [1, 2].map(|sub| Multiplexer::new(communication, sub));
        let [count, entry] = [0, 1].map(|sub| Multiplexer::new(mapping, sub));
        assert_eq!(order, [(id, 0x80), (kind, 1), (count, 0), (entry, 0x10), (count, 1), (id, 0)]);
    }
    // Objects next to these ranges are ordinary objects.
    for index in [0x13FF, 0x1C00] {
        assert_eq!(ordered(&[original(index, 0, &[7]), original(index, 1, &[7])], &[]).len(), 2, "{index:04X}h");
    }
}

/// Objects of the same communication object are written together.
#[test]
fn an_object_has_its_companions() {
    let of = |index, sub| companions(Multiplexer::new(index, sub)).map(|at| at.map(|at| at.to_string()));
    let both = |first: &str, second: Option<&str>| [Some(first.to_owned()), second.map(str::to_owned)];
    assert_eq!(of(0x1A02, 3), both("1802h:01", Some("1A02h:00")));
    assert_eq!(of(0x17FF, 0), both("15FFh:01", Some("17FFh:00")));
    assert_eq!(of(0x1802, 5), both("1802h:01", None));
    assert_eq!(of(0x15FF, 1), both("15FFh:01", None));
    assert_eq!(of(0x1015, 0), both("1014h:00", None));
    assert_eq!((of(0x1006, 0), of(0x1019, 0)), (both("1005h:00", None), both("1005h:00", None)));
    for index in [0x1012, 0x1017, 0x13FF, 0x1C00, 0x6000] {
        assert_eq!(of(index, 0), [None, None], "{index:04X}h");
    }
}

/// Only values that differ are written; values that the device refuses are returned.
#[test]
fn what_differs_is_written_back() {
    let before =
        [row(0x1017, 0, &[0, 0]), row(0x100C, 0, &[5, 0]), row(0x1015, 0, &[1, 0]), row(0x1014, 0, &[0xBF, 0, 0, 0])];
    let originals: Vec<Download> = before.iter().map(|(at, value, _)| original(at.0, at.1, value)).collect();
    let now = values(&[
        row(0x1017, 0, &[0xE8, 3]),
        row(0x100C, 0, &[5, 0]),
        row(0x1015, 0, &[9, 0]),
        row(0x1014, 0, &[0xBF, 0, 0, 0]),
    ]);
    with_bench(device(&now, &[], Takes::All), |bench| {
        assert_eq!(rewrite::write_back(bench, &originals), []);
        let written = ["1014:00=BF000080", "1015:00=0100", "1014:00=BF000000", "1017:00=0000"];
        assert_eq!(sent(bench, 0), written, "100Ch has its value, and 1014h is off for 1015h");
        let since = seen(bench);
        assert_eq!(rewrite::write_back(bench, &originals), []);
        assert_eq!(sent(bench, since), Vec::<String>::new());
    });
    now.borrow_mut().insert((0x1017, 0), vec![1, 0]);
    let stuck = with_bench(device(&now, &[], Takes::Nothing), |bench| rewrite::write_back(bench, &originals));
    assert_eq!(stuck, originals[..1]);
    // An object that no longer exists does not have its value either.
    now.borrow_mut().remove(&(0x1017, 0));
    let stuck = with_bench(device(&now, &[], Takes::All), |bench| rewrite::write_back(bench, &originals));
    assert_eq!(stuck, originals[..1]);
}

/// A value that could not be written is back after a reset if it was not stored; otherwise it is reported, and tried
/// again after the next case.
#[test]
fn a_reset_brings_back_what_was_not_stored() {
    let before = [row(0x1017, 0, &[0, 0])];
    let restored = |takes| {
        let now = values(&[row(0x1017, 0, &[0xE8, 3])]);
        with_bench(device(&now, &before, takes), |bench| {
            bench.changes.keep(original(0x1017, 0, &[0, 0])).unwrap();
            bench.restore();
            let left = bench.changes.is_left_behind(Subject::from(HEARTBEAT_TIME));
            assert!(!bench.changes.is_left_behind(Subject::from(GUARD_TIME)));
            let resets = sent(bench, 0).iter().filter(|frame| *frame == "NMT 81 3F").count();
            (bench.log.notes.clone(), left, resets)
        })
    };
    assert_eq!(restored(Takes::All), (Vec::new(), false, 0));
    assert_eq!(restored(Takes::AfterReset), (Vec::new(), false, 1));
    assert_eq!(restored(Takes::Nothing), (vec!["1017h:00 could not be set back to 00 00".to_owned()], true, 1));
    let now = values(&[row(0x1017, 0, &[0xE8, 3])]);
    with_bench(device(&now, &[], Takes::Nothing), |bench| {
        bench.changes.keep(original(0x1017, 0, &[0, 0])).unwrap();
        assert_eq!(bench.finish().notes.len(), 1);
        bench.begin();
        // The next case changes the same object, which then does not hold the device's own value.
        bench.changes.keep(original(0x1017, 0, &[0xE8, 3])).unwrap();
        assert_eq!(bench.finish().notes, ["1017h:00 could not be set back to 00 00"]);
        now.borrow_mut().insert((0x1017, 0), vec![0, 0]);
        assert_eq!(bench.finish().notes, Vec::<String>::new());
        assert!(!bench.changes.is_left_behind(Subject::from(HEARTBEAT_TIME)));
    });
}

/// A stopped device answers no SDO: it is first brought to pre-operational.
#[test]
fn a_stopped_device_is_woken_before_values_are_written_back() {
    let woken = |stopped: bool| {
        let now = values(&[row(0x1017, 0, &[0xE8, 3])]);
        let (mut silent, mut inner) = (stopped, device(&now, &[], Takes::All));
        let script = move |request: &Frame| {
            silent &= request.data() != [0x80, 63];
            if silent { Vec::new() } else { inner(request) }
        };
        with_bench(script, |bench| {
            bench.changes.keep(original(0x1017, 0, &[0, 0])).unwrap();
            bench.restore();
            assert_eq!((bench.log.notes.clone(), bench.read_number(HEARTBEAT_TIME)), (Vec::new(), Ok(0)));
            sent(bench, 0)
        })
    };
    assert_eq!(woken(false), ["1017:00=0000"]);
    assert_eq!(woken(true), ["NMT 80 3F", "1017:00=0000"]);
    // If nothing was changed, nothing is sent.
    let now = values(&[]);
    assert_eq!(
        with_bench(device(&now, &[], Takes::All), |bench| {
            bench.restore();
            seen(bench)
        }),
        0
    );
}

/// Objects that trigger an action have no value to keep. If a case changes an object twice, only its first value is
/// kept.
#[test]
fn the_value_before_the_first_change_is_kept() {
    let now = values(&[
        row(0x1017, 0, &[0, 0]),
        row(0x1010, 1, &[1, 0, 0, 0]),
        row(0x1A00, 0, &[1]),
        row(0x1800, 1, &[1, 0, 0, 0]),
    ]);
    with_bench(device(&now, &[], Takes::All), |bench| {
        bench.write(HEARTBEAT_TIME, &[1, 0]).unwrap();
        bench.write(HEARTBEAT_TIME, &[2, 0]).unwrap();
        assert_eq!(bench.changes.originals(), [original(0x1017, 0, &[0, 0])]);
        bench.write(Multiplexer::new(0x1A00, 0), &[0]).unwrap();
        assert_eq!(bench.changes.originals()[1..], [original(0x1800, 1, &[1, 0, 0, 0]), original(0x1A00, 0, &[1])]);
        let since = seen(bench);
        for index in [0x1003, 0x1010, 0x1011, 0x1013, 0x6003, 0x6009] {
            bench.remember(Multiplexer::new(index, 1)).unwrap();
        }
        bench.remember(HEARTBEAT_TIME).unwrap();
        assert_eq!((seen(bench), bench.changes.originals().len()), (since, 3), "nothing is read for these");
    });
}

/// Bit 1 of 1010h:01 says that a device stores by itself (CiA 301, 7.5.2.13).
#[test]
fn a_device_may_store_by_itself() {
    for (value, by_itself) in [(0, false), (1, false), (2, true), (3, true), (4, false), (6, false)] {
        let found = with_bench(dictionary(vec![row(0x1010, 1, &[value, 0, 0, 0])]), |bench| bench.stores_by_itself());
        assert_eq!(found, Ok(by_itself), "{value}");
    }
    assert_eq!(with_bench(dictionary(Vec::new()), |bench| bench.stores_by_itself()), Ok(false));
}

fn rescue(bench: &mut Bench<'_>, stored: bool) -> Judged {
    bench.send_bytes(0x7E5, &[u8::from(stored)]).map(|_| ())
}

fn rescued(bench: &mut Bench<'_>) -> Vec<String> {
    bench.drain().unwrap();
    let frames = bench.evidence().frames().map(|exhibit| exhibit.text.clone());
    frames.filter(|text| text.starts_with("7E5#")).collect()
}

/// After a case that ended early its rescue runs, and learns whether the case has stored something.
#[test]
fn a_case_that_ended_early_is_rescued() {
    let asked = |stores: bool| {
        let now = values(&[row(0x1010, 1, &[1, 0, 0, 0])]);
        with_bench(device(&now, &[], Takes::All), |bench| {
            bench.begin();
            if stores {
                bench.download(STORE, b"save").unwrap();
            }
            bench.end_early(Some(rescue));
            rescued(bench)
        })
    };
    assert_eq!((asked(true), asked(false)), (vec!["7E5#01".to_owned()], vec!["7E5#00".to_owned()]));
}

fn interrupted(values: &[(Multiplexer, Vec<u8>)], more: &[(Multiplexer, Vec<u8>)]) -> Interrupted {
    Interrupted {
        bus: "can0".to_owned(),
        node: NodeId::new(63).unwrap(),
        device: String::new(),
        operational: false,
        values: values.to_vec(),
        memory: Vec::new(),
        zero_point: None,
        stored_zero_point: None,
        more: more.to_vec(),
        case: None,
        stored: false,
        begun: true,
    }
}

/// Changes of an interrupted run are put back according to its journal.
#[test]
fn an_interrupted_run_is_put_back() {
    let before = vec![(Multiplexer::new(0x1000, 0), vec![0x91, 1, 0, 0]), (HEARTBEAT_TIME, vec![0, 0])];
    let more = vec![(Multiplexer::new(0x2041, 0), vec![7])];
    let put_back = |run: &Interrupted, stores: bool, takes: Takes| {
        let now = values(&[row(0x1017, 0, &[0xE8, 3]), row(0x2041, 0, &[9])]);
        if stores {
            now.borrow_mut().insert((0x1010, 1), vec![1, 0, 0, 0]);
        }
        with_bench(device(&now, &[], takes), |bench| {
            let comparison = interrupted::put_back(bench, run, Some(rescue)).unwrap();
            let left: Vec<String> = comparison.left().map(|change| change.multiplexer.to_string()).collect();
            assert!(!bench.traffic.restoring && comparison.is_complete);
            (left, sent(bench, 0), rescued(bench))
        })
    };
    let both = ["1017:00=0000", "2041:00=07"].map(str::to_owned);
    let reset = ["NMT 81 3F".to_owned()];
    let of = |parts: &[&[String]]| parts.concat();
    let run = interrupted(&before, &more);
    let told = |stored: &str| vec![format!("7E5#{stored}")];
    assert_eq!(put_back(&run, true, Takes::All), (vec![], of(&[&both, &reset]), told("00")));
    let operational = Interrupted { operational: true, ..run.clone() };
    let start = ["NMT 01 3F".to_owned()];
    assert_eq!(put_back(&operational, true, Takes::All).1, of(&[&both, &reset, &start]));
    let stored = Interrupted { stored: true, ..run.clone() };
    let save = ["1010:01=73617665".to_owned()];
    // If the journal lacks the values that a start loaded, the values that were in use are stored.
    let memory = of(&[&reset, &both[..1], &save, &reset]);
    assert_eq!(put_back(&stored, true, Takes::All), (vec![], of(&[&memory, &both[1..], &reset]), told("01")));
    let memory = of(&[&reset, &both[..1], &reset]);
    assert_eq!(put_back(&stored, false, Takes::All).1, of(&[&memory, &both[1..], &reset]), "it can't store");
    let (left, ..) = put_back(&run, true, Takes::Nothing);
    assert_eq!(left, ["1017h:00", "2041h:00"]);
}

/// A device that does not answer is reset first; if it does not start either, it is absent.
#[test]
fn an_interrupted_run_is_put_back_after_a_reset_where_that_helps() {
    let run = interrupted(&[(Multiplexer::new(0x1000, 0), vec![0x91, 1, 0, 0]), (HEARTBEAT_TIME, vec![0, 0])], &[]);
    let reset_helps = |helps: bool| {
        let now = values(&[row(0x1017, 0, &[0xE8, 3])]);
        let (mut silent, mut inner) = (true, device(&now, &[], Takes::All));
        let script = move |request: &Frame| {
            silent &= !(helps && request.data() == [0x81, 63]);
            if silent { Vec::new() } else { inner(request) }
        };
        with_bench(script, |bench| interrupted::put_back(bench, &run, None).map(|found| found.is_as_found()))
    };
    assert_eq!((reset_helps(true), reset_helps(false)), (Some(true), None));
}

/// Values that cases could not put back are reported with both values, unless the dictionary shows them already.
#[test]
fn what_the_dictionary_does_not_show_is_told_too() {
    let now = values(&[row(0x2041, 0, &[9]), row(0x2042, 0, &[9])]);
    let left = |takes: Takes| {
        with_bench(device(&now, &[], takes), |bench| {
            bench.changes.leave(vec![original(0x2041, 0, &[7]), original(0x2042, 0, &[7])]);
            let known = dictionary::change(bench, Multiplexer::new(0x2041, 0), Some(vec![7]), Some(vec![9]));
            restore::left_behind(bench, &[known])
        })
    };
    let told = left(Takes::Nothing);
    assert_eq!(told.len(), 1);
    assert_eq!((told[0].multiplexer, told[0].nature), (Multiplexer::new(0x2042, 0), Nature::Setting));
    assert_eq!((told[0].before.as_deref(), told[0].after.as_deref()), (Some(&[7][..]), Some(&[9][..])));
    assert_eq!(left(Takes::All), [], "it is put back at last");
}

/// The commands that give a device its values again can be typed, in an order that the device accepts.
#[test]
fn commands_put_settings_back() {
    let before: Vec<(Multiplexer, Vec<u8>)> = [
        (0x1010, 1, vec![1, 0, 0, 0]),
        (0x1017, 0, vec![0, 0]),
        (0x1800, 1, vec![0xBF, 1, 0, 0]),
        (0x1A00, 0, vec![1]),
        (0x1A00, 1, vec![8, 0, 1, 0x10]),
        (0x2010, 0, vec![]),
    ]
    .map(|(index, sub, value)| (Multiplexer::new(index, sub), value))
    .to_vec();
    let setting = |index, sub, value: Option<&[u8]>| Change {
        multiplexer: Multiplexer::new(index, sub),
        name: None,
        data_type: None,
        nature: Nature::Setting,
        before: value.map(<[u8]>::to_vec),
        after: Some(vec![1]),
    };
    let short = |command: &String| command.replace("canvass sdo write can0 63 ", "").replace(" --type bytes", "");
    let now = values(&[row(0x1010, 1, &[1, 0, 0, 0])]);
    with_bench(device(&now, &[], Takes::All), |bench| {
        let commands = |bench: &Bench<'_>, changes: &[Change]| -> Vec<String> {
            restore::commands(bench, "can0", &before, changes, &[]).iter().map(short).collect()
        };
        let heartbeat = setting(0x1017, 0, Some(&[0, 0]));
        assert_eq!(
            restore::commands(bench, "can0", &before, std::slice::from_ref(&heartbeat), &[]),
            ["canvass sdo write can0 63 1017:00 0000 --type bytes"]
        );
        let text = setting(0x2010, 0, Some(&[]));
        assert_eq!(commands(bench, &[text]), ["2010:00 ''"]);
        // An entry of a mapping is accompanied by the count and the COB-ID.
        let entry = setting(0x1A00, 1, Some(&[8, 0, 1, 0x10]));
        let pdo = ["1800:01 BF010080", "1A00:00 00", "1A00:01 08000110", "1A00:00 01", "1800:01 BF010000"];
        assert_eq!(commands(bench, std::slice::from_ref(&entry)), pdo);
        let count = setting(0x1A00, 0, Some(&[1]));
        assert_eq!(commands(bench, &[entry, count]), pdo, "each once");
        // Values that the device sets itself, constants, and objects that were absent before, are not written.
        let own = Change { nature: Nature::Own, ..heartbeat.clone() };
        let constant = Change { nature: Nature::Constant, ..heartbeat.clone() };
        assert_eq!(commands(bench, &[own, constant, setting(0x2010, 0, None)]), Vec::<String>::new());
        assert_eq!(commands(bench, &[]), Vec::<String>::new());
        // Objects that act are not written: a preset, a store.
        let preset = setting(0x6003, 0, Some(&[0, 0, 0, 0]));
        assert_eq!(commands(bench, &[preset, setting(0x1010, 1, Some(&[1, 0, 0, 0]))]), Vec::<String>::new());
        // The memory comes first, starting with a reset; then the values in use that differ from the stored ones.
        bench.changes.baseline.stored = Some(vec![original(0x1017, 0, &[0xD0, 7])]);
        let stored = setting(0x1017, 0, Some(&[0xD0, 7]));
        let memory: Vec<String> = restore::commands(bench, "can0", &before, &[], &[stored]).iter().map(short).collect();
        let reset = "canvass nmt can0 reset-node 63";
        assert_eq!(memory, [reset, "1017:00 D007", "1010:01 73617665", "1017:00 0000"]);
        for (bus, typed) in [
            ("can0", "can0"),
            ("slcan:/dev/ttyACM0@500k", "slcan:/dev/ttyACM0@500k"),
            ("", "''"),
            ("a b", "'a b'"),
            ("it's", r"'it'\''s'"),
            ("a;b", "'a;b'"),
        ] {
            let command = restore::commands(bench, bus, &before, std::slice::from_ref(&heartbeat), &[]).remove(0);
            assert_eq!(command, format!("canvass sdo write {typed} 63 1017:00 0000 --type bytes"));
        }
    });
}

/// Every object has its nature, which decides whether a run must leave it as it was.
#[test]
fn a_change_is_of_a_setting_a_constant_or_the_devices_own() {
    let nature = |bench: &Bench<'_>, index| dictionary::change(bench, Multiplexer::new(index, 0), None, None).nature;
    // Without a description: objects that change on any device only when they are written.
    with_bench(dictionary(Vec::new()), |bench| {
        for index in [
            0x1005, 0x1006, 0x1007, 0x100C, 0x100D, 0x1012, 0x1014, 0x1015, 0x1016, 0x1017, 0x1019, 0x1029, 0x1200,
            0x1BFF,
        ] {
            assert_eq!(nature(bench, index), Nature::Setting, "{index:04X}h");
        }
        for index in [0x1000, 0x1008, 0x1009, 0x100A, 0x1018] {
            assert_eq!(nature(bench, index), Nature::Constant, "{index:04X}h");
        }
        for index in
            [0x1001, 0x1003, 0x1004, 0x100B, 0x1010, 0x1011, 0x1013, 0x101A, 0x1020, 0x11FF, 0x1C00, 0x2000, 0x6004]
        {
            assert_eq!(nature(bench, index), Nature::Own, "{index:04X}h");
        }
        let presets = [0x6003, 0x6009].map(|index| nature(bench, index));
        assert_eq!(presets, [Nature::Acting; 2], "they may be presets of some profile");
    });
    let target = described(&[
        ("1000", "DataType=0x0007\nAccessType=ro"),
        ("2000", "DataType=0x0005"),
        ("2001", "DataType=0x0005\nAccessType=ro"),
        ("2002", "DataType=0x0005\nAccessType=const"),
        ("6003", "DataType=0x0007"),
        ("6009", "DataType=0x0007\nAccessType=ro"),
    ]);
    with_target(dictionary(Vec::new()), &target, &Options::default(), |bench| {
        let found = [0x1000, 0x2000, 0x2001, 0x2002, 0x6003, 0x6009].map(|index| nature(bench, index));
        use Nature::{Acting, Constant, Own, Setting};
        assert_eq!(found, [Constant, Setting, Own, Constant, Acting, Own], "a preset acts, and is no setting");
        let change = dictionary::change(bench, Multiplexer::new(0x2000, 0), Some(vec![1]), None);
        assert_eq!((change.name.as_deref(), change.data_type.map(|data_type| data_type.0)), (Some("2000"), Some(5)));
        assert_eq!((change.before, change.after), (Some(vec![1]), None));
        // An object without description has the type that the standard gives it.
        let standard = dictionary::change(bench, HEARTBEAT_TIME, None, None);
        assert_eq!((standard.name, standard.data_type.map(|data_type| data_type.0)), (None, Some(6)));
    });
}

/// A bus failure while a device is put back is reported, and ends nothing else.
#[test]
fn a_bus_that_fails_is_no_reason_to_stop() {
    let mut bus =
        super::Failing::new(ScriptedBus::new(dictionary(vec![row(0x1000, 0, &[0; 4]), row(0x1017, 0, &[1, 0])])));
    let fails = bus.switch();
    super::on_bus(&mut bus, &Options::default(), |bench| {
        bench.write(HEARTBEAT_TIME, &[9, 0]).unwrap();
        fails.set(true);
        let notes = bench.finish().notes;
        assert!(notes.len() == 2 && notes[0].starts_with("not restored: the bus works"), "{notes:?}");
        assert_eq!(notes[1], "1017h:00 could not be set back to 01 00");
        fails.set(false);
        assert_eq!((bench.finish().notes, bench.read_number(HEARTBEAT_TIME)), (Vec::new(), Ok(1)));
    });
}

/// The journal names a case that may leave more than values, and records any store.
#[test]
fn the_journal_names_the_case_that_was_under_way() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("journal");
    let options = Options { journal: Some(path.clone()), ..Options::default() };
    let now = values(&[row(0x1010, 1, &[1, 0, 0, 0]), row(0x2041, 0, &[7]), row(0x1017, 0, &[0, 0])]);
    let target = super::Target::unknown(NodeId::new(63).unwrap());
    with_target(device(&now, &[], Takes::All), &target, &options, |bench| {
        let written = || Interrupted::read(&std::fs::read_to_string(&path).unwrap()).unwrap();
        interrupted::begin_journal(bench, "can0", true, &[(HEARTBEAT_TIME, vec![0, 0])]).unwrap();
        assert_eq!((written().operational, written().begun, written().node), (true, true, bench.node()));
        for touch in [Touch::NodeId, Touch::BitRate, Touch::Nvm, Touch::FactoryDefaults, Touch::Preset] {
            bench.changes.begin_case("301/a", &[Touch::OtherNodes, touch]).unwrap();
            assert_eq!(written().case.as_deref(), Some("301/a"), "{touch}");
            bench.finish();
            assert_eq!(written().case.as_deref(), Some("301/a"), "its memory may not be as it was");
            bench.changes.settle_journal();
            assert_eq!(written().case, None);
        }
        bench.changes.begin_case("301/b", &[Touch::OtherNodes]).unwrap();
        assert_eq!(written().case, None, "it leaves nothing behind");
        bench.write(Multiplexer::new(0x2041, 0), &[8]).unwrap();
        assert_eq!(written().more, [(Multiplexer::new(0x2041, 0), vec![7])]);
        bench.write(HEARTBEAT_TIME, &[8, 0]).unwrap();
        assert_eq!(written().more.len(), 1, "that one is in the dictionary");
        assert!(!written().stored);
        bench.changes.begin_case("301/c", &[Touch::Nvm]).unwrap();
        bench.download(STORE, b"save").unwrap();
        assert!(written().stored);
        bench.finish();
        bench.changes.settle_journal();
        assert!(!written().stored);
        // A store on another node is not one of this device, nor is a read of 1010h.
        bench.send_bytes(0x640, &[0x23, 0x10, 0x10, 1, 0x73, 0x61, 0x76, 0x65]).unwrap();
        bench.send_bytes(0x63F, &[0x40, 0x10, 0x10, 1, 0, 0, 0, 0]).unwrap();
        assert!(!written().stored);
    });
}
