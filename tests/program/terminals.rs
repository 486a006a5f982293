//! Terminals that are narrow, interpret no sequences, or show only ASCII.

use crate::running::command;
use nix::pty::{Winsize, openpty};
use std::fs::File;
use std::io::{Read, Write};
use std::process::Stdio;

const CAPTURE: &str = "docs/examples/commissioning.log";

/// Commands whose output people read.
const COMMANDS: &[&[&str]] = &[
    &["test", "sim:kuebler-sendix-58x8+boot-up-twice", "--select", "301/boot-up,406/cams"],
    &["decode", CAPTURE, "--device", "63=kuebler-sendix-58x8"],
    &["decode", CAPTURE, "--format", "table"],
    &["decode", CAPTURE, "--events"],
    &["diagnose", CAPTURE, "--verbose"],
    &["signals", CAPTURE, "--device", "63=kuebler-sendix-58x8"],
    &["monitor", "sim:kuebler-sendix-58x8", "--for", "500ms"],
    &["scan", "sim:kuebler-sendix-58x8"],
    &["sdo", "read", "sim:kuebler-sendix-58x8", "63", "position value"],
    &["fuzz", "sim:reference-301+sdo-toggle-unchecked", "--runs", "100", "--seed", "7", "--stop-at-first"],
    &["doctor"],
    &["list", "models"],
    &["list", "situations"],
    &["explain", "301/boot-up/reset-node"],
    &["selftest", "--fault", "boot-up-twice"],
    &["test", "--help"],
    &["help", "filter"],
    &["test", "no-such-bus"],
];

/// The bytes that the test writes after the end of the program. A terminal that no process has open any more may lose
/// unread bytes, so the test keeps the terminal open until it has read these bytes.
const END: &[u8] = b"\x04end of the program\x04";

/// Both output streams, as a terminal of `columns` columns receives them.
fn seen(columns: u16, variables: &[(&str, &str)], args: &[&str]) -> String {
    let size = Winsize { ws_row: 24, ws_col: columns, ws_xpixel: 0, ws_ypixel: 0 };
    let terminal = openpty(Some(&size), None).unwrap();
    let (slave, mut master) = (terminal.slave, File::from(terminal.master));
    let mut kept = File::from(slave.try_clone().unwrap());
    let mut child = {
        let mut command = command(args);
        // The variables of the test's own environment must not describe this terminal.
        for variable in ["LC_ALL", "LC_CTYPE", "LANG", "TERM", "COLUMNS", "CI", "CLICOLOR", "CLICOLOR_FORCE"] {
            command.env_remove(variable);
        }
        command.envs(variables.iter().copied()).stdin(Stdio::from(slave.try_clone().unwrap()));
        command.stdout(Stdio::from(slave.try_clone().unwrap())).stderr(Stdio::from(slave)).spawn().unwrap()
    };
    let reader = std::thread::spawn(move || {
        let (mut bytes, mut chunk) = (Vec::new(), [0; 4096]);
        while !bytes.ends_with(END) {
            match master.read(&mut chunk) {
                Ok(n @ 1..) => bytes.extend_from_slice(&chunk[..n]),
                ended => panic!("the terminal ended with {ended:?} after {:?}", String::from_utf8_lossy(&bytes)),
            }
        }
        bytes.truncate(bytes.len() - END.len());
        String::from_utf8(bytes).unwrap().replace("\r\n", "\n")
    });
    child.wait().unwrap();
    kept.write_all(END).unwrap();
    reader.join().unwrap()
}

/// The text without colours, and without the progress, which later lines overwrite.
fn plain(text: &str) -> String {
    let lines = text.split('\n').map(|line| line.rsplit("\x1b[K").next().unwrap_or_default());
    let text = lines.collect::<Vec<_>>().join("\n");
    text.split("\x1b[")
        .enumerate()
        .map(|(n, part)| if n == 0 { part } else { part.split_once('m').map_or("", |it| it.1) })
        .collect()
}

const USUAL: [(&str, &str); 2] = [("TERM", "xterm-256color"), ("LC_ALL", "C.UTF-8")];

#[test]
fn a_dumb_terminal_gets_no_sequences() {
    for args in COMMANDS {
        // The variables of pipelines do not switch colours on for a dumb terminal.
        let variables = [("TERM", "dumb"), ("LC_ALL", "C.UTF-8"), ("CI", "true"), ("CLICOLOR_FORCE", "1")];
        let text = seen(100, &variables, args);
        assert!(!text.is_empty() && !text.contains('\x1b'), "{args:?}: {text:?}");
        assert!(!text.contains('\r'), "{args:?}: {text:?}");
    }
    let refused = seen(100, &[("TERM", "dumb")], &["monitor", "sim:reference-301", "--screen", "--for", "1s"]);
    assert!(refused.contains("--screen needs a terminal") && !refused.contains('\x1b'), "{refused:?}");
    // Other terminals get colours.
    let colored = seen(100, &USUAL, COMMANDS[0]);
    assert!(colored.contains("\x1b[31m✗ fail"), "{colored:?}");
}

/// A terminal in the locale C gets ASCII. A pipe gets UTF-8 in any locale, as the reading programs expect.
#[test]
fn a_terminal_in_the_locale_c_gets_ascii() {
    for args in COMMANDS {
        let text = seen(100, &[("TERM", "xterm"), ("LC_ALL", "C")], args);
        let other: Vec<char> = text.chars().filter(|c| !c.is_ascii()).collect();
        assert!(!text.is_empty() && other.is_empty(), "{args:?}: {other:?}");
    }
    let text = plain(&seen(100, &[("TERM", "xterm"), ("LANG", "POSIX")], COMMANDS[0]));
    assert!(text.contains("x fail  301/boot-up/reset-node") && text.contains("| + pass "), "{text}");
    let piped = command(COMMANDS[0]).env("LC_ALL", "C").output().unwrap();
    assert!(String::from_utf8(piped.stdout).unwrap().contains("✗ fail"));
    // LC_ALL takes precedence over LANG, and without any variable the locale is not C.
    for variables in [&[("LANG", "C"), ("LC_ALL", "de_DE.UTF-8")][..], &[]] {
        assert!(seen(100, variables, COMMANDS[0]).contains("✗ fail"), "{variables:?}");
    }
}

/// Tables are no wider than 60 columns. Sentences and frames are longer, and the terminal wraps them.
#[test]
fn tables_fit_on_sixty_columns() {
    let is_table = |line: &&str| line.contains(['│', '┆', '─', '═']);
    let mut tables = 0;
    for args in COMMANDS {
        let text = plain(&seen(60, &USUAL, args));
        for line in text.lines().filter(is_table) {
            tables += 1;
            assert!(line.chars().count() <= 60, "{args:?}: {line}\nof {text}");
        }
    }
    assert!(tables > 60, "{tables}");
    // On narrow terminals, the table has only the time, CAN-ID, node and meaning of a frame.
    let table = plain(&seen(60, &USUAL, &["decode", CAPTURE, "--format", "table", "--time", "relative"]));
    assert!(table.starts_with("time         │ id  │ node │ meaning"), "{table}");
    let help = plain(&seen(60, &USUAL, &["test", "--help"]));
    assert!(help.lines().all(|line| line.chars().count() <= 60), "{help}");
}

/// The screen of `monitor`: a row for each CAN-ID with count, cycle, data and meaning; it fits on 60 columns, too.
#[test]
fn the_screen_has_a_row_for_each_can_id() {
    for columns in [120, 60] {
        let screen = ["monitor", "sim:kuebler-sendix-58x8", "--screen", "--for", "3s"];
        let text = seen(columns, &USUAL, &screen);
        for told in ["CAN-IDs", "73F", "cycle", "boot-up"] {
            assert!(text.contains(told), "{columns}: {told}: {text:?}");
        }
        // The program restores the terminal.
        assert!(text.contains("\x1b[?1049h") && text.contains("\x1b[?1049l"), "{text:?}");
    }
}
