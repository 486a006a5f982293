//! `canvass decode` as a user runs it.

use crate::running::{command, finished, run, run_with_input};
use std::io::{BufRead, BufReader, Write};
use std::process::Stdio;

/// The bus trace of Kübler's manual, section 5.7.7: the meaning of each row, in the order of the manual.
#[test]
fn the_bus_trace_of_the_manual() {
    let meanings = [
        "boot-up",
        "write 1011h:01 Restore default parameters, Restore all default parameters = \"load\"",
        "write confirmed: 1011h:01",
        "reset node, node 63",
        "boot-up",
        "write 2100h:00 Baud rate = 5 (250 kbit/s)",
        "write confirmed: 2100h:00",
        "write 2101h:00 Node number = 63",
        "write confirmed: 2101h:00",
        "write 2102h:00 CAN bus termination = 0 (off)",
        "write confirmed: 2102h:00",
        "write 2105h:00 Save all bus parameters = \"save\"",
        "write confirmed: 2105h:00",
        "boot-up",
        "write 6200h:00 Cyclic timer = 10 ms",
        "write confirmed: 6200h:00",
        "write 6000h:00 Operating parameters = 1 (code sequence counter-clockwise",
        "write confirmed: 6000h:00",
        "write 1010h:01 Store parameters, Save all parameters = \"save\"",
        "write confirmed: 1010h:01",
        "start remote node, node 63",
        "TPDO 1: 6004h:00 Position value = 19642 steps",
        "TPDO 1: 6004h:00 Position value = 19642 steps",
        "TPDO 1: 6004h:00 Position value = 19642 steps",
        "TPDO 1: 6004h:00 Position value = 19642 steps",
        "enter pre-operational, node 63",
    ];
    let trace = "traces/samples/kuebler-5.7.7.txt";
    let decoded = run(&["decode", trace, "--device", "63=kuebler-sendix-58x8"]);
    assert_eq!(decoded.status, 0, "{}", decoded.stderr);
    let lines: Vec<&str> = decoded.stdout.lines().collect();
    assert_eq!(lines.len(), meanings.len());
    for (line, meaning) in lines.iter().zip(meanings) {
        assert!(line.contains(meaning), "{line}\ndoes not say: {meaning}");
    }
    // The manual prints the positions with a length of 4 and six bytes: a contradiction.
    let reports: Vec<&str> = decoded.stderr.lines().collect();
    assert_eq!(reports.len(), 4);
    for (report, line) in reports.iter().zip(22..) {
        assert!(report.starts_with(&format!("{trace}:{line}:")), "{report}");
    }
}

#[test]
fn a_line_comes_out_as_soon_as_its_frame_came_in() {
    let mut child = command(&["decode", "-"]).stdin(Stdio::piped()).stdout(Stdio::piped()).spawn().unwrap();
    let mut stdin = child.stdin.take().unwrap();
    let mut stdout = BufReader::new(child.stdout.take().unwrap());
    for (frame, meaning) in [("73F#00", "boot-up"), ("000#013F", "start remote node"), ("73F#05", "operational")] {
        writeln!(stdin, "(1700000000.000000) can0 {frame}").unwrap();
        let mut line = String::new();
        // The call blocks for ever if the program holds the line back.
        stdout.read_line(&mut line).unwrap();
        assert!(line.contains(meaning), "{line}");
    }
    drop(stdin);
    assert!(child.wait().unwrap().success());
}

const WITH_A_MISTAKE: &str = "(1.0) can0 73F#00\n(1.1) can0 73F#0G\n(1.2) can0 73F#7F\n";
const MISTAKE: &str = "\
(1.000000) can0 73F#00
(1.100000) can0 73F#0G
(1.200000) can0 73F#7F
";

#[test]
fn a_malformed_line_is_reported_and_the_rest_decoded() {
    let decoded = run_with_input(&["decode", "-"], MISTAKE);
    assert_eq!(decoded.status, 0);
    assert_eq!(decoded.stdout.lines().count(), 2);
    assert!(decoded.stdout.contains("heartbeat: pre-operational"));
    let report = decoded.stderr.lines().next().unwrap();
    assert!(
        report.starts_with("-:2:") && report.contains("malformed: expected") && report.contains("found"),
        "{report}"
    );
    // A file whose times have a single decimal is no candump log.
    assert_ne!(run_with_input(&["decode", "-", "--strict"], WITH_A_MISTAKE).status, 0);
}

#[test]
fn strict_stops_at_the_first_mistake() {
    let decoded = run_with_input(&["decode", "-", "--strict"], MISTAKE);
    assert_eq!(decoded.status, 2);
    assert_eq!(decoded.stdout.lines().count(), 1, "what came before is shown");
}

#[test]
fn json_lines_hold_what_the_contract_names() {
    let frames = "(1700000000.000001) can0 63F#4000600000000000\n(1700000000.002000) can0 00012345#R4\n";
    let decoded = run_with_input(&["decode", "--format", "json", "-"], frames);
    let lines: Vec<serde_json::Value> =
        decoded.stdout.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    let expected = serde_json::json!({
        "schema": "canvass/decode/1",
        "t": 1_700_000_000_000_001_000_u64,
        "channel": "can0",
        "id": 0x63F,
        "data": "4000600000000000",
        "node": 63,
        "service": "sdo",
        "source": "predefined",
        "index": 0x6000,
        "sub": 0,
        "text": "read 6000h:00",
    });
    for (key, value) in expected.as_object().unwrap() {
        assert_eq!(&lines[0][key], value, "{key} of {}", lines[0]);
    }
    assert_eq!((&lines[1]["extended"], &lines[1]["remote"], &lines[1]["dlc"]), (&true.into(), &true.into(), &4.into()));
    assert_eq!((&lines[1]["node"], &lines[1]["service"]), (&serde_json::Value::Null, &"unknown".into()));
}

#[test]
fn frames_are_chosen_by_node_time_and_filter() {
    let frames = "\
(10.000000) can0 701#7F
(11.000000) can0 702#7F
(12.000000) can0 701#05
";
    let count = |args: &[&str]| {
        let args: Vec<&str> = ["decode", "-"].iter().chain(args).copied().collect();
        run_with_input(&args, frames).stdout.lines().count()
    };
    assert_eq!(count(&[]), 3);
    assert_eq!(count(&["--node", "1"]), 2);
    assert_eq!(count(&["--from", "11", "--to", "11.5"]), 1);
    assert_eq!(count(&["--from", "+1.5"]), 1);
    assert_eq!(count(&["--filter", "node=1 and service=heartbeat"]), 2);
    let wrong = run(&["decode", "-", "--filter", "node=1 und service=sdo"]);
    assert_eq!(wrong.status, 2);
    assert!(wrong.stderr.contains("column 8"), "{}", wrong.stderr);
}

#[test]
fn hostile_names_stay_text() {
    // The answer to reading 1008h, in segments: ESC [ 3 1 m < s and a channel name with an escape sequence.
    let frames = "\
(1.000000) c\x1b[31m 601#4008100000000000
(1.001000) c\x1b[31m 581#4108100007000000
(1.002000) c\x1b[31m 601#6000000000000000
(1.003000) c\x1b[31m 581#011B5B33316D3C73
";
    for format in ["text", "json"] {
        let decoded = run_with_input(&["decode", "-", "--format", format], frames);
        assert!(!decoded.stdout.contains('\x1b'), "{}", decoded.stdout);
        assert!(!decoded.stderr.contains('\x1b'), "{}", decoded.stderr);
    }
}

#[test]
fn colours_on_request_only() {
    let frame = "(1.000000) can0 0BF#3081110000000000\n";
    assert!(!run_with_input(&["decode", "-"], frame).stdout.contains('\x1b'));
    assert!(run_with_input(&["decode", "-", "--color", "always"], frame).stdout.contains("\x1b[31m"));
}

#[test]
fn a_closed_pipe_ends_the_program_quietly() {
    let mut child =
        command(&["decode", "-"]).stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    drop(child.stdout.take());
    let mut stdin = child.stdin.take().unwrap();
    for _ in 0..10_000 {
        if stdin.write_all(b"(1.000000) can0 73F#00\n").is_err() {
            break;
        }
    }
    drop(stdin);
    let ended = finished(child.wait_with_output().unwrap());
    assert_eq!((ended.status, ended.stderr.as_str()), (0, ""));
}

#[test]
fn unreadable_input_is_status_2() {
    for (args, says) in [
        (&["decode", "no-such-file.log"][..], "no-such-file.log"),
        (&["decode", "Cargo.toml"], "no known format"),
        (&["decode", "Cargo.toml"], "candump-console, pasted; if you know which, use --format-in"),
        (&["decode", if cfg!(windows) { "NUL" } else { "/dev/null" }], "empty"),
        (&["decode", "-", "--device", "200=x.eds"], "node-ID of 1 to 127"),
        (&["decode", "-", "--device", "5=no-such-model"], "neither a built-in model"),
    ] {
        let ended = run(args);
        assert_eq!(ended.status, 2, "{args:?}: {}", ended.stderr);
        assert!(ended.stderr.contains(says), "{args:?}: {}", ended.stderr);
    }
}

/// Frames that the filter does not select need not be decoded. A filter of lengths makes the program decode every
/// frame, and selects the same frames.
#[test]
fn filters_choose_what_they_chose_when_all_was_decoded() {
    let folder = tempfile::tempdir().unwrap();
    let long = folder.path().join("long.log").display().to_string();
    std::fs::write(&long, repeated()).unwrap();
    let sample = concat!(env!("CARGO_MANIFEST_DIR"), "/traces/samples/kuebler-5.7.7.txt");
    for file in [&*long, sample] {
        for filter in [
            "node=2",
            "node=2 and service=sdo",
            "service=heartbeat and not node=3",
            "id=0x1A0",
            "service=unknown and not extended",
            "extended and id=0x18FF0001",
            "index in 0x1800..0x1A00 or service in nmt, boot-up",
            "not (service=pdo or service=sync) and not rx",
        ] {
            let all = format!("({filter}) or len=4000");
            for format in ["text", "json"] {
                let [one, other] =
                    [filter, &all].map(|filter| run(&["decode", file, "--format", format, "--filter", filter]));
                assert_eq!(
                    (one.status, one.stdout, one.stderr),
                    (other.status, other.stdout, other.stderr),
                    "{filter}"
                );
            }
        }
        let [node, filter] = [["--node", "2"], ["--filter", "node=2 or len=4000"]]
            .map(|chosen| run(&[&["decode", file, "--time", "delta"], &chosen[..]].concat()).stdout);
        assert_eq!(node, filter);
    }
}

/// Three nodes that repeat the same messages, until a COB-ID moves or a node starts.
fn repeated() -> String {
    let mut log = String::new();
    let mut say = |n: u32, frame: &str| log += &format!("(17000{n:05}.000000) can{} {frame}\n", n % 2);
    for n in 0..3_000_u32 {
        let node = n % 3 + 1;
        match n / 6 % 25 {
            0 => say(n, &format!("60{node}#2300180180010000")),
            1 => say(n, &format!("60{node}#23001801A0010000")),
            2 | 3 => say(n, &format!("58{node}#6000180100000000")),
            4 => say(n, &format!("000#{:02X}00", [1, 2, 0x80][n as usize % 3])),
            5 => say(n, &format!("70{node}#00")),
            6 => say(n, "1A0#0102030405060708"),
            7 => say(n, &format!("18FF000{node}#01")),
            8 => say(n, "080#"),
            9 => say(n, &format!("33{node}#0102")),
            10..18 => say(n, &format!("18{node}#{n:08X}")),
            _ => say(n, &format!("70{node}#{}", ["05", "7F"][(n / 900) as usize % 2])),
        }
    }
    log
}
