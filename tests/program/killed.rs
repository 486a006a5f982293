//! Ctrl-C at any moment: the run leaves the device as it found it. SIGKILL at any moment: the journal of the run
//! restores the device. The device is a separate process, so that its values can be read after the tester has gone.

use crate::live::Device;
use crate::running::{command, finished, run};
use serde_json::Value;
use std::path::Path;
use std::process::{Child, Stdio};
use std::time::Duration;

/// Number of runs that are interrupted.
#[cfg(unix)]
const INTERRUPTED: u64 = 100;
/// Number of runs that are killed.
const KILLED: u64 = 50;
/// Number of devices that are tested at the same time. It is large, as most of the time is waiting.
const DEVICES: u64 = 10;
/// One of [`AT_ANY_MOMENT`] runs ends at a moment that is counted from its start, which may be before its first case.
/// For the other runs, the moment is counted from the beginning of the first case.
const AT_ANY_MOMENT: u64 = 7;

/// Objects that get a new value without being stored: communication parameters (1017h, 1006h, 1016h:01), a parameter
/// of a PDO, and an application object with limits (2041h).
const AT_WORK: [(&str, &str); 5] =
    [("1017", "1000"), ("1800:05", "500"), ("1006", "20000"), ("2041", "321"), ("1016:01", "6619236")];

/// The way in which a run ends early.
#[derive(Clone, Copy, PartialEq, Eq)]
enum End {
    /// By Ctrl-C of the user.
    #[cfg(unix)]
    Interrupted,
    /// By SIGKILL, without notice.
    Killed,
}

/// The time after which a run ends: different for every kill, the same in every run of this test.
fn moment(kill: u64) -> Duration {
    let chance = kill.wrapping_mul(0x9E37_79B9_7F4A_7C15).rotate_left(31).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    Duration::from_millis(200 + (chance >> 33) % 4_000)
}

/// Waits until the journal exists: on a busy machine the steps before the first case take seconds.
fn wait_for_a_case(run: &mut Child, journal: &Path) {
    while !journal.exists() && run.try_wait().unwrap().is_none() {
        std::thread::sleep(Duration::from_millis(5));
    }
}

/// All readable objects, as another run of the program finds them before its first case.
fn dictionary(bus: &str) -> Value {
    let args = [
        "test",
        bus,
        "--device",
        "reference-301",
        "--select",
        "301/identity/vendor-id",
        "--format",
        "json",
        "--journal",
        "none",
    ];
    let tested = run(&args);
    let report: Value =
        serde_json::from_str(&tested.stdout).unwrap_or_else(|error| panic!("{error}: {}", tested.stderr));
    // These objects change by themselves: errors and clocks.
    let steady = |row: &&Value| !matches!(row["index"].as_u64(), Some(0x1001 | 0x1003 | 0x1013 | 0x2020));
    Value::Array(report["dictionary"].as_array().unwrap().iter().filter(steady).cloned().collect())
}

/// The dictionary, read again until two readings agree: on a very slow machine an answer may come too late.
fn settled(bus: &str) -> Value {
    let mut last = dictionary(bus);
    for _ in 0..5 {
        let next = dictionary(bus);
        if next == last {
            return last;
        }
        last = next;
    }
    last
}

fn write(bus: &str, object: &str, value: &str) {
    let written = run(&["sdo", "write", bus, "10", object, value, "--device", "reference-301"]);
    assert_eq!(written.status, 0, "{object}: {}", written.stderr);
}

/// Ends one run after the other on one device. Returns the differences that the runs left behind, and the number of
/// runs with a journal.
fn kill(first: u64, kills: u64, end: End) -> (Vec<String>, u64) {
    let folder = tempfile::tempdir().unwrap();
    let journal = folder.path().join("journal");
    let journal_path = journal.to_str().unwrap();
    let mut restored = 0;
    let device = Device::of("reference-301", &[]);
    for (object, value) in AT_WORK {
        write(&device.bus, object, value);
    }
    let before = settled(&device.bus);
    let mut wrong = Vec::new();
    for number in (first..kills).step_by(DEVICES as usize) {
        let allow = "nvm,node-id,bit-rate,other-nodes,factory-defaults,preset";
        let args = [
            "test",
            &device.bus,
            "--device",
            "reference-301",
            "--allow",
            allow,
            "--format",
            "json",
            "--journal",
            journal_path,
        ];
        let mut child = command(&args).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        if number % AT_ANY_MOMENT != 0 {
            wait_for_a_case(&mut child, &journal);
        }
        std::thread::sleep(moment(number));
        match end {
            #[cfg(unix)]
            End::Interrupted => assert!(crate::running::interrupt(&child)),
            End::Killed => child.kill().unwrap(),
        }
        let ended = finished(child.wait_with_output().unwrap());
        let cases = serde_json::from_str::<Value>(&ended.stdout).ok();
        let last = cases.and_then(|report| report["cases"].as_array()?.last().map(|case| case["id"].to_string()));
        assert!(end == End::Killed || !journal.exists(), "a run that puts the device back itself leaves no journal");
        if journal.exists() {
            restored += 1;
            let again = run(&["test", &device.bus, "--device", "reference-301", "--journal", journal_path]);
            assert_eq!((again.status, again.stderr.contains("canvass restore")), (2, true), "{}", again.stderr);
            let told = std::fs::read_to_string(&journal).unwrap();
            let put_back = run(&["restore", &device.bus, "--journal", journal_path]);
            if put_back.status != 0 {
                let kept: Vec<&str> = told.lines().skip_while(|line| *line != "begun").collect();
                wrong.push(format!("kill {number}: {}{}", put_back.stderr, kept.join("\n")));
                let _ = std::fs::remove_file(&journal);
            }
        }
        let mut after = dictionary(&device.bus);
        if after != before {
            after = settled(&device.bus);
        }
        if after != before {
            let rows = |dictionary: &Value| dictionary.as_array().unwrap().clone();
            let changed: Vec<String> =
                rows(&after).iter().filter(|row| !rows(&before).contains(row)).map(ToString::to_string).collect();
            wrong.push(format!("kill {number} after {:?} in {last:?}: {changed:?}\n{}", moment(number), ended.stderr));
        }
    }
    (wrong, restored)
}

/// Ends runs on all devices. Returns the number of runs that left a journal.
fn kill_all(kills: u64, end: End) -> u64 {
    let ends: Vec<(Vec<String>, u64)> = std::thread::scope(|scope| {
        let threads: Vec<_> = (0..DEVICES).map(|first| scope.spawn(move || kill(first, kills, end))).collect();
        threads.into_iter().map(|thread| thread.join().unwrap()).collect()
    });
    let wrong: Vec<&str> = ends.iter().flat_map(|(wrong, _)| wrong).map(String::as_str).collect();
    assert!(wrong.is_empty(), "{} of {kills}:\n{}", wrong.len(), wrong.join("\n"));
    ends.iter().map(|(_, restored)| restored).sum()
}

/// Runs a command at a terminal whose user gives this answer; returns its status and messages.
#[cfg(unix)]
fn answered(args: &[&str], answer: &str) -> (i32, String) {
    use std::io::{Read, Write};
    let terminal = nix::pty::openpty(None, None).unwrap();
    let side = || Stdio::from(terminal.slave.try_clone().unwrap());
    let mut child = command(args).stdin(side()).stdout(Stdio::null()).stderr(side()).spawn().unwrap();
    let mut user = std::fs::File::from(terminal.master);
    let mut listener = user.try_clone().unwrap();
    let told = std::thread::spawn(move || {
        let mut told = Vec::new();
        // Reading ends with an error when no process holds the terminal any more.
        let _ = listener.read_to_end(&mut told);
        String::from_utf8_lossy(&told).into_owned()
    });
    // The terminal keeps the answer until the program reads it.
    writeln!(user, "{answer}").unwrap();
    let status = child.wait().unwrap().code().unwrap();
    drop(terminal.slave);
    (status, told.join().unwrap())
}

#[cfg(unix)] // the question is asked on a pseudo-terminal
#[test]
fn at_a_terminal_the_next_run_asks_whether_to_put_the_device_back() {
    const QUESTION: &str = "Restore the device first? [Y/n]";
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("journal");
    let device = Device::of("reference-301", &[]);
    AT_WORK.iter().for_each(|(object, value)| write(&device.bus, object, value));
    let before = dictionary(&device.bus);
    let journal = ["--device", "reference-301", "--journal", path.to_str().unwrap()];
    let args = [&["test", &device.bus][..], &journal].concat();
    let mut run = command(&args).stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
    wait_for_a_case(&mut run, &path);
    std::thread::sleep(moment(1));
    run.kill().unwrap();
    run.wait().unwrap();
    assert!(path.exists(), "a killed run leaves its journal");

    let again = [&["test", &device.bus, "--select", "301/identity/vendor-id"][..], &journal].concat();
    let (status, told) = answered(&again, "n");
    assert!(status == 2 && told.contains(QUESTION) && told.contains("canvass restore"), "{status}: {told}");
    assert!(path.exists(), "nothing was put back");
    let (status, told) = answered(&again, "");
    assert!(status == 0 && told.contains(QUESTION), "{status}: {told}");
    assert!(!path.exists(), "the device was put back");
    assert_eq!(dictionary(&device.bus), before);
}

#[cfg(unix)] // a signal: `cargo xtask windows` presses Ctrl-C on a console
#[test]
fn an_interrupted_run_leaves_the_device_as_it_was() {
    assert_eq!(kill_all(INTERRUPTED, End::Interrupted), 0);
}

#[test]
fn the_journal_of_a_killed_run_puts_the_device_back() {
    let restored = kill_all(KILLED, End::Killed);
    assert!(restored > KILLED / 2, "only {restored} runs had begun a case");
}
