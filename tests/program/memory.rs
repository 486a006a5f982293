//! Memory does not grow with the capture: the test compares the peak memory of the running process after a part of the
//! capture and after ten times as much.

use std::fmt::Write as _;
use std::io::Write;
use std::process::{Child, Command, Stdio};

/// Number of cycles of [`CYCLE`] before the first measurement.
const WARM_UP: usize = 1_500;
const FACTOR: usize = 10;
/// Limit of the growth in KiB. Buffers may still grow to their size.
const MOST_GROWTH: u64 = 2 * 1024;
const MOST: u64 = 64 * 1024;

/// Process data of described and unknown nodes, SYNC, heartbeats, an error that comes and goes, transfers of all kinds.
const CYCLE: &str = "\
080#
1BF#BA4C0000
181#0102030405060708
73F#05
701#05
63F#4004600000000000
5BF#43046000BA4C0000
601#4008100000000000
581#4108100007000000
601#6000000000000000
581#014B7565626C6572
63F#40005000AABBCCDD
5BF#8000500000000206
0BF#1043200900000000
0BF#0000000000000000
";

/// The peak memory of the process so far, in KiB.
fn peak(child: &Child) -> u64 {
    let status = std::fs::read_to_string(format!("/proc/{}/status", child.id())).unwrap();
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:")).unwrap();
    line.trim().trim_end_matches("kB").trim().parse().unwrap()
}

/// Writes `count` cycles, with a millisecond between frames.
fn cycles(first: usize, count: usize, out: &mut impl Write) {
    let mut text = String::new();
    for cycle in first..first + count {
        for (n, frame) in CYCLE.lines().enumerate() {
            let milliseconds = cycle * CYCLE.lines().count() + n;
            let (seconds, rest) = (1_700_000_000 + milliseconds / 1_000, milliseconds % 1_000);
            writeln!(text, "({seconds}.{rest:03}000) can0 {frame}").unwrap();
        }
        if text.len() > 60_000 {
            out.write_all(text.as_bytes()).unwrap();
            text.clear();
        }
    }
    out.write_all(text.as_bytes()).unwrap();
}

/// Runs a command on standard input. The pipe holds at most 64 KiB, so that the program has read all bytes that were
/// written before.
fn does_not_grow(args: &str) {
    let mut child = Command::new(env!("CARGO_BIN_EXE_canvass"))
        .args(args.split(' '))
        .stdin(Stdio::piped())
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let mut stdin = child.stdin.take().unwrap();
    cycles(0, WARM_UP, &mut stdin);
    let before = peak(&child);
    cycles(WARM_UP, WARM_UP * (FACTOR - 1), &mut stdin);
    let after = peak(&child);
    drop(stdin);
    assert!(child.wait().unwrap().success(), "{args}");
    assert!(after < before + MOST_GROWTH, "{args}: {before} KiB, then {after} KiB");
    assert!(after < MOST, "{args}: {after} KiB");
}

#[test]
fn of_decode() {
    does_not_grow("decode --device 63=kuebler-sendix-58x8 -");
    does_not_grow("decode --format json --device 63=kuebler-sendix-58x8 -");
}

#[test]
fn of_decode_events() {
    does_not_grow("decode --events --format json -");
}

#[test]
fn of_signals() {
    does_not_grow("signals --format json --device 63=kuebler-sendix-58x8 -");
}

#[test]
fn of_diagnose() {
    does_not_grow("diagnose --fail-on never --device 63=kuebler-sendix-58x8 -");
}

#[test]
fn of_convert() {
    does_not_grow("convert --to pcapng - /dev/null");
    does_not_grow("convert --to mcap - /dev/null");
    does_not_grow("convert --to asc - /dev/null");
}
