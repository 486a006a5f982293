//! Every command that asks a device comes to its end in time, whatever the device does.

use crate::rogues::Rogue;
use crate::running::{Run, command, finished};
use std::process::Stdio;
use std::time::{Duration, Instant};

/// Runs a command on a rogue; gives how long it took, too.
fn on(rogue: Rogue, args: &[&str]) -> (Run, Duration) {
    let bus = format!("slcan:tcp://{}", rogue.start().unwrap());
    let begun = Instant::now();
    let args: Vec<&str> = args.iter().map(|arg| if *arg == "BUS" { &*bus } else { arg }).collect();
    let child = command(&args).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    (finished(child.wait_with_output().unwrap()), begun.elapsed())
}

/// The time of the run, that of opening the adapter, and that of putting the device back.
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
