//! Every command that sends requests to a device ends in time, whatever the device does.

use crate::rogues::Rogue;
use crate::running::{Run, command, finished};
use std::process::Stdio;
use std::time::{Duration, Instant};

/// Runs a command on a rogue adapter; also returns the duration of the run.
fn on(rogue: Rogue, args: &[&str]) -> (Run, Duration) {
    let bus = format!("slcan:tcp://{}", rogue.start().unwrap());
    let begun = Instant::now();
    let args: Vec<&str> = args.iter().map(|arg| if *arg == "BUS" { &*bus } else { arg }).collect();
    let child = command(&args).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    (finished(child.wait_with_output().unwrap()), begun.elapsed())
}

/// The time limit of each phase: the run, opening the adapter, and restoring the device.
const SPAN: &str = "4s";
const MOST: Duration = Duration::from_secs(20);

#[test]
fn fuzz_ends_in_time() {
    std::thread::scope(|scope| {
        for rogue in Rogue::ALL {
            scope.spawn(move || {
                let (run, took) = on(rogue, &["fuzz", "BUS", "--node", "5", "--for", SPAN, "--format", "json"]);
                assert!(took < MOST, "{rogue:?}: {took:?}, {}", run.stderr);
                assert!((1..=3).contains(&run.status), "{rogue:?}: {}", run.stderr);
            });
        }
    });
}

#[test]
fn test_ends_in_time() {
    std::thread::scope(|scope| {
        for rogue in Rogue::ALL {
            scope.spawn(move || {
                let (run, took) = on(rogue, &["test", "BUS", "--node", "5", "--for", SPAN, "--format", "json"]);
                assert!(took < MOST, "{rogue:?}: {took:?}, {}", run.stderr);
                assert!((1..=3).contains(&run.status), "{rogue:?}: {}", run.stderr);
            });
        }
    });
}

#[test]
fn scan_ends_in_time() {
    std::thread::scope(|scope| {
        for rogue in Rogue::ALL {
            scope.spawn(move || {
                let (run, took) = on(rogue, &["scan", "BUS", "--for", SPAN]);
                assert!(took < MOST, "{rogue:?}: {took:?}, {}", run.stderr);
                if rogue == Rogue::Endless {
                    assert_eq!(
                        (run.status, run.stderr.contains("do not follow the protocol")),
                        (3, true),
                        "{}",
                        run.stderr
                    );
                    assert!(run.stderr.contains("605#"), "the frames are told: {}", run.stderr);
                }
            });
        }
    });
}

#[test]
fn an_upload_has_a_limit() {
    let read = |rogue, more: &[&str]| on(rogue, &[&["sdo", "read", "BUS", "5", "1008"], more].concat());
    let (endless, took) = read(Rogue::Endless, &["--max-time", "700ms"]);
    assert!(took < MOST && endless.status == 1 && endless.stdout.is_empty(), "{took:?}: {}", endless.stderr);
    let says = "upload ended after 0 bytes: expected its end within 700 ms (--max-time raises the limit)";
    assert!(endless.stderr.contains(says), "{}", endless.stderr);
    for (more, most) in [(&[][..], "16777216"), (&["--max-size", "3k"], "3000")] {
        let (huge, took) = read(Rogue::Huge, more);
        assert!(took < MOST && huge.status == 1 && huge.stdout.is_empty(), "{took:?}: {}", huge.stderr);
        let says = format!(
            "upload ended after 0 of 4294967295 bytes: expected at most {most} bytes (--max-size raises the limit)"
        );
        assert!(huge.stderr.contains(&says), "{}", huge.stderr);
    }
}

#[test]
fn a_dictionary_of_endless_objects_is_described() {
    for (rogue, more, option) in
        [(Rogue::Huge, &[][..], "--max-size"), (Rogue::Endless, &["--max-time", "20ms"], "--max-time")]
    {
        let args = ["eds", "from-device", "BUS", "--node", "5", "--range", "2000", "--timeout", "300ms"];
        let (described, took) = on(rogue, &[&args[..], more].concat());
        assert!(took < Duration::from_secs(60) && described.status == 0, "{took:?}: {}", described.stderr);
        assert!(described.stdout.contains("[2000]"), "{}", described.stdout);
        let told = described.stderr.lines().filter(|line| line.contains(option)).count();
        assert!(
            told > 200 && described.stderr.contains("2000h:00: upload ended after 0"),
            "{told}: {}",
            described.stderr
        );
    }
}
