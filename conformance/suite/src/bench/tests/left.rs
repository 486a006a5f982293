//! What a run writes down and puts back.

use super::super::Options;
use super::super::sdo::DEVICE_TYPE;
use super::{on_device, with};
use crate::scripted::{Row, dictionary, table, with_bench};
use canvass_analyzer::{Multiplexer, NodeId};

fn row(index: u16, sub: u8, value: &[u8]) -> Row {
    ((index, sub), value.to_vec(), true)
}

/// Of a device that nobody describes the usual objects are read: where sub-index 0 is one byte it says how many follow.
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
    let found = with_bench(dictionary(rows), |bench| bench.dump());
    let found: Vec<String> = found.into_iter().map(|(at, _)| at.to_string()).collect();
    let expected =
        ["1000h:00", "1005h:00", "1018h:00", "1018h:01", "1018h:02", "1A03h:00", "1A03h:01"].map(str::to_owned);
    assert_eq!(found, expected);
}

/// What is described is read, unless reading it does something, and what differs afterwards is written back.
#[test]
fn a_dictionary_is_put_back() {
    let heartbeat_time = Multiplexer::new(0x1017, 0);
    on_device(|bench| {
        let before = bench.dump();
        assert!(before.iter().any(|(at, _)| *at == heartbeat_time) && before.iter().any(|(at, _)| *at == DEVICE_TYPE));
        let untouched = bench.put_back_dictionary("sim:test", &before);
        assert!(untouched.is_as_found() && untouched.is_complete && untouched.commands.is_empty(), "{untouched:?}");
        assert_eq!(untouched.objects, before.len());
        // As by somebody else: the bench remembers nothing of it.
        bench.write(heartbeat_time, &[0xE8, 3]).unwrap();
        bench.changes.clear();
        let back = bench.put_back_dictionary("sim:test", &before);
        assert!(back.is_as_found(), "{back:?}");
        assert_eq!(bench.read_number(heartbeat_time), Ok(0));
    });
}

/// A journal stands until all is put back.
#[test]
fn a_journal_is_kept_where_something_is_left() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("journal");
    let options = Options { journal: Some(path.clone()), ..Options::default() };
    with(&options, |bench| {
        assert_eq!(bench.end_journal(false), None, "there is none");
        bench.begin_journal("sim:test", false, &[]).unwrap();
        assert!(path.exists());
        let told = bench.end_journal(false).unwrap();
        assert!(told.contains("canvass restore BUS --journal") && path.exists(), "{told}");
        assert!(bench.begin_journal("sim:test", false, &[]).is_err(), "it is not written over");
        std::fs::remove_file(&path).unwrap();
        bench.begin_journal("sim:test", false, &[]).unwrap();
        assert_eq!((bench.end_journal(true), path.exists()), (None, false));
    });
}

/// SYNC is where the lower eleven bits of 1005h say.
#[test]
fn sync_is_at_its_can_id() {
    for (value, id) in [([0x81, 0, 0, 0x40], 0x81), ([0xFF, 0xF7, 0, 0], 0x7FF), ([0x80, 0, 0, 0], 0x80)] {
        assert_eq!(with_bench(dictionary(vec![row(0x1005, 0, &value)]), |bench| bench.sync_id()), Ok(id));
    }
    assert_eq!(with_bench(dictionary(Vec::new()), |bench| bench.sync_id()), Ok(0x80));
}

/// Who else is on the bus is found out once.
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
