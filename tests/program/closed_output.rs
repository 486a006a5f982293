//! Standard output is closed: the results of a command and its exit status stay the same.

use crate::rogues::Rogue;
use crate::running::{Run, command, finished, run};
use std::process::Stdio;

/// Runs a command whose standard output was closed before the program began.
fn unread(args: &[&str]) -> Run {
    let (reader, writer) = std::io::pipe().unwrap();
    drop(reader);
    let child = command(args).stdin(Stdio::null()).stdout(writer).stderr(Stdio::piped()).spawn().unwrap();
    finished(child.wait_with_output().unwrap())
}

#[test]
fn the_status_is_that_of_the_verdict() {
    let folder = tempfile::tempdir().unwrap();
    let broken = folder.path().join("broken.eds");
    std::fs::write(&broken, "[1000]\nParameterName=Device type\nObjectType=seven\n").unwrap();
    let broken = broken.to_str().unwrap();
    let never = ["selftest", "--fuzz", "--fault", "sdo-toggle-unchecked", "--seeds", "1", "--within", "0.001ms"];
    let commands: [(&[&str], i32); 8] = [
        (&["scan", "sim:reference-301"], 0),
        (&["scan", "sim:reference-301", "--format", "json"], 0),
        (&["selftest", "--fault", "sdo-toggle-unchecked"], 0),
        (&["selftest", "--fault", "sdo-toggle-unchecked", "--format", "json"], 0),
        (&never, 1),
        (&[&never[..], &["--format", "json"]].concat(), 1),
        (&["eds", "check", broken], 1),
        (&["list", "faults"], 0),
    ];
    for (args, status) in commands {
        let (read, unread) = (run(args), unread(args));
        assert_eq!((read.status, unread.status), (status, status), "{args:?}: {}{}", read.stderr, unread.stderr);
        assert!(!unread.stderr.contains("pipe"), "{args:?}: {}", unread.stderr);
    }
}

/// A scan without end reports this and fails, even if nobody reads what it has found.
#[test]
fn a_scan_without_end_is_no_success() {
    let bus = format!("slcan:tcp://{}", Rogue::Endless.start().unwrap());
    let scanned = unread(&["scan", &bus, "--for", "2s"]);
    assert_eq!(scanned.status, 3, "{}", scanned.stderr);
    assert!(scanned.stderr.contains("do not follow the protocol"), "{}", scanned.stderr);
}
