//! Changes of a run are written down and put back.

#![cfg(test)]

use super::super::sdo::DEVICE_TYPE;
use super::super::{Bench, Options, dictionary, interrupted};
use super::{Live, on_device, with};
use crate::comparison::Nature;
use crate::scripted::{Row, ScriptedBus, described, dictionary, frame, table, with_bench, with_target};
use canvass_analyzer::{Multiplexer, NodeId};
use canvass_bus::Bus;
use canvass_traces::{Duration, Frame, Record};
use std::cell::Cell;
use std::rc::Rc;

fn row(index: u16, sub: u8, value: &[u8]) -> Row {
    ((index, sub), value.to_vec(), true)
}

/// If a device has no description, the usual objects are read. If sub-index 0 is one byte, it gives the number of
/// further entries.
#[test]
fn an_undescribed_dictionary_is_looked_for() {
    let rows = vec![
        row(0x1000, 0, &[0x91, 1, 0, 0]),
        row(0x1005, 0, &[2, 0, 0, 0]),
        row(0x1005, 1, &[9]),
        row(0x1018, 0, &[2]),
        row(0x1018, 1, &[0x13, 0, 0, 0]),
        row(0x1018, 2, &[7, 0, 0, 0]),
        row(0x1018, 3, &[8, 0, 0, 0]),
        row(0x1A03, 0, &[1]),
        row(0x1A03, 1, &[8, 0, 4, 0x60]),
        row(0x1A04, 0, &[0]),
        row(0x6004, 0, &[1, 0, 0, 0]),
    ];
    let found = with_bench(dictionary(rows), dictionary::dump);
    let found: Vec<String> = found.into_iter().map(|(at, _)| at.to_string()).collect();
    let expected =
        ["1000h:00", "1005h:00", "1018h:00", "1018h:01", "1018h:02", "1A03h:00", "1A03h:01"].map(str::to_owned);
    assert_eq!(found, expected);
}

/// Objects in the description are read, unless reading has an effect, and values that differ afterwards are written
/// back.
#[test]
fn a_dictionary_is_put_back() {
    let heartbeat_time = Multiplexer::new(0x1017, 0);
    on_device(|bench| {
        let before = dictionary::dump(bench);
        assert!(before.iter().any(|(at, _)| *at == heartbeat_time) && before.iter().any(|(at, _)| *at == DEVICE_TYPE));
        let untouched = dictionary::put_back_dictionary(bench, "sim:test", &before);
        assert!(untouched.is_as_found() && untouched.is_complete && untouched.commands.is_empty(), "{untouched:?}");
        assert_eq!(untouched.objects, before.len());
        // The write counts as a write of somebody else: the bench keeps no earlier value.
        bench.write(heartbeat_time, &[0xE8, 3]).unwrap();
        bench.changes.take();
        let back = dictionary::put_back_dictionary(bench, "sim:test", &before);
        assert!(back.is_as_found(), "{back:?}");
        assert_eq!(bench.read_number(heartbeat_time), Ok(0));
    });
}

/// A journal stays until everything is put back.
#[test]
fn a_journal_is_kept_where_something_is_left() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("journal");
    let options = Options { journal: Some(path.clone()), ..Options::default() };
    with(&options, |bench| {
        assert_eq!(bench.changes.end_journal(false), None, "there is none");
        interrupted::begin_journal(bench, "sim:test", false, &[]).unwrap();
        assert!(path.exists());
        let told = bench.changes.end_journal(false).unwrap();
        assert_eq!(told, format!("{} lists what could not be restored", path.display()));
        assert!(path.exists());
        assert!(interrupted::begin_journal(bench, "sim:test", false, &[]).is_err(), "it is not written over");
        std::fs::remove_file(&path).unwrap();
        interrupted::begin_journal(bench, "sim:test", false, &[]).unwrap();
        assert_eq!((bench.changes.end_journal(true), path.exists()), (None, false));
    });
}

/// The lower eleven bits of 1005h are the CAN-ID of SYNC.
#[test]
fn sync_is_at_its_can_id() {
    for (value, id) in [([0x81, 0, 0, 0x40], 0x81), ([0xFF, 0xF7, 0, 0], 0x7FF), ([0x80, 0, 0, 0], 0x80)] {
        assert_eq!(with_bench(dictionary(vec![row(0x1005, 0, &value)]), |bench| bench.sync_id()), Ok(id));
    }
    assert_eq!(with_bench(dictionary(Vec::new()), |bench| bench.sync_id()), Ok(0x80));
}

/// Other nodes on the bus are looked for once.
#[test]
fn others_are_looked_for_once() {
    const ROWS: &[(&str, &str)] =
        &[("605#4000100000000000", "585#4300100096010200"), ("67F#4000100000000000", "5FF#8000100000000206")];
    with_bench(table(ROWS), |bench| {
        bench.look_for_others().unwrap();
        let asked = bench.evidence().frames().count();
        let others: Vec<u8> = bench.others().iter().map(|node| node.raw()).collect();
        assert_eq!((others, asked), (vec![5, 127], 126 + 2));
        bench.look_for_others().unwrap();
        assert_eq!(bench.evidence().frames().count(), asked);
        assert!(bench.is_vacant(6) && !bench.is_vacant(5) && !bench.is_vacant(0) && !bench.is_vacant(128));
        bench.gives_node_id(5);
        assert!(bench.is_vacant(5) && bench.others().contains(&NodeId::new(127).unwrap()));
    });
}

/// At most sixteen entries of an object without description are read, and none after an absent one.
#[test]
fn an_undescribed_object_is_read_up_to_a_limit() {
    let found = |highest: u8, last: u8| {
        let mut rows = vec![row(0x1018, 0, &[highest])];
        rows.extend((1..=last).map(|sub| row(0x1018, sub, &[sub])));
        let found = with_bench(dictionary(rows), dictionary::dump);
        found.last().map(|(at, _)| at.sub.0)
    };
    assert_eq!((found(16, 20), found(17, 20), found(255, 20)), (Some(16), Some(16), Some(16)));
    assert_eq!((found(255, 4), found(3, 20), found(0, 20)), (Some(4), Some(3), Some(0)));
}

/// On a live bus, reading ends early if a device answers no object, or answers nonsense; an abort is an answer, too.
#[test]
fn a_live_device_that_answers_nothing_is_not_read_to_its_end() {
    let sections: Vec<(String, &str)> = (0..45).map(|n| (format!("{:04X}", 0x2000 + n), "DataType=0x0005")).collect();
    let sections: Vec<(&str, &str)> = sections.iter().map(|(name, lines)| (name.as_str(), *lines)).collect();
    let target = described(&sections);
    // The number of objects that are read if the requests with these numbers get this answer.
    let asked = |answered: &'static [u8], answer: &'static str, live: bool| {
        let count: Rc<Cell<u32>> = Rc::default();
        let counted = Rc::clone(&count);
        let script = move |request: &Frame| match request.bytes() {
            [0x40, number, 0x20, ..] => {
                counted.set(counted.get() + 1);
                let answer = answer.replace("xx", &format!("{number:02X}"));
                let answers = answered.contains(&number).then(|| (Duration::from_millis(1), frame(&answer)));
                answers.into_iter().collect()
            }
            _ => Vec::new(),
        };
        let bus = ScriptedBus::new(script);
        let mut bus: Box<dyn Bus> = if live { Box::new(Live(bus)) } else { Box::new(bus) };
        let (options, cancel) = (Options::default(), std::sync::atomic::AtomicBool::new(false));
        let mut annotate = |record: &Record| record.frame.to_string();
        let mut bench = Bench::new(&mut *bus, &target, &options, &mut annotate, &cancel);
        let values = dictionary::dump(&mut bench).len();
        (count.get(), values)
    };
    assert_eq!((asked(&[], "", true), asked(&[], "", false)), ((20, 0), (45, 0)));
    assert_eq!(asked(&[19], "5BF#4Fxx200007000000", true), (40, 1));
    assert_eq!(asked(&[19], "5BF#80xx200000000206", true), (40, 0), "an abort is an answer");
    assert_eq!(asked(&[19], "5BF#60xx200000000000", true), (20, 0), "a confirmation of a write is none");
    assert_eq!(asked(&[20], "5BF#4Fxx200007000000", true), (20, 0), "it is too late");
    assert_eq!(asked(&[19, 39], "5BF#4Fxx200007000000", true), (45, 2));
}

/// After the run a device may be starting: it is asked three times, ten seconds apart, before it counts as lost.
#[test]
fn a_device_that_starts_after_the_run_is_waited_for() {
    let before = vec![(DEVICE_TYPE, vec![0x91, 1, 0, 0])];
    let compared = |silent: u32| {
        let (mut left, mut inner) = (silent, dictionary(vec![row(0x1000, 0, &[0x91, 1, 0, 0])]));
        let script = move |request: &Frame| {
            let is_asked = request.to_string() == "63F#4000100000000000";
            if left > 0 {
                left -= u32::from(is_asked);
                return Vec::new();
            }
            inner(request)
        };
        with_bench(script, |bench| {
            let comparison = dictionary::put_back_dictionary(bench, "sim:test", &before);
            assert_eq!((comparison.objects, comparison.changes.len()), (1, 0));
            (comparison.is_complete, bench.now().nanos() / 1_000_000_000)
        })
    };
    assert_eq!((compared(0), compared(1), compared(2)), ((true, 0), (true, 11), (true, 22)));
    assert_eq!(compared(3), (false, 33));
}

/// Values that appear, disappear, or change between readings are reported with both values, in the order of the
/// dictionary.
#[test]
fn what_is_otherwise_after_the_run_is_told() {
    let target = described(&[
        ("1000", "DataType=0x0007\nAccessType=ro"),
        ("2000", "DataType=0x0005\nAccessType=const"),
        ("2001", "DataType=0x0005"),
        ("2002", "DataType=0x0005"),
    ]);
    let before: Vec<(Multiplexer, Vec<u8>)> = [(0x1000, vec![0x91, 1, 0, 0]), (0x2001, vec![7]), (0x2002, vec![1])]
        .map(|(index, value)| (Multiplexer::new(index, 0), value))
        .to_vec();
    let mut count = 1;
    let mut inner = dictionary(vec![
        row(0x1000, 0, &[0x91, 1, 0, 0]),
        ((0x2000, 0), vec![3], false),
        ((0x2002, 0), vec![1], false),
    ]);
    // 2002h counts its reads, although the description calls it writable.
    let script = move |request: &Frame| {
        let mut answers = inner(request);
        if request.to_string().starts_with("63F#40022000") {
            count += 1;
            answers = vec![(Duration::from_millis(1), frame(&format!("5BF#4F022000{count:02X}000000")))];
        }
        answers
    };
    let comparison = with_target(script, &target, &Options::default(), |bench| {
        dictionary::put_back_dictionary(bench, "can0", &before)
    });
    let told: Vec<_> = comparison
        .changes
        .iter()
        .map(|change| (change.multiplexer.index.0, change.nature, change.before.is_some(), change.after.is_some()))
        .collect();
    assert_eq!(
        told,
        [
            (0x2000, Nature::Constant, false, true),
            (0x2001, Nature::Setting, true, false),
            (0x2002, Nature::Own, true, true)
        ]
    );
    assert_eq!((comparison.objects, comparison.is_complete, comparison.is_as_found()), (4, true, false));
    assert_eq!(comparison.left().count(), 2);
    assert_eq!(comparison.commands, ["canvass sdo write can0 63 2001:00 07 --type bytes"]);
}
