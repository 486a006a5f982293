//! `canvass eds diff`: output formats, exit statuses, inputs.

use crate::running::{run, run_with_input};
use canvass_analyzer::dictionary::difference::kinds;
use serde_json::Value;

const OLD: &str = "analyzer/tests/eds/plain.eds";
const PLAIN: &str = include_str!("../../analyzer/tests/eds/plain.eds");

/// The exit status and the output for a description in which `from` is replaced by `to`.
fn diff(from: &str, to: &str, args: &[&str]) -> (i32, String) {
    assert!(PLAIN.contains(from), "{from}");
    let args = [&["eds", "diff", OLD, "-"], args].concat();
    let run = run_with_input(&args, &PLAIN.replacen(from, to, 1));
    assert_eq!(run.stderr, "");
    (run.status, run.stdout)
}

#[test]
fn what_breaks_is_told_with_its_reason_and_makes_the_status() {
    let (status, text) = diff("HighLimit=1000", "HighLimit=100", &[]);
    let expected = "breaking  the limits are narrower  [limit/narrower]\n  2000h:00 Setting: 1000 -> 100\n  \
                    = A DCF with a value that was allowed is refused: abort 0609 0031h (too high) or 0609 0032h (too low).\n\n\
                    notable  the version of the file is the same, but its content is not  [file/same-version]\n  FileVersion: \"1\" -> \"1\"\n  \
                    = A tool with the old file may keep it, as it can't see the change.\n\n\
                    analyzer/tests/eds/plain.eds -> -: 1 breaking, 1 notable, no harmless\n";
    assert_eq!((status, text.as_str()), (1, expected));
    assert_eq!(run(&["eds", "diff", OLD, OLD]).stdout, format!("{OLD} -> {OLD}: no difference\n"));
}

#[test]
fn from_which_class_on_the_status_is_1_can_be_chosen() {
    let changes = [
        ("HighLimit=1000", "HighLimit=100", [1, 1, 1, 0]),
        ("DefaultValue=5", "DefaultValue=6", [0, 1, 1, 0]),
        ("OrderCode=4", "OrderCode=5", [0, 0, 1, 0]),
        ("HighLimit=1000", "HighLimit=1000", [0, 0, 0, 0]),
    ];
    for (from, to, statuses) in changes {
        for (class, expected) in ["breaking", "notable", "harmless", "never"].into_iter().zip(statuses) {
            assert_eq!(diff(from, to, &["--fail-on-change", class]).0, expected, "{to} {class}");
        }
    }
}

#[test]
fn other_forms_say_the_same() {
    let (_, json) = diff("HighLimit=1000", "HighLimit=100", &["--format", "json"]);
    let json: Value = serde_json::from_str(&json).unwrap();
    assert_eq!(json["schema"], "canvass/eds-diff/1");
    let one = &json["differences"][0];
    assert_eq!((&one["kind"], &one["class"]), (&"limit/narrower".into(), &"breaking".into()));
    assert_eq!((&one["before"], &one["after"]), (&1000.into(), &100.into()));
    let (_, markdown) = diff("HighLimit=1000", "HighLimit=100", &["--format", "markdown"]);
    assert!(markdown.contains("| the limits are narrower | 2000h:00 Setting | 1000 | 100 |"), "{markdown}");
}

#[test]
fn descriptions_of_different_formats_are_compared() {
    let (xdd, xdc) = ("analyzer/tests/xdd/parameters.xdd", "analyzer/tests/xdd/attributes.xdc");
    let mixed = run(&["eds", "diff", OLD, xdd, "--format", "json"]);
    assert_eq!(mixed.status, 1);
    let json: Value = serde_json::from_str(&mixed.stdout).unwrap();
    let told = |kind: &str, index: u64| {
        json["differences"].as_array().unwrap().iter().any(|one| one["kind"] == kind && one["index"] == index)
    };
    assert!(told("object/removed", 0x1800) && told("entry/data-type", 0x2000) && !told("entry/data-type", 0x1000));
    assert_eq!(run(&["eds", "diff", xdc, xdc]).status, 0);
}

#[test]
fn what_can_not_be_read_is_status_2() {
    for args in [["README.md", OLD], [OLD, "no.eds"], ["-", "-"], [OLD, "src"]] {
        let run = run_with_input(&["eds", "diff", args[0], args[1]], "");
        assert_eq!((run.status, run.stdout.as_str()), (2, ""), "{args:?}: {}", run.stderr);
        assert!(run.stderr.starts_with("canvass: "), "{}", run.stderr);
    }
}

#[test]
fn every_kind_of_change_stands_in_the_documentation() {
    let page = std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/docs/eds.md")).unwrap();
    for kind in kinds() {
        let row = format!("| `{}` | {} | {} |", kind.id, kind.class, kind.title());
        assert!(page.contains(&row), "docs/eds.md lacks the row {row}");
    }
}
