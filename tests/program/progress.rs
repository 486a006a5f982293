//! The progress of reading a long capture.

use crate::running::command;
use std::fs::File;
use std::io::{Read, Write};
use std::process::{Child, Stdio};
use std::thread::JoinHandle;
use std::time::Duration;

/// A capture whose text output is larger than a pipe, and which is read in several pieces.
fn long_capture(folder: &tempfile::TempDir) -> String {
    let path = folder.path().join("long.log");
    let mut file = std::io::BufWriter::new(File::create(&path).unwrap());
    for n in 0..300_000 {
        writeln!(file, "({}.{:06}) can0 73F#05", n / 1_000, n % 1_000 * 1_000).unwrap();
    }
    path.display().to_string()
}

/// Reads everything until all writers have closed.
fn drain(mut from: impl Read + Send + 'static) -> JoinHandle<String> {
    std::thread::spawn(move || {
        let (mut bytes, mut chunk) = (Vec::new(), [0; 4096]);
        // The end of a terminal is an error.
        while let Ok(n @ 1..) = from.read(&mut chunk) {
            bytes.extend_from_slice(&chunk[..n]);
        }
        String::from_utf8_lossy(&bytes).into_owned()
    })
}

/// The standard error of a program whose standard output is not read until the progress must have appeared: even on a
/// fast machine the program can't finish before.
fn behind_a_slow_reader(args: &[&str], stderr: Stdio, seen: impl FnOnce(&mut Child) -> JoinHandle<String>) -> String {
    let mut child = {
        // Dropping the command closes its handles of the terminal.
        let mut command = command(args);
        command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(stderr).spawn().unwrap()
    };
    let seen = seen(&mut child);
    std::thread::sleep(Duration::from_millis(1_200));
    drain(child.stdout.take().unwrap()).join().unwrap();
    child.wait().unwrap();
    seen.join().unwrap()
}

/// The standard error of a program on a terminal.
fn on_terminal(args: &[&str]) -> String {
    let terminal = nix::pty::openpty(None, None).unwrap();
    let (slave, master) = (terminal.slave, File::from(terminal.master));
    behind_a_slow_reader(args, Stdio::from(slave), |_| drain(master))
}

#[test]
fn a_long_reading_tells_rate_and_time_left_on_a_terminal_only() {
    let folder = tempfile::tempdir().unwrap();
    let path = long_capture(&folder);
    let seen = on_terminal(&["decode", &path]);
    assert!(seen.contains(" MB/s, ") && seen.contains(" s left") && seen.contains(" MB ("), "{seen:?}");
    // The progress line is cleared at the end.
    assert!(seen.trim_end().ends_with("\x1b[K"), "{seen:?}");
    let unseen = behind_a_slow_reader(&["decode", &path], Stdio::piped(), |child| drain(child.stderr.take().unwrap()));
    assert!(!unseen.contains("left") && !unseen.contains('\r'), "{unseen}");
    let short = on_terminal(&["decode", "docs/examples/commissioning.log"]);
    assert!(!short.contains("left"), "{short:?}");
}
