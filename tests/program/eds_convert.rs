//! `canvass eds convert`: formats, losses, and protection of existing files.

use crate::running::{run, run_with_input};
use std::fs;
use std::path::Path;

const MODEL: &str = "conformance/device/models/kuebler-sendix-f58.eds";

fn path(folder: &Path, name: &str) -> String {
    folder.join(name).display().to_string()
}

#[test]
fn there_and_back_again_nothing_differs() {
    let folder = tempfile::tempdir().unwrap();
    let (xdd, eds) = (path(folder.path(), "encoder.xdd"), path(folder.path(), "encoder.eds"));
    let there = run(&["eds", "convert", MODEL, &xdd]);
    assert_eq!((there.status, there.stdout.as_str()), (0, ""), "{}", there.stderr);
    let back = run(&["eds", "convert", &xdd, &eds]);
    assert_eq!((back.status, back.stderr.as_str()), (0, ""));
    let diff = run(&["eds", "diff", MODEL, &eds, "--fail-on-change", "notable"]);
    assert_eq!(diff.status, 0, "{}", diff.stdout);
    let text = fs::read_to_string(&eds).unwrap();
    assert!(text.starts_with("[FileInfo]\r\nFileName=encoder.eds\r\n"), "{text:.80}");
    // The conversion leaves no other files in the folder.
    let names: Vec<_> = fs::read_dir(folder.path()).unwrap().map(|entry| entry.unwrap().file_name()).collect();
    assert_eq!(names.len(), 2, "nothing is left behind: {names:?}");
}

#[test]
fn what_is_lost_is_said() {
    let dcf = run(&["eds", "convert", "analyzer/tests/eds/dcf.eds", "-", "--to", "xdc"]);
    assert_eq!(dcf.status, 0);
    assert!(dcf.stdout.contains("<deviceCommissioning NodeID=\"16\" nodeName=\"Left\""), "{}", dcf.stdout);
    let line = "analyzer/tests/eds/dcf.eds: [FileInfo] Description \"corpus\": the format has no place for it\n";
    assert!(dcf.stderr.contains(line), "{}", dcf.stderr);
    let many: String = (0..30).map(|number| format!("Unknown{number}=1\n")).collect();
    let text = format!("[FileInfo]\n{many}[2000]\nParameterName=a\nDataType=5\nAccessType=ro\n");
    let few = run_with_input(&["eds", "convert", "-", "-", "--to", "eds"], &text);
    assert_eq!(few.stderr.lines().count(), 21, "{}", few.stderr);
    assert!(few.stderr.ends_with("-: 10 more items are lost: --all-losses lists all\n"), "{}", few.stderr);
    let all = run_with_input(&["eds", "convert", "-", "-", "--to", "eds", "--all-losses"], &text);
    assert_eq!((all.stderr.lines().count(), all.stdout), (30, few.stdout));
}

#[test]
fn nothing_is_overwritten_unasked() {
    let folder = tempfile::tempdir().unwrap();
    let out = path(folder.path(), "out.xdd");
    fs::write(&out, "mine").unwrap();
    let refused = run(&["eds", "convert", MODEL, &out]);
    assert!(refused.status == 2 && refused.stderr.contains("give --force to overwrite it"), "{}", refused.stderr);
    assert_eq!(fs::read_to_string(&out).unwrap(), "mine");
    // An unreadable input keeps the output file, too.
    let unread = run(&["eds", "convert", "README.md", &out, "--force"]);
    assert_eq!((unread.status, fs::read_to_string(&out).unwrap().as_str()), (2, "mine"), "{}", unread.stderr);
    assert_eq!(run(&["eds", "convert", MODEL, &out, "--force"]).status, 0);
    assert!(fs::read_to_string(&out).unwrap().starts_with("<?xml"));
    let itself = run(&["eds", "convert", &out, &out, "--force"]);
    assert_eq!(itself.status, 2, "{}", itself.stderr);
}

#[test]
fn what_can_not_be_written_is_refused_with_the_remedy() {
    let folder = tempfile::tempdir().unwrap();
    let dcf = run(&["eds", "convert", MODEL, &path(folder.path(), "a.dcf")]);
    let expected = "the description is of a device type, but DCF is for a configured device: write EDS or XDD\n";
    assert!(dcf.status == 2 && dcf.stderr.ends_with(expected), "{}", dcf.stderr);
    let unknown = run(&["eds", "convert", MODEL, &path(folder.path(), "a.txt")]);
    assert!(
        unknown.status == 2 && unknown.stderr.contains("use --to with one of eds, dcf, xdd, xdc, dbc"),
        "{}",
        unknown.stderr
    );
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
}

/// Control sequences in the input get into neither the output nor a message.
#[test]
fn what_is_hostile_does_not_act() {
    let text = "[2000]\nParameterName=a\x1b]0;x\x07<b>\nDataType=9\nAccessType=ro\nDefaultValue=\"&\x1b[2J\n";
    for form in ["eds", "xdd"] {
        let shown = run_with_input(&["eds", "convert", "-", "-", "--to", form], text);
        assert!(!(shown.stdout.clone() + &shown.stderr).contains(['\x1b', '\x07']), "{}", shown.stdout);
        assert_eq!(shown.status, 0);
        assert!(shown.stderr.contains("written as"), "{}", shown.stderr);
    }
}

#[test]
fn the_pdos_become_a_can_database() {
    let folder = tempfile::tempdir().unwrap();
    let dbc = path(folder.path(), "encoder.dbc");
    let nobody = run(&["eds", "convert", MODEL, &dbc]);
    assert!(nobody.status == 2 && nobody.stderr.contains("names no node-ID: use --node N"), "{}", nobody.stderr);
    assert_eq!(run(&["eds", "convert", MODEL, &dbc, "--node", "0x3F"]).status, 0);
    // The unit is not ASCII, and tools expect the character set of Windows.
    let bytes = fs::read(&dbc).unwrap();
    assert!(bytes.windows(3).any(|part| part == b"\"\xB0\""));
    let text = String::from_utf8_lossy(&bytes);
    assert!(text.contains("BO_ 447 Sendix_F5868_63_TPDO1: 4 Sendix_F5868_63\n"), "{text}");
    let without = run(&["eds", "convert", "analyzer/tests/eds/dcf.eds", "-", "--to", "dbc"]);
    assert!(without.status == 2 && without.stderr.contains("has no PDO that a DBC could hold"), "{}", without.stderr);
    let other = run(&["eds", "convert", MODEL, &path(folder.path(), "a.xdd"), "--node", "5"]);
    assert!(other.status == 2 && other.stderr.contains("--node is for a DBC"), "{}", other.stderr);
}

/// A file with an unresolved merge is no description.
#[test]
fn half_a_file_is_not_converted() {
    let text = "<<<<<<< ours\n[2000]\nParameterName=a\n=======\n>>>>>>> theirs\n";
    for args in [&["eds", "convert", "-", "-", "--to", "xdd"][..], &["eds", "diff", "-", MODEL]] {
        let refused = run_with_input(args, text);
        assert!(refused.status == 2 && refused.stderr.contains("merge conflict"), "{}", refused.stderr);
    }
}
