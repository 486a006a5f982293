//! All commands use the same words, and answer even if they find nothing.

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
    // The examples of the page work.
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

/// Options for several nodes take lists, ranges and `all`.
#[test]
fn nodes_are_written_as_lists_and_ranges() {
    let lines = |args: &[&str]| run(&[&["decode", CAPTURE], args].concat()).stdout.lines().count();
    assert_eq!(lines(&["--node", "5,63"]), lines(&["--node", "5", "--node", "60..63"]));
    assert!(lines(&["--node", "1..62"]) < lines(&["--node", "all"]));
    for device in ["1..8,63=kuebler-sendix-58x8", "all=kuebler-sendix-58x8"] {
        let shown = run(&["decode", CAPTURE, "--device", device]);
        assert!(shown.stdout.contains("Speed value channel 1 = 1200 rpm"), "{device}: {}", shown.stderr);
        assert_eq!(run(&["diagnose", CAPTURE, "--device", device, "--fail-on", "never"]).status, 0);
    }
    for wrong in ["8..1", "0..3", "1..", "x"] {
        assert_eq!(run(&["decode", CAPTURE, "--node", wrong]).status, 2, "{wrong}");
    }
}

/// `-` is standard output, never a file of this name.
#[test]
fn a_dash_is_standard_output() {
    let folder = tempfile::tempdir().unwrap();
    let there = |args: &[&str]| {
        let ended = crate::running::command(args).current_dir(&folder).output().unwrap();
        assert!(!folder.path().join("-").exists(), "{args:?}");
        crate::running::finished(ended)
    };
    let (test, old) = (["test", "sim:reference-301", "--select", "301/identity/vendor-id"], "old.json");
    let json = there(&[&test[..], &["--report", "json=-", "--report", "json=old.json"]].concat());
    assert!(json.status == 0 && json.stdout.starts_with("{\n  \"schema\": \"canvass/test/1\""), "{}", json.stdout);
    assert_eq!(json.stdout, std::fs::read_to_string(folder.path().join(old)).unwrap());
    assert!(there(&["compare", old, old, "--report", "markdown=-"]).stdout.starts_with("# What changed from "));
    assert!(there(&["history", old, "--report", "json=-"]).stdout.contains("canvass/history/1"));
    assert!(
        there(&["fuzz", "sim:reference-301", "--runs", "2", "--report", "json=-"]).stdout.contains("canvass/fuzz/1")
    );
    for more in [&["--report", "json=-", "--format", "html"][..], &["--record", "-"], &["--bundle", "-"]] {
        let refused = there(&[&test[..], more].concat());
        assert!(refused.status == 2 && refused.stderr.contains("standard output"), "{more:?}: {}", refused.stderr);
    }
    let capture = format!("{}/{CAPTURE}", env!("CARGO_MANIFEST_DIR"));
    assert!(there(&["convert", &capture, "-", "--to", "csv"]).stdout.starts_with("timestamp"));
    assert!(there(&["diagnose", &capture, "--format", "json", "-o", "-"]).stdout.contains("canvass/diagnose/1"));
}

#[test]
fn times_are_those_of_a_zone() {
    let mut local = crate::running::command(&["decode", CAPTURE, "--time", "local"]);
    let shown = crate::running::finished(local.env("TZ", "Europe/Berlin").output().unwrap());
    assert!(shown.stdout.starts_with("2025-01-28T11:47:15.000000000+01:00  can0"), "{}", shown.stdout);
    // A time in the form that the program prints is accepted as an option.
    let from = run(&["decode", CAPTURE, "--from", "2025-01-28T11:47:15.000000000+01:00", "--time", "utc"]);
    assert!(from.stdout.starts_with("2025-01-28T10:47:15.000000000Z  can0"), "{}", from.stdout);
}

/// Every option for a span takes the same units, and a number alone means seconds.
#[test]
fn waits_have_units() {
    for args in [
        &["sdo", "read", "sim:reference-301", "10", "1000", "--timeout", "500ms"][..],
        &["sdo", "read", "sim:reference-301", "10", "1000", "--timeout", "1"],
        &["nmt", "sim:reference-301", "start", "10", "--wait", "0.2s"],
        &["send", "sim:reference-301", "60A#4000100000000000", "--wait", "50ms"],
        &["test", "sim:reference-301", "--select", "301/identity/names", "--timeout", "sdo=1s,boot-up=6"],
        &["scan", "sim:reference-301", "--timeout", "0.1"],
        &["signals", CAPTURE, "--every", "10ms"],
        &["monitor", "sim:reference-301", "--for", "0.5"],
    ] {
        let ended = run(args);
        assert_eq!(ended.status, 0, "{args:?}: {}", ended.stderr);
    }
}
