//! The same words in all commands, and an answer where nothing was found.

use crate::running::run;

const CAPTURE: &str = "docs/examples/commissioning.log";

#[test]
fn what_matches_nothing_says_so() {
    for command in ["decode", "signals"] {
        let none = run(&[command, CAPTURE, "--node", "99"]);
        assert_eq!(none.status, 0, "{}", none.stderr);
        assert!(none.stderr.contains("no frame is of node 99"), "{command}: {}", none.stderr);
        let filtered = run(&[command, CAPTURE, "--filter", "id=5"]);
        assert!(filtered.stderr.contains("no frame passes the filter"), "{command}: {}", filtered.stderr);
        let some = run(&[command, CAPTURE, "--node", "5", "--filter", "node=5"]);
        assert!(!some.stderr.contains("no frame"), "{command}: {}", some.stderr);
    }
    let events = run(&["decode", CAPTURE, "--events", "--filter", "id=5"]);
    assert!(events.stderr.contains("no frame passes the filter"), "{}", events.stderr);
}

#[test]
fn there_is_help_of_filters_and_of_commands() {
    let page = run(&["help", "filter"]);
    assert_eq!(page.status, 0, "{}", page.stderr);
    for field in ["node", "id", "index", "sub", "len", "abort", "emcy", "violation", "fd", "in 1..8", "181h"] {
        assert!(page.stdout.contains(field), "{field}");
    }
    // Its examples work.
    for line in page.stdout.lines().filter(|line| line.trim_start().starts_with("canvass decode")) {
        let filter = line.split('\'').nth(1).unwrap();
        let ended = run(&["decode", CAPTURE, "--filter", filter]);
        assert_eq!(ended.status, 0, "{filter}: {}", ended.stderr);
    }
    assert!(run(&["help", "sdo", "read"]).stdout.contains("Usage: canvass sdo read"));
    assert!(run(&["help"]).stdout.contains("CANopen trace analyzer"));
    let unknown = run(&["help", "dinner"]);
    assert!(unknown.status == 2 && unknown.stderr.contains("filter"), "{}", unknown.stderr);
}

/// A wait is written the same way wherever one is.
#[test]
fn waits_have_units() {
    for args in [
        &["sdo", "read", "sim:reference-301", "10", "1000", "--timeout", "500ms"][..],
        &["sdo", "read", "sim:reference-301", "10", "1000", "--timeout", "500"],
        &["nmt", "sim:reference-301", "start", "10", "--wait", "0.2s"],
        &["send", "sim:reference-301", "60A#4000100000000000", "--wait", "50ms"],
        &["test", "sim:reference-301", "--select", "301/identity/names", "--timeout", "sdo=1s,boot-up=6000"],
        &["scan", "sim:reference-301", "--timeout", "100ms"],
    ] {
        let ended = run(args);
        assert_eq!(ended.status, 0, "{args:?}: {}", ended.stderr);
    }
}
