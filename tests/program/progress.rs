//! How far a long reading is, for those who wait for it.

use crate::running::{command, run};
use std::fs::File;
use std::io::{Read, Write};
use std::process::Stdio;

/// A capture that takes a program without optimisation some seconds, also on a fast machine.
fn long_capture(folder: &tempfile::TempDir) -> String {
    let path = folder.path().join("long.log");
    let mut file = std::io::BufWriter::new(File::create(&path).unwrap());
    for n in 0..1_600_000 {
        writeln!(file, "({}.{:06}) can0 73F#05", n / 1_000, n % 1_000 * 1_000).unwrap();
    }
    path.display().to_string()
}

/// What a terminal gets on standard error, while standard output is none.
fn on_terminal(args: &[&str]) -> String {
    let terminal = nix::pty::openpty(None, None).unwrap();
    let (slave, mut master) = (terminal.slave, File::from(terminal.master));
    let mut child = {
        // What it holds of the terminal goes with it.
        let mut command = command(args);
        command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::from(slave)).spawn().unwrap()
    };
    let reader = std::thread::spawn(move || {
        let (mut bytes, mut chunk) = (Vec::new(), [0; 4096]);
        // The end of a terminal is an error.
        while let Ok(n @ 1..) = master.read(&mut chunk) {
            bytes.extend_from_slice(&chunk[..n]);
        }
        String::from_utf8_lossy(&bytes).into_owned()
    });
    child.wait().unwrap();
    reader.join().unwrap()
}

#[test]
fn a_long_reading_tells_rate_and_time_left_on_a_terminal_only() {
    let folder = tempfile::tempdir().unwrap();
    let path = long_capture(&folder);
    let seen = on_terminal(&["diagnose", &path]);
    assert!(seen.contains(" MB/s, ") && seen.contains(" s left") && seen.contains(" MB ("), "{seen:?}");
    // The line is taken away at the end.
    assert!(seen.trim_end().ends_with("\x1b[K"), "{seen:?}");
    let unseen = run(&["diagnose", &path]);
    assert!(!unseen.stderr.contains("left") && !unseen.stderr.contains('\r'), "{}", unseen.stderr);
    let short = on_terminal(&["decode", "docs/examples/commissioning.log"]);
    assert!(!short.contains("left"), "{short:?}");
}
