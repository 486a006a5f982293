//! The first signal ends reading from inputs that never end or never begin.

use crate::running::{command, finished};
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// Runs a command, and sends it a signal after a moment; returns its exit status and messages.
fn signalled(args: &[&str], signal: &str) -> (i32, String) {
    let child = command(args).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    std::thread::sleep(Duration::from_millis(300));
    let begun = Instant::now();
    let sent = Command::new("kill").args([signal, &child.id().to_string()]).status();
    assert!(sent.unwrap().success());
    let run = finished(child.wait_with_output().unwrap());
    assert!(begun.elapsed() < Duration::from_secs(5), "{args:?}");
    (run.status, run.stderr)
}

/// Nothing writes into the named pipe: even opening it would wait for ever.
#[test]
fn a_pipe_without_a_writer() {
    let folder = tempfile::tempdir().unwrap();
    let pipe = folder.path().join("pipe");
    assert!(Command::new("mkfifo").arg(&pipe).status().unwrap().success());
    let pipe = pipe.to_str().unwrap();
    let out = folder.path().join("out.log");
    for signal in ["-INT", "-TERM"] {
        for args in [vec!["decode", pipe], vec!["diagnose", pipe], vec!["convert", pipe, out.to_str().unwrap()]] {
            let (status, errors) = signalled(&args, signal);
            assert_eq!((status, &*errors), (2, "canvass: interrupted before any input arrived\n"), "{args:?}");
        }
    }
    assert!(!out.exists());
}

/// A file of the kernel that claims to be regular and empty. A program that has read all of it waits for more.
#[test]
fn a_file_of_the_kernel_that_waits() {
    let file = Path::new("/proc/kmsg");
    if std::fs::File::open(file).is_err() {
        // Only root may open this file.
        return;
    }
    let (_, errors) = signalled(&["decode", "/proc/kmsg", "--format-in", "candump"], "-INT");
    assert!(!errors.contains("panic"), "{errors}");
}

/// Data written into a named pipe are decoded as from standard input.
#[test]
fn a_pipe_with_a_writer_is_read_to_its_end() {
    let folder = tempfile::tempdir().unwrap();
    let pipe = folder.path().join("pipe");
    assert!(Command::new("mkfifo").arg(&pipe).status().unwrap().success());
    let child = command(&["decode", pipe.to_str().unwrap()]).stdout(Stdio::piped()).spawn().unwrap();
    std::fs::write(&pipe, "(1700000000.000000) can0 701#05\n").unwrap();
    let run = finished(child.wait_with_output().unwrap());
    assert_eq!((run.status, run.stdout.lines().count()), (0, 1), "{}", run.stdout);
}
