//! Every format shows the whole provenance, and neutralises control characters and markup in its texts.

use super::*;

use crate::document::junit::Suite;
use crate::document::{Document, Form, Report, Style};
use std::io::{self, Write};

const TEXT: Form = Form::Text(Style { color: false, width: None });

/// A report with only a provenance.
struct Alone<'a>(&'a Provenance);

impl Report for Alone<'_> {
    fn document(&self, depth: Depth) -> Document {
        let mut suite = Suite::new("alone");
        suite.add_properties(self.0.properties());
        Document { about: Some(self.0.section(depth, true)), suites: vec![suite], ..Document::default() }
    }

    fn json(&self, _: &mut dyn Write) -> io::Result<()> {
        Ok(())
    }
}

fn written(provenance: &Provenance, form: Form) -> String {
    let mut out = Vec::new();
    Alone(provenance).write(form, &mut out).unwrap();
    String::from_utf8(out).unwrap()
}

const HOSTILE: &str = "\x1b[2J<script>|`\u{202e}";

fn provenance() -> Provenance {
    let choice = |name: &str, value: &str, by| Choice {
        name: name.to_owned(),
        value: vec![value.to_owned()],
        default: vec!["5".to_owned()],
        by,
    };
    Provenance {
        date: Some(Date { rfc3339: "2026-11-22T14:00:00+01:00".to_owned(), zone: "Europe/Berlin".to_owned() }),
        host: Some(Host { name: "bench-3".to_owned(), system: "Linux 6.1".to_owned() }),
        bus: Some(BusUsed { address: "can0".to_owned(), adapter: "PCAN-USB".to_owned(), bit_rate: Some(83_333) }),
        devices: vec![(
            "node 63".to_owned(),
            DeviceIdentity {
                device_type: Some(0x0002_0196),
                identity: [Some(0x13), None, None, Some(7)],
                names: [Some(HOSTILE.to_owned()), None, Some("1.4".to_owned())],
            },
        )],
        seed: Some(7),
        files: vec![
            FileUsed { role: "waivers", path: "w.toml".to_owned(), content: Some((3, "abcdef".to_owned())) },
            FileUsed { role: "capture", path: "-".to_owned(), content: None },
        ],
        options: vec![choice("tolerance", "5", ChosenBy::Default), choice("repeat", "3", ChosenBy::CommandLine)],
        notes: vec![("tester".to_owned(), "Ann".to_owned()), ("hostile".to_owned(), HOSTILE.to_owned())],
    }
}

/// The texts that each format has to contain.
const TOLD: [&str; 13] = [
    VERSION,
    "2026-11-22T14:00:00+01:00",
    "Europe/Berlin",
    "bench-3",
    "PCAN-USB",
    "00020196h",
    "00000013h",
    "1.4",
    "abcdef",
    "w.toml",
    "tolerance",
    "repeat",
    "Ann",
];

#[test]
fn every_format_tells_all_of_it() {
    let provenance = provenance();
    let formats = [TEXT, Form::Markdown, Form::Html, Form::Junit].map(|form| written(&provenance, form));
    for format in &formats {
        for told in TOLD {
            assert!(format.contains(told), "{told} is missing in {format}");
        }
        assert!(!format.contains(['\x1b', '\u{202e}']), "{format}");
    }
    assert!(!formats[2].contains("<script>|") && !formats[1].contains("<script>"));
    assert!(formats[0].contains("repeat: 3 (default 5); tolerance: 5"), "what was chosen comes first: {}", formats[0]);
    assert!(formats[0].contains("83.333 kbit/s") && formats[0].contains("can't be read twice"));
}

#[test]
fn json_has_values_and_defaults_as_data() {
    let json = serde_json::to_value(json(&provenance())).unwrap();
    assert_eq!(json["options"][1]["value"][0], "3");
    assert_eq!((&json["options"][1]["default"][0], &json["options"][1]["by"]), (&"5".into(), &"command-line".into()));
    assert_eq!((&json["devices"][0]["vendor_id"], &json["bus"]["bit_rate"]), (&0x13.into(), &83_333.into()));
    assert_eq!(
        (&json["files"][0]["sha256"], &json["files"][1]["sha256"]),
        (&"abcdef".into(), &serde_json::Value::Null)
    );
    assert_eq!(json["notes"]["tester"], "Ann");
}

#[test]
fn a_simulated_run_has_no_date_of_its_own() {
    let without = Provenance::default();
    let shown = written(&without, TEXT);
    assert!(shown.contains("date         not given") && !shown.contains("host"), "{shown}");
    assert_eq!(json(&without).date, None);
}
