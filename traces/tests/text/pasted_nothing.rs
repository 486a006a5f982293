//! Texts that are no captures give no frames.

use crate::pasted::open_with;
use canvass_traces::*;
use proptest::prelude::*;
use std::path::{Path, PathBuf};

/// The frames that a text gives as pasted lines, even if it looks like another format.
fn frames(text: &[u8]) -> usize {
    let reader = Format::Pasted.open(Source::from_bytes(text), &ReadOptions::default());
    reader.filter(Result::is_ok).count()
}

const NOTHING: &[(&str, &str)] = &[
    ("prose", "The node answers on 585 and the master asks on 605.\nIt took 3 of 8 tries, at 10:00:00, in 2023.\n"),
    ("an invoice", "Pos 100 5 12 34\nPos 200 1 99 00\nTotal 605 2 10 20\n"),
    (
        "C",
        "static const uint8_t request[] = { 0x40, 0x00, 0x10, 0x00 };\nconst uint16_t ids[] = { 0x605, 0x585 };\n\
         send(0x605, 8, 0x40, 0x00, 0x10);\nif (x == 0x705) { y = 05; }\n  0x605, 0x08, 0x40, 0x00, 0x10,\n",
    ),
    (
        "hexdump -C",
        "00000000  7f 45 4c 46 02 01 01 00  00 00 00 00 00 00 00 00  |.ELF............|\n\
         00000010  03 00 3e 00 01 00 00 00                           |..>.....|\n00000018\n",
    ),
    (
        "xxd",
        "00000000: 7f45 4c46 0201 0100 0000 0000 0000 0000  .ELF............\n00000010: 0300 3e00 0100 0000  ..>.....\n",
    ),
    ("a dump of eight bytes a line", "0000: 40 00 10 00 00 00 00 00\n0008: 43 00 10 00 92 01 02 00\n0010: 05 06\n"),
    ("a dump with short addresses", "000 40 00 10 00 00 00 00 00\n008 43 00 10 00 92 01 02 00\n010 05 06\n"),
    ("measured values", "time,speed,temperature\n100,05,23\n200,06,24\n300,07,24\n"),
    ("numbers", "100 200 300\n605 12 13\n705 14 15\n"),
    ("a table of something else", "id,name,data\n605,pump,40\n705,fan,41\n"),
    ("addresses", "192.168.0.1 00:1B:44:11:3A:B7\n10.0.0.5 00:1B:44:11:3A:B8\n"),
    ("a log", "2024-01-01 12:00:00 INFO 605 requests in 8 s\n2024-01-01 12:00:01 INFO 585 requests in 8 s\n"),
    (
        "hashes",
        "605 4b825dc642cb6eb9a060e54bf8d69288fbee4904 a.txt\n585 83baae61804e65cc73a7201a7252750c76066a30 b.txt\n",
    ),
    ("issues", "Fixes #605, see 1234#5678 and abc#1122, PR#40\n"),
    ("a matrix", "1.0 2.0 3.0\n4.0 5.0 6.0\n"),
    ("a PNG in text", "\u{FFFD}PNG\n\u{1a}\n605 40\u{0}00\n"),
    (
        "JSON",
        "{\"id\": 1541, \"len\": 8, \"data\": [64, 0, 16, 0, 0, 0, 0, 0]},\n{\"id\": 1413, \"len\": 1, \"data\": [5]}\n",
    ),
    ("a letter behind a number", "605 r\nIn 605 remote nodes\n"),
    ("a number of remote nodes", "The plant has 605 4 r\n"),
    ("revisions", "r1234\nr1235 | bob\nt1230\n"),
    ("small numbers beside a byte", "a 100 2 10 aa,\n"),
    ("a resistor", "R 100 aA A\n"),
    (
        "an EDS",
        "[1018sub1]\nParameterName=Vendor-ID\nObjectType=0x7\nDataType=0x0007\nAccessType=ro\nDefaultValue=0x605\n",
    ),
];

#[test]
fn nothing_is_invented() {
    for (what, text) in NOTHING {
        assert_eq!(frames(text.as_bytes()), 0, "{what}");
        assert!(open_with(text, None).is_err(), "{what}");
    }
}

/// All files of a folder, without build results and hidden files.
fn files(folder: &Path, all: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).unwrap().filter_map(Result::ok) {
        let (path, name) = (entry.path(), entry.file_name().to_string_lossy().into_owned());
        if name.starts_with('.') || name == "target" || name == "node_modules" {
            continue;
        }
        if path.is_dir() {
            files(&path, all);
        } else {
            all.push(path);
        }
    }
}

/// Whether a word of the text is a frame in candump's notation.
fn has_frame(text: &[u8]) -> bool {
    let text = String::from_utf8_lossy(text);
    text.split(|c: char| c.is_whitespace() || "\"'(),".contains(c)).any(|word| parse_frame(word).is_ok())
}

/// Sources, descriptions of devices and configuration of this repository.
#[test]
fn files_that_are_no_captures_give_no_frames() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap();
    let mut all = Vec::new();
    files(root, &mut all);
    all.sort();
    let is_other = |path: &Path| {
        let endings =
            ["rs", "toml", "lock", "eds", "dcf", "xdd", "js", "ts", "css", "html", "svg", "py", "sh", "yml", "c", "h"];
        path.extension().and_then(|ending| ending.to_str()).is_some_and(|ending| endings.contains(&ending))
    };
    let read = |path: PathBuf| std::fs::read(&path).ok().map(|text| (path, text));
    let texts: Vec<_> = all.into_iter().filter(|path| is_other(path)).filter_map(read).collect();
    // Tests hold captures in their sources.
    let (captures, texts): (Vec<_>, Vec<_>) = texts.into_iter().partition(|(_, text)| has_frame(text));
    assert!(
        texts.len() >= 500 && captures.len() * 4 < texts.len(),
        "{} texts, {} captures",
        texts.len(),
        captures.len()
    );
    let invented: Vec<_> = texts
        .iter()
        .map(|(path, text)| (path, frames(text)))
        .filter(|(_, count)| *count > 0)
        .map(|(path, count)| format!("{}: {count}", path.display()))
        .collect();
    assert!(invented.is_empty(), "{}", invented.join("\n"));
}

proptest! {
    #[test]
    fn random_text_gives_no_frames(
        bytes in prop::collection::vec(any::<u8>(), 0..500),
        words in prop::collection::vec("[a-zA-Z]{1,9}|[1-9][0-9]{0,4}|[.,;:!?(){}=\\[\\]\"'-]", 0..100),
        lines in prop::collection::vec("[A-Z][a-z]{2,9} ([a-z]{1,9} ){1,9}[0-9]{1,4}( [a-z]{3,9}){0,4}", 0..20),
    ) {
        prop_assert_eq!(frames(&bytes), 0);
        prop_assert_eq!(frames(lines.join("\n").as_bytes()), 0);
        for line in words.chunks(9) {
            prop_assert_eq!(frames(line.join(" ").as_bytes()), 0, "{:?}", line);
        }
    }

    /// Hours or lines with the minutes of departures.
    #[test]
    fn timetables_give_no_frames(
        rows in prop::collection::vec((100..1000_u32, prop::collection::btree_set(1..60_u32, 2..9)), 1..8),
        word in "(Bus |Line )?",
    ) {
        let minutes = |minutes: &std::collections::BTreeSet<u32>| {
            minutes.iter().map(|minute| format!(" {minute:02}")).collect::<String>()
        };
        let text: String = rows.iter().map(|(line, at)| format!("{word}{line}{}\n", minutes(at))).collect();
        prop_assert_eq!(frames(text.as_bytes()), 0, "{}", text);
    }

    /// Lines of a dump with addresses of three digits or more.
    #[test]
    fn dumps_give_no_frames(
        bytes in prop::collection::vec(any::<u8>(), 16..200),
        (width, from, colon) in (1..=8_usize, 0x10..0x40_usize, any::<bool>()),
    ) {
        let line = |(at, bytes): (usize, &[u8])| {
            let address = from * 16 + at * width;
            format!("{address:03x}{} {}\n", if colon { ":" } else { "" }, hex::spaced(bytes))
        };
        let text: String = bytes.chunks(width).enumerate().map(line).collect();
        prop_assert_eq!(frames(text.as_bytes()), 0, "{}", text);
    }

    #[test]
    fn nothing_panics(text in "(?s)[0-9a-fA-FxXhtTrR#;:,.()\\[\\]{}'\"RxTDd \t\r\n<>|=-]{0,400}") {
        frames(text.as_bytes());
        let _ = open_with(&text, Some("time[ms],id,len,data"));
    }
}
