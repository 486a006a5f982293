//! Each format keeps what it can hold of a recording with all kinds of frames, and every loss is reported.

use crate::command::{Folder, sample};
use crate::recording;
use crate::rows::{RecordContent, rows};
use canvass_traces::{Direction, Format, Loss};
use std::collections::BTreeSet;
use std::path::Path;

/// A written format, with its losses.
struct Kept {
    format: Format,
    /// The losses when [`recording::log`] is written.
    lost: &'static [Loss],
    /// The losses that only other recordings have; each of them has its own test below.
    lost_elsewhere: &'static [Loss],
    /// The row after writing and reading; `None` if the format can't hold the row.
    row: fn(RecordContent, &mut Numbers) -> Option<RecordContent>,
}

const TABLE: &[Kept] = &[
    Kept {
        format: Format::Candump,
        lost: &[],
        lost_elsewhere: &[Loss::ChannelName, Loss::TimeZone],
        row: |row, _| Some(row),
    },
    Kept {
        format: Format::Pcapng,
        lost: &[],
        lost_elsewhere: &[Loss::UnknownDate, Loss::TimeZone],
        row: |row, _| Some(row),
    },
    Kept {
        format: Format::Pcap,
        lost: &[Loss::ChannelName, Loss::Direction],
        lost_elsewhere: &[Loss::Date, Loss::UnknownDate, Loss::TimeZone, Loss::Comment],
        row: |row, _| Some(RecordContent { channel: "can0".into(), direction: Direction::Unknown, ..row }),
    },
    Kept {
        format: Format::Mcap,
        lost: &[Loss::Frame, Loss::Direction, Loss::FdFlags, Loss::RawDlc],
        lost_elsewhere: &[Loss::UnknownDate, Loss::TimeZone],
        row: |row, _| {
            let flags = row.flags & 4;
            no_xl(RecordContent { direction: Direction::Unknown, flags, ..no_raw_dlc(row) })
        },
    },
    Kept {
        format: Format::Asc,
        lost: &[Loss::Frame, Loss::ChannelName, Loss::Direction, Loss::TimeZone, Loss::ErrorDetail],
        lost_elsewhere: &[Loss::TimeResolution],
        row: |row, numbers| {
            let mut row = numbered(no_error_detail(no_xl(row)?), numbers);
            row.direction = match row.direction {
                _ if row.is_error => Direction::Unknown,
                Direction::Unknown => Direction::Rx,
                known => known,
            };
            Some(row)
        },
    },
    Kept {
        format: Format::Blf,
        lost: &[Loss::Frame, Loss::ChannelName, Loss::Direction, Loss::TimeZone, Loss::ErrorDetail],
        lost_elsewhere: &[Loss::TimeResolution, Loss::Comment],
        row: |row, numbers| {
            let row = if row.is_error && row.id == 0 { no_error_detail(row) } else { row };
            let mut row = numbered(no_xl(row)?, numbers);
            row.direction = match row.direction {
                _ if row.is_error => Direction::Unknown,
                Direction::Unknown => Direction::Rx,
                known => known,
            };
            Some(row)
        },
    },
    Kept {
        format: Format::Mf4,
        lost: &[Loss::Frame, Loss::ChannelName, Loss::Direction, Loss::ErrorDetail],
        lost_elsewhere: &[Loss::TimeResolution, Loss::UnknownDate, Loss::Comment],
        row: |row, numbers| {
            let row = numbered(no_error_detail(no_xl(row)?), numbers);
            let direction = if row.direction == Direction::Tx { Direction::Tx } else { Direction::Rx };
            Some(RecordContent { direction, ..row })
        },
    },
    Kept {
        format: Format::Trc,
        lost: &[
            Loss::Frame,
            Loss::ChannelName,
            Loss::Direction,
            Loss::TimeResolution,
            Loss::TimeZone,
            Loss::ErrorDetail,
        ],
        lost_elsewhere: &[],
        row: |row, numbers| {
            let row = numbered(no_error_detail(no_xl(row)?), numbers);
            let direction = if row.direction == Direction::Tx { Direction::Tx } else { Direction::Rx };
            Some(RecordContent { nanos: row.nanos / 1_000 * 1_000, direction, ..row })
        },
    },
    Kept {
        format: Format::PythonCanCsv,
        lost: &[Loss::Frame, Loss::ChannelName, Loss::Direction, Loss::FdFlags, Loss::RawDlc],
        lost_elsewhere: &[Loss::TimeZone, Loss::Comment],
        row: |row, _| {
            let flags = if row.flags & 4 != 0 && row.data.len() > 8 { 4 } else { 0 };
            no_xl(RecordContent { channel: "1".into(), direction: Direction::Unknown, flags, ..no_raw_dlc(row) })
        },
    },
];

/// The names of channels that became numbers, in the order of their first frames.
#[derive(Default)]
struct Numbers(Vec<String>);

fn numbered(row: RecordContent, Numbers(names): &mut Numbers) -> RecordContent {
    let at = names.iter().position(|name| *name == row.channel).unwrap_or_else(|| {
        names.push(row.channel.clone());
        names.len() - 1
    });
    RecordContent { channel: (at + 1).to_string(), ..row }
}

fn no_xl(row: RecordContent) -> Option<RecordContent> {
    row.xl.is_none().then_some(row)
}

fn no_raw_dlc(row: RecordContent) -> RecordContent {
    let dlc = if row.flags == 0 { row.dlc.min(8) } else { row.dlc };
    RecordContent { dlc, ..row }
}

/// Reduces an error frame to a bus error, with the error class of Linux.
fn no_error_detail(row: RecordContent) -> RecordContent {
    if row.is_error { RecordContent { id: 0x80, data: Vec::new(), dlc: 0, ..row } } else { row }
}

fn file(format: Format) -> String {
    format!("out.{}", format.extensions()[0])
}

/// The losses in lines of the form `canvass: FORMAT can't hold LOSS: …`.
fn losses_told(errors: &str, format: Format) -> Vec<&str> {
    let prefix = format!("canvass: {format} can't hold ");
    errors
        .lines()
        .map(|line| line.strip_prefix(&prefix).unwrap_or_else(|| panic!("{line}")).rsplit_once(": ").unwrap().0)
        .collect()
}

fn names(losses: &[Loss]) -> BTreeSet<&'static str> {
    losses.iter().map(|loss| loss.name()).collect()
}

#[test]
fn every_format_keeps_what_it_can_hold_and_tells_what_it_can_not() {
    let folder = Folder::new().with("all.log", recording::log());
    let all = rows(&folder.path("all.log"));
    assert_eq!(all.len(), recording::FRAMES);
    for kept in TABLE {
        let (out, mut numbers) = (file(kept.format), Numbers::default());
        let errors = folder.good(&format!("convert all.log {out}"));
        assert_eq!(BTreeSet::from_iter(losses_told(&errors, kept.format)), names(kept.lost), "{}", kept.format);
        let expected: Vec<RecordContent> = all.iter().filter_map(|row| (kept.row)(row.clone(), &mut numbers)).collect();
        same(&rows(&folder.path(&out)), &expected, kept.format);
    }
}

#[test]
fn what_a_format_gave_it_can_hold() {
    let folder = Folder::new().with("all.log", recording::log());
    for kept in TABLE {
        let out = file(kept.format);
        folder.good(&format!("convert all.log {out}"));
        let again = format!("again.{out}");
        assert_eq!(folder.good(&format!("convert {out} {again}")), "", "nothing is lost: {}", kept.format);
        let (before, after) = (rows(&folder.path(&out)), rows(&folder.path(&again)));
        assert!(before.len() >= 5_000);
        same(&after, &before, kept.format);
    }
}

fn same(found: &[RecordContent], expected: &[RecordContent], format: Format) {
    for (n, (found, expected)) in found.iter().zip(expected).enumerate() {
        assert_eq!(found, expected, "{format}, frame {}", n + 1);
    }
    assert_eq!(found.len(), expected.len(), "{format}");
}

#[test]
fn the_table_is_that_of_the_formats() {
    for format in Format::all() {
        let kept = TABLE.iter().find(|kept| kept.format == format);
        assert_eq!(kept.is_some(), format.is_written(), "{format}");
        let tested = kept.map(|kept| [kept.lost, kept.lost_elsewhere].concat()).unwrap_or_default();
        assert_eq!(BTreeSet::from_iter(tested), BTreeSet::from_iter(format.losses().iter().copied()), "{format}");
    }
}

/// The messages when this file is converted to this format.
fn told_of(folder: &Folder, file: &Path, format: Format) -> String {
    std::fs::copy(file, folder.path("in")).unwrap();
    folder.good(&format!("convert in --force --to {format} lost"))
}

#[test]
fn local_times_become_times_of_no_zone() {
    let folder = Folder::new();
    let local = sample("python-can.asc");
    for kept in TABLE.iter().filter(|kept| kept.lost_elsewhere.contains(&Loss::TimeZone)) {
        let errors = told_of(&folder, &local, kept.format);
        assert!(errors.contains(Loss::TimeZone.name()), "{}: {errors}", kept.format);
    }
    assert!(!told_of(&folder, &local, Format::Trc).contains(Loss::TimeZone.name()));
}

/// Captures of formats whose times may count from the start of the recording get dates in 1970 where the output format
/// needs dates. A message reports it.
#[test]
fn times_of_no_date_become_1970_aloud() {
    let trc = ";####\r\n;\r\n     1)     17535  00000701  1  05 \r\n";
    let folder = Folder::new()
        .with("z.log", "(000.000000) can0 701#05\n")
        .with("z.txt", " (000.000000)  can0  701   [1]  05\n")
        .with("none.txt", "  can0  701   [1]  05\n")
        .with("old.trc", trc)
        .with("relative.asc", "base hex  timestamps relative\n   0.100000 1  701             Rx   d 1 05\n");
    for kept in TABLE {
        let says = kept.lost_elsewhere.contains(&Loss::UnknownDate);
        for file in ["z.log", "z.txt", "none.txt", "old.trc", "relative.asc"] {
            let errors = told_of(&folder, &folder.path(file), kept.format);
            assert_eq!(errors.contains(Loss::UnknownDate.name()), says, "{file} to {}: {errors}", kept.format);
        }
    }
}

#[test]
fn names_that_are_no_words_are_lost_in_a_log() {
    let folder = Folder::new().with("a b", "(1.000000) can0 001#\n").with("c", "(2.000000) can0 001#\n");
    let mut command = folder.command("convert --to candump");
    let output = command.args(["a b", "c", "-"]).output().unwrap();
    let (_, out, errors) = crate::command::ended(&output);
    assert_eq!(out, "(001.000000) a_b:can0 001#\n(002.000000) c:can0 001#\n");
    assert_eq!(errors, "canvass: candump can't hold channel names: dropped from 1 frame\n");
}

#[test]
fn pcap_ends_in_2106() {
    let folder = Folder::new().with("in.log", "(4294967296.000000) can0 001#\n");
    assert_eq!(folder.good("convert in.log out.pcap"), "canvass: pcap can't hold the date: dropped from 1 frame\n");
}

#[test]
fn a_clock_before_the_start_is_lost_in_asc() {
    let log = "(1700000010.000000) can0 001# R\n(1700000000.000000) can0 001# R\n";
    let folder = Folder::new().with("in.log", log);
    assert!(folder.good("convert in.log out.asc").contains("asc can't hold digits of the time: dropped from 1 frame"));
}
