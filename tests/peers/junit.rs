//! xmllint validates the JUnit documents of all commands against a schema that allows only what the schemas of Ant and
//! Jenkins both allow.

use std::path::Path;
use std::process::Command;

const SCHEMA: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/peers/junit.xsd");
/// A name that would end a tag, an attribute, a comment or a document.
const HOSTILE: &str = "]]></testcase>\"'<!--&amp;\u{1b}[2J\u{fffe}";

/// Runs the program, which must reach a verdict, good or bad; returns its output.
fn judged(args: &[&str]) -> Vec<u8> {
    let output = Command::new(env!("CARGO_BIN_EXE_canvass")).args(args).output().unwrap();
    let good = matches!(output.status.code(), Some(0 | 1));
    assert!(good, "{args:?}: {}", String::from_utf8_lossy(&output.stderr));
    output.stdout
}

/// The errors that xmllint finds in a document; empty if the document is valid.
fn wrong(document: &Path) -> String {
    let output = Command::new("xmllint").args(["--noout", "--nonet", "--schema", SCHEMA]).arg(document).output();
    let output = output.unwrap_or_else(|error| panic!("xmllint: {error}; cargo xtask ci installs it"));
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.success(), said.trim_end().ends_with("validates"), "{said}");
    if output.status.success() { String::new() } else { said }
}

/// A document of each command that writes JUnit, with cases that pass, fail and are left out.
fn documents(folder: &Path) -> Vec<String> {
    let path = |name: &str| folder.join(name).display().to_string();
    let junit = |name: &str| format!("junit={}", path(name));
    let note = format!("batch={}", HOSTILE.replace('\u{fffe}', ""));
    let (old, new) = (path("old.json"), path("new.json"));
    let (old_report, new_report) = (format!("json={old}"), format!("json={new}"));
    let good = ["test", "sim:reference-301", "--select", "301/sdo/download", "--note", &note];
    judged(&[&good[..], &["--report", &old_report]].concat());
    let bad = [&["test", "sim:reference-301+sdo-toggle-unchecked"], &good[2..]].concat();
    judged(&[&bad[..], &["--report", &new_report, "--report", &junit("test.xml")]].concat());
    judged(&["compare", &old, &new, "--report", &junit("worse.xml")]);
    judged(&["compare", &old, &old, "--report", &junit("same.xml")]);
    let fuzz = ["fuzz", "sim:reference-301+sdo-toggle-unchecked", "--runs", "200", "--note", &note];
    judged(&[&fuzz[..], &["--report", &junit("fuzz.xml")]].concat());
    let capture = path("capture.log");
    std::fs::write(&capture, "(1.000000) can0 701#05\n(2.000000) can0 081#1081010000000000\n(2.5) can0 581#80001000\n")
        .unwrap();
    judged(&["diagnose", &capture, "--note", &note, "--format", "junit", "--output", &path("diagnose.xml")]);
    let description = path("mine.eds");
    std::fs::write(&description, format!("[DeviceInfo]\nProductName={HOSTILE}\n[{HOSTILE}]\n[1000]\nX={HOSTILE}\n"))
        .unwrap();
    std::fs::write(path("checked.xml"), judged(&["eds", "check", &description, "--format", "junit"])).unwrap();
    ["test", "worse", "same", "fuzz", "diagnose", "checked"].map(|name| path(&format!("{name}.xml"))).to_vec()
}

#[test]
fn every_document_is_valid_for_ant_and_jenkins() {
    let folder = tempfile::tempdir().unwrap();
    let mut found = [0; 3];
    for document in documents(folder.path()) {
        let text = std::fs::read_to_string(&document).unwrap();
        assert_eq!(wrong(Path::new(&document)), "", "{document}: {text}");
        let elements = ["<failure ", "<skipped", "<testcase "];
        elements.iter().zip(&mut found).for_each(|(element, count)| *count += text.matches(element).count());
    }
    let [failed, skipped, cases] = found;
    assert!(
        failed > 0 && skipped > 0 && cases > failed + skipped,
        "there is something to be held against it: {found:?}"
    );
}

/// The schema refuses an invalid document.
#[test]
fn what_is_not_valid_is_found() {
    let folder = tempfile::tempdir().unwrap();
    let written = documents(folder.path());
    let text = std::fs::read_to_string(&written[0]).unwrap();
    for (from, to) in [
        ("<properties>", "<properties><oops/>"),
        (" hostname=\"localhost\"", ""),
        (" hostname=\"localhost\"", " hostname=\"\""),
        (" package=\"canvass\"", " package=\"canvass\" disabled=\"0\""),
        ("<system-err></system-err>", ""),
        ("\" hostname=\"", "Z\" hostname=\""),
        ("<testcase ", "<testcase assertions=\"1\" "),
        ("type=\"fail\"", "kind=\"fail\""),
        ("<testsuites>", "<testsuites tests=\"7\">"),
    ] {
        let changed = text.replacen(from, to, 1);
        assert!(changed != text, "{from}: {text}");
        let file = folder.path().join("changed.xml");
        std::fs::write(&file, changed).unwrap();
        assert_ne!(wrong(&file), "", "{from} -> {to}");
    }
}
