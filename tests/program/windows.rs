//! Differences of Windows: paths, line ends, wildcards, the console, and files that other programs have open.

use crate::running::{command, finished, run};
use std::fs;
use std::os::windows::fs::OpenOptionsExt;
use std::path::Path;
use std::process::Stdio;
use tempfile::TempDir;

const LOG: &str = "(1700000000.000000) can0 701#05\r\n(1700000001.000000) can0 702#7F\r\n";

/// A folder with two captures that have line ends of Windows.
fn captures() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::create_dir(folder.path().join("Messungen für März")).unwrap();
    for name in ["a.log", "b.log", "Messungen für März/c.log"] {
        fs::write(folder.path().join(name), LOG).unwrap();
    }
    folder
}

fn text(path: &Path) -> &str {
    path.to_str().unwrap()
}

#[test]
fn paths_have_backslashes_drives_and_any_letters() {
    let folder = captures();
    let path = folder.path().join(r"Messungen für März\c.log");
    let drive = fs::canonicalize(&path).unwrap();
    assert!(text(&drive).starts_with(r"\\?\"), "{}", drive.display());
    // The path as it is, with slashes, and in the form of long paths.
    for path in [text(&path), &text(&path).replace('\\', "/"), text(&drive)] {
        let decoded = run(&["decode", path]);
        assert_eq!((decoded.status, decoded.stdout.lines().count()), (0, 2), "{path}: {}", decoded.stderr);
    }
    let out = folder.path().join(r"Messungen für März\öffnen.trc");
    let converted = run(&["convert", text(&path), text(&out)]);
    assert_eq!(converted.status, 0, "{}", converted.stderr);
    assert_eq!(run(&["decode", text(&out)]).stdout.lines().count(), 2);
    // The program distinguishes `NODE=` and `FORMAT=` before a path from a drive letter.
    let eds = folder.path().join("device.eds");
    fs::copy("conformance/device/models/reference-301.eds", &eds).unwrap();
    let described = run(&["decode", text(&path), "--device", &format!("1={}", eds.display())]);
    assert_eq!(described.status, 0, "{}", described.stderr);
    let report = folder.path().join("report.html");
    let simulated = format!("sim:{}", eds.display());
    let html = format!("html={}", report.display());
    let tested = run(&["test", &simulated, "--select", "301/boot-up/reset-node", "--report", &html]);
    assert!(tested.status < 2 && report.exists(), "{}", tested.stderr);
}

#[test]
fn the_program_finds_files_by_pattern_as_the_shells_leave_that_to_it() {
    let folder = captures();
    let run = |args: &[&str]| finished(command(args).current_dir(folder.path()).stdin(Stdio::null()).output().unwrap());
    assert_eq!(run(&["decode", "*.log"]).stdout.lines().count(), 4);
    assert_eq!(run(&["decode", "?.log", "Messungen*\\*.log"]).stdout.lines().count(), 6);
    let none = run(&["decode", "*.blf"]);
    assert!(none.status == 2 && none.stderr.contains("*.blf"), "{}", none.stderr);
}

#[test]
fn lines_end_either_way() {
    let folder = captures();
    let path = folder.path().join("a.log");
    let with = run(&["decode", text(&path), "--format", "json"]).stdout;
    fs::write(&path, LOG.replace("\r\n", "\n")).unwrap();
    assert!(!with.is_empty() && run(&["decode", text(&path), "--format", "json"]).stdout == with, "{with}");
    let eds = fs::read_to_string("conformance/device/models/reference-301.eds").unwrap().replace("\r\n", "\n");
    let path_of_eds = folder.path().join("a.eds");
    let check = |content: &str| {
        fs::write(&path_of_eds, content).unwrap();
        run(&["eds", "check", text(&path_of_eds), "--format", "json"]).stdout
    };
    assert_eq!(check(&eds), check(&eds.replace('\n', "\r\n")));
    // The output has the same line ends on all systems.
    assert!(!run(&["decode", text(&path)]).stdout.contains('\r'));
}

/// Windows does not replace a file that another program has open without sharing it: the old content stays, and the
/// program reports it.
#[test]
fn a_file_that_another_program_has_open_is_not_replaced() {
    let folder = captures();
    let (path, out) = (folder.path().join("a.log"), folder.path().join("out.trc"));
    fs::write(&out, "mine").unwrap();
    let open = fs::OpenOptions::new().read(true).write(true).share_mode(0).open(&out).unwrap();
    let refused = run(&["convert", text(&path), text(&out), "--force"]);
    assert!(refused.status == 2 && refused.stderr.contains("out.trc"), "{}", refused.stderr);
    drop(open);
    assert_eq!(fs::read_to_string(&out).unwrap(), "mine");
    let replaced = run(&["convert", text(&path), text(&out), "--force"]);
    assert_eq!(replaced.status, 0, "{}", replaced.stderr);
    assert_ne!(fs::read_to_string(&out).unwrap(), "mine");
    let names = fs::read_dir(folder.path()).unwrap().map(|entry| entry.unwrap().file_name());
    assert!(names.into_iter().all(|name| !name.to_string_lossy().ends_with(".part")), "nothing is left behind");
}

#[test]
fn names_that_differ_in_case_are_one_file() {
    let folder = captures();
    let path = folder.path().join("a.log");
    for (args, says) in [
        (vec!["convert".to_owned(), text(&path).to_owned(), text(&path).replace("a.log", "A.LOG")], "is read"),
        (
            vec![
                "record".to_owned(),
                "sim:reference-301".to_owned(),
                "--for".to_owned(),
                "1s".to_owned(),
                text(&folder.path().join("r.log")).to_owned(),
                text(&folder.path().join("R.LOG")).to_owned(),
            ],
            "r.log",
        ),
    ] {
        let args: Vec<&str> = args.iter().map(String::as_str).collect();
        let refused = run(&[&args[..], &["--force"]].concat());
        assert!(refused.status == 2 && refused.stderr.contains(says), "{args:?}: {}", refused.stderr);
    }
}

/// Uses two joined serial ports if `CANVASS_NULL_MODEM` names them: each end is the adapter of the other.
#[test]
fn a_device_is_asked_through_serial_ports() {
    let Ok(ports) = std::env::var("CANVASS_NULL_MODEM") else { return };
    let (near, far) = ports.split_once(',').unwrap();
    let far = format!("slcan:{far}");
    let mut device = command(&["simulate", "kuebler-sendix-58x8", &far]).stderr(Stdio::piped()).spawn().unwrap();
    let near = format!("slcan:{near}@250k");
    let read = || run(&["sdo", "read", &near, "63", "1008", "--device", "kuebler-sendix-58x8", "--timeout", "500ms"]);
    let answers = (0..20).map(|_| read()).find(|read| read.status == 0);
    device.kill().unwrap();
    let ended = finished(device.wait_with_output().unwrap());
    assert!(answers.is_some_and(|read| read.stdout.contains("Kuebler Sendix Encoder")), "{}", ended.stderr);
}

#[test]
fn a_serial_port_is_named_as_windows_names_it() {
    let absent = run(&["scan", "slcan:COM97@250k"]);
    assert_eq!(absent.status, 3, "{}", absent.stderr);
    assert!(absent.stderr.contains("can't open COM97") && absent.stderr.contains("doctor"), "{}", absent.stderr);
    let doctor = run(&["doctor"]).stdout;
    assert!(doctor.contains("serial ports") && doctor.contains("pcan:CHANNEL"), "{doctor}");
}
