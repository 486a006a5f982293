//! Merging several captures.

use canvass_traces::{Capture, Channels, Merge, Naming, ReadOptions, Reader, Source, TimeBase};
use proptest::prelude::*;

#[cfg(test)]
fn capture(name: &str, log: &str) -> Capture {
    Capture::from_source(name, Source::from_bytes(log), &ReadOptions::default()).unwrap()
}

/// The items of the merged captures, each as `SOURCE CHANNEL ID` or `SOURCE KIND`.
fn merged(captures: Vec<Capture>, naming: Naming) -> Vec<String> {
    let mut merge = Merge::new(captures, naming);
    let mut items = Vec::new();
    while let Some((source, item)) = merge.next() {
        items.push(match item {
            Ok(record) => {
                format!("{source} {} {:X}", merge.channels().name(record.channel), record.frame.id().raw())
            }
            Err(damage) => format!("{source} {}", damage.kind.name()),
        });
    }
    assert!(merge.next().is_none());
    items
}

#[test]
fn by_time_and_then_by_the_order_of_the_files() {
    let a = "(1.000000) can0 001#\n(2.000000) can1 002#\n(4.000000) can0 003#\n";
    let b = "(2.000000) can0 011#\n(2.000000) can0 012#\n(3.000000) can0 013#\n";
    assert_eq!(
        merged(vec![capture("x/a.log", a), capture("y/b.log", b)], Naming::BySource),
        ["0 a.log:can0 1", "0 a.log:can1 2", "1 b.log:can0 11", "1 b.log:can0 12", "1 b.log:can0 13", "0 a.log:can0 3"]
    );
    assert_eq!(
        merged(vec![capture("b.log", b), capture("a.log", a)], Naming::SameBus),
        ["1 can0 1", "0 can0 11", "0 can0 12", "1 can1 2", "0 can0 13", "1 can0 3"]
    );
}

#[test]
fn one_file_keeps_its_names() {
    assert_eq!(
        merged(vec![capture("a.log", "(1.0) can0 1#\n(1.000000) can0 001#\n")], Naming::BySource),
        ["0 malformed", "0 can0 1"]
    );
    assert!(merged(Vec::new(), Naming::BySource).is_empty());
}

#[test]
fn files_of_the_same_name_are_told_apart() {
    let log = "(1.000000) can0 001#\n";
    let captures = ["x/a.log", "y/a.log", "y/a.log", "b.log"].map(|name| capture(name, log));
    let mut merge = Merge::new(captures.into(), Naming::BySource);
    let mut own = Vec::new();
    while let Some((_, item)) = merge.next() {
        own.push(merge.own_name(item.unwrap().channel).to_owned());
    }
    let names: Vec<_> = merge.channels().names().collect();
    assert_eq!(names, ["x/a.log:can0", "y/a.log:can0", "y/a.log#2:can0", "b.log:can0"]);
    assert_eq!(own, ["can0"; 4]);
}

#[test]
fn a_source_that_steps_back_keeps_its_order() {
    let a = "(5.000000) can0 001#\n(1.000000) can0 002#\n(6.000000) can0 003#\n";
    let b = "(2.000000) can0 011#\n(5.500000) can0 012#\n";
    let ids = merged(vec![capture("a", a), capture("b", b)], Naming::SameBus);
    assert_eq!(ids, ["1 can0 11", "0 can0 1", "0 can0 2", "1 can0 12", "0 can0 3"]);
}

#[test]
fn damages_come_in_their_place() {
    let a = "(1.000000) can0 001#\nrubbish\n(3.000000) can0 003#\n(4.000000) can0 00";
    let b = "DROPCOUNT: dropped 7 CAN frames on 'can0' socket (total drops 7)\n(2.000000) can0 011#\n";
    let captures = vec![capture("a", a), capture("b", b)];
    assert_eq!(
        merged(captures, Naming::SameBus),
        ["1 dropped by the recorder", "0 can0 1", "0 malformed", "1 can0 11", "0 can0 3", "0 truncated"]
    );
}

#[test]
fn different_time_bases_are_noticed() {
    let mut merge = Merge::new(
        vec![capture("a", "(1700000000.000000) can0 001#\n"), capture("b", "(1.000000) can0 001#\n")],
        Naming::BySource,
    );
    assert_eq!(merge.by_ref().filter(|(_, item)| item.is_ok()).count(), 2);
    assert_eq!((merge.time_base(), merge.odd_source()), (TimeBase::Utc, Some(1)));
    assert_eq!(merge.sources().map(Reader::time_base).collect::<Vec<_>>(), [TimeBase::Utc, TimeBase::Start]);
}

#[test]
fn a_frame_is_given_before_the_next_is_waited_for() {
    struct OneLine(bool);
    impl std::io::Read for OneLine {
        fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
            assert!(!std::mem::replace(&mut self.0, true), "waits for the second line");
            let line = b"(1.000000) can0 001#\n";
            buffer[..line.len()].copy_from_slice(line);
            Ok(line.len())
        }
    }
    let live = || Capture::from_source("-", Source::new(OneLine(false)), &ReadOptions::default()).unwrap();
    assert!(Merge::new(vec![live()], Naming::BySource).next().is_some());
    let file = capture("a", "(2.000000) can0 001#\n");
    assert!(Merge::new(vec![live(), file], Naming::BySource).next().is_some());
}

proptest! {
    /// Whatever the files are, no item is lost and each file keeps its order; sorted files give a sorted result.
    #[test]
    fn nothing_gets_lost(files in prop::collection::vec(prop::collection::vec(0_u64..50, 1..30), 1..6), sort: bool) {
        let files: Vec<Vec<u64>> = files.into_iter().map(|mut times| {
            if sort { times.sort_unstable(); }
            times
        }).collect();
        let log = |times: &Vec<u64>| times.iter().map(|time| format!("({time}.000000) can0 001#\n")).collect::<String>();
        let captures = files.iter().map(|times| capture("f", &log(times))).collect();
        let items: Vec<(usize, u64)> = Merge::new(captures, Naming::BySource)
            .map(|(source, item)| (source, item.unwrap().timestamp.nanos() / 1_000_000_000))
            .collect();
        for (source, times) in files.iter().enumerate() {
            let own: Vec<u64> = items.iter().filter(|item| item.0 == source).map(|item| item.1).collect();
            prop_assert_eq!(&own, times);
        }
        if sort {
            prop_assert!(items.is_sorted_by_key(|&(source, time)| (time, source)));
        }
    }
}

#[test]
fn many_channels_take_bounded_memory() {
    let log: String = (0..5_000).map(|n| format!("(1.000000) c{n} 001#\n")).collect();
    let mut merge = Merge::new(vec![capture("a", &log), capture("b", &log)], Naming::BySource);
    assert_eq!(merge.by_ref().filter(|(_, item)| item.is_ok()).count(), 10_000);
    assert_eq!(merge.channels().len(), Channels::MAX);
}
