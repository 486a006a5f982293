//! The changes that `apply_fixes` makes in a description, and the parts that it keeps: comments, order, and everything
//! that the reader understands.

// `cfg(test)` changes nothing here, but tells clippy that a test may unwrap.
#![cfg(test)]

use canvass_analyzer::dictionary::check::{apply_fixes, check};
use canvass_analyzer::dictionary::rules;
use canvass_analyzer::dictionary::{DeviceDescription, Object};
use proptest::prelude::*;

#[path = "description_rules/overlay.rs"]
mod overlay;
use overlay::overlay;

const REFERENCE: &str = include_str!("../../conformance/device/models/reference-406.eds");
const PLAIN: &str = include_str!("eds/plain.eds");

fn fixed(text: &str) -> String {
    String::from_utf8(apply_fixes(text.as_bytes(), |_| true).unwrap().bytes).unwrap()
}

/// The text after one replacement and the fixes.
fn after(from: &str, to: &str) -> String {
    assert!(PLAIN.contains(from), "{from}");
    fixed(&PLAIN.replacen(from, to, 1))
}

#[test]
fn what_can_be_mended_becomes_what_it_was() {
    let base = fixed(PLAIN);
    let damages = [
        ("CreationDate=11-21-2026", "CreationDate=2026-11-21"),
        ("CreationTime=09:00AM", "CreationTime=9:00:12"),
        ("NrOfTXPDO=1", "NrOfTXPDO=0"),
        ("Lines=1", "Lines=7"),
        ("SupportedObjects=2", "SupportedObjects=9"),
        ("2=0x1001", "5=0x1001"),
        ("1=0x1000\n2=0x1001", "2=0x1001\n1=0x1000"),
        ("2=0x1001\n", "2=0x1001\n3=0x1000\n"),
        ("SubNumber=3", "SubNumber=5"),
        ("DefaultValue=5", "DefaultValue=5\nDefaultValue=5"),
        ("DefaultValue=$NODEID+0x180", "DefaultValue=0x180+$NODEID"),
        ("DefaultValue=$NODEID+0x180", "DefaultValue=$NodeID+180h"),
        ("DefaultValue=5", "DefaultValue=\"5\""),
        ("DefaultValue=5", "DefaultValue=5.0"),
        ("AccessType=rw\nDefaultValue=5", "AccessType=R/W\nDefaultValue=5"),
        ("LSS_Supported=0", "LSS_Supported=no"),
        ("[2000]", "[0x2000]"),
        ("[1800sub1]", "[1800sub01]"),
        ("[2000]", "[2000"),
    ];
    for (from, to) in damages {
        assert_eq!(after(from, to), base, "{to}");
    }
}

/// A line without a name is no field, so a problem of the section is not located there.
#[test]
fn the_line_that_is_mended_is_that_of_the_section() {
    let damaged = PLAIN.replacen("[2000]\n", "[0x2000]\n=5\n", 1);
    assert_eq!(fixed(&damaged), fixed(PLAIN).replacen("[2000]\n", "[2000]\n=5\n", 1));
}

#[test]
fn what_would_be_a_guess_stays() {
    for (from, to) in [
        ("CreationDate=11-21-2026", "CreationDate=01/02/2026"),
        ("DefaultValue=5", "DefaultValue=010"),
        ("DefaultValue=5", "DefaultValue=five"),
        // It is unknown whether the device has PDOs that the file does not describe.
        ("NrOfTXPDO=1", "NrOfTXPDO=4"),
        ("DefaultValue=5", "DefaultValue=5\nDefaultValue=6"),
        ("AccessType=rw\nDefaultValue=5", "AccessType=maybe\nDefaultValue=5"),
    ] {
        let damaged = PLAIN.replacen(from, to, 1);
        assert_eq!(fixed(&damaged), fixed(PLAIN).replacen(from, to, 1), "{to}");
    }
}

#[test]
fn lists_are_completed_and_comments_stay() {
    let text = PLAIN.replace("1=0x1000\n2=0x1001", "; the first\n1=0x1000\n; moved\n2=0x2000\n; the last");
    let text = text
        .replace("[ManufacturerObjects]\nSupportedObjects=1\n1=0x2000", "[ManufacturerObjects]\nSupportedObjects=0");
    let fixed = fixed(&text);
    assert!(fixed.contains("SupportedObjects=2\n; the first\n1=0x1000\n2=0x1001\n; moved\n; the last\n"), "{fixed}");
    assert!(fixed.contains("[ManufacturerObjects]\nSupportedObjects=1\n1=0x2000\n"), "{fixed}");
}

#[test]
fn missing_sections_are_added_and_the_character_set_is_changed() {
    let text = PLAIN.replace("[Comments]\nLines=1\nLine1=one\n", "");
    assert!(fixed(&text).ends_with("\n[Comments]\nLines=0\n"));
    // python-canopen reads no file that lacks one of the seven entries.
    let dummies = fixed(&PLAIN.replace("[DummyUsage]", "[Comments2]"));
    assert!((1..=7).all(|index| dummies.contains(&format!("\nDummy000{index}=0"))), "{dummies}");
    let utf_16: Vec<u8> = [0xFF, 0xFE].into_iter().chain(PLAIN.encode_utf16().flat_map(u16::to_le_bytes)).collect();
    assert_eq!(apply_fixes(&utf_16, |_| true).unwrap().bytes, fixed(PLAIN).into_bytes());
    let marked = [b"\xEF\xBB\xBF", PLAIN.as_bytes()].concat();
    assert_eq!(apply_fixes(&marked, |_| true).unwrap().bytes, fixed(PLAIN).into_bytes());
    // A second byte order mark is a character of the text, and the text after it is not lost.
    let twice = fixed(&format!("\u{FEFF}\u{FEFF}# a comment\n{PLAIN}"));
    assert!(twice.contains("; a comment\n[FileInfo]"), "{twice}");
    // The encoding Latin-1 stays, whatever else is fixed.
    let latin: Vec<u8> = PLAIN
        .replace("Lines=1", "Lines=3")
        .replace("one", "z?")
        .bytes()
        .map(|byte| if byte == b'?' { 0xE4 } else { byte })
        .collect();
    assert!(apply_fixes(&latin, |_| true).unwrap().bytes.windows(9).any(|part| part == b"Line1=z\xE4\n"));
}

#[test]
fn line_ends_become_one_kind() {
    let mixed = PLAIN.replacen('\n', "\r\n", 3);
    assert_eq!(fixed(&mixed), fixed(PLAIN));
    assert_eq!(fixed(&PLAIN.replace('\n', "\r")), fixed(PLAIN).replace('\n', "\r\n"));
}

#[test]
fn what_is_not_wanted_is_not_touched() {
    let damaged = PLAIN.replace("Lines=1", "Lines=3").replace("NrOfTXPDO=1", "NrOfTXPDO=0");
    let only = |id: &str| {
        let rule = rules::find(id).unwrap();
        String::from_utf8(apply_fixes(damaged.as_bytes(), |finding| finding.problem.rule == rule).unwrap().bytes)
            .unwrap()
    };
    assert_eq!(only("eds/file/comment-count"), damaged.replace("Lines=3", "Lines=1"));
    assert_eq!(only("eds/device/pdo-count"), damaged.replace("NrOfTXPDO=0", "NrOfTXPDO=1"));
}

/// The objects as the reader understands them, without their lines.
fn understood(bytes: &[u8]) -> Vec<Object> {
    let description = DeviceDescription::read(bytes).unwrap();
    let objects = description.dictionary.objects().iter().map(|object| {
        let mut same = Object::new(object.index.0, object.name.clone(), object.code);
        for entry in object.entries() {
            let mut entry = entry.clone();
            (entry.line, entry.section) = (0, None);
            same.insert(entry);
        }
        same
    });
    objects.collect()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    /// For examples of several rules at once with random damage: a second fix changes nothing, and the objects and all
    /// comments stay.
    #[test]
    fn fixing_is_idempotent_and_keeps_the_meaning(
        broken in prop::collection::vec(0..rules::all().filter(|rule| rule.id.starts_with("eds/")).count(), 1..6),
        cut in prop::collection::vec((0..3000_usize, "[ -~]{0,6}"), 0..3),
    ) {
        let all: Vec<_> = rules::all().filter(|rule| rule.id.starts_with("eds/")).collect();
        let mut text = REFERENCE.replace("[Comments]", "; kept\n[Comments]");
        for at in broken {
            text = overlay(&text, all[at].fails);
        }
        for (at, replacement) in cut {
            let range = at.min(text.len())..(at + 3).min(text.len());
            if text.is_char_boundary(range.start) && text.is_char_boundary(range.end) {
                text.replace_range(range, &replacement);
            }
        }
        if DeviceDescription::read(text.as_bytes()).is_err() {
            return Ok(());
        }
        let once = apply_fixes(text.as_bytes(), |_| true).unwrap().bytes;
        let twice = apply_fixes(&once, |_| true).unwrap();
        prop_assert_eq!(&twice.bytes, &once);
        prop_assert_eq!(understood(&once), understood(text.as_bytes()));
        let comments = |text: &str| text.lines().filter(|line| line.starts_with(';')).map(str::to_owned).collect::<Vec<_>>();
        let kept = comments(&String::from_utf8(once.clone()).unwrap());
        prop_assert!(comments(&text).iter().all(|comment| kept.contains(comment)));
        let left = check(&once, None).unwrap();
        prop_assert!(left.open().all(|finding| finding.fix.is_none()), "{:?}", left.open().find(|finding| finding.fix.is_some()));
    }
}
