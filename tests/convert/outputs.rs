//! The choice of the output file and its format.

use crate::command::{Folder, ended, sample};
use crate::recording;
use crate::rows::rows;
use std::io::{BufRead, BufReader, Write};
use std::process::Stdio;

const LOG: &str = "(1700000000.000001) can0 123#1122334455667788\n(1700000000.000002) can0 124#01\n";

#[test]
fn the_extension_tells_the_format_and_to_wins() {
    let folder = Folder::new().with("in.log", LOG);
    folder.good("convert in.log out.csv");
    assert!(folder.read("out.csv").starts_with("timestamp,"));
    folder.good("convert in.log out2.csv --to candump");
    assert_eq!(folder.read("out2.csv"), LOG);
    let (status, _, errors) = folder.run("convert in.log out");
    assert_eq!(status, 2);
    assert!(errors.contains("--to with one of pcapng, pcap"), "{errors}");
    let (status, out, _) = folder.run("convert in.log --to candump -");
    assert_eq!((status, out.as_str()), (0, LOG));
    let (status, _, errors) = folder.run("convert in.log --to minimon -");
    assert_eq!(status, 2);
    assert!(errors.contains("minimon can be read, but not written; choose another format with --to"), "{errors}");
    assert_eq!(folder.run("convert in.log --to xlsx -").0, 2);
    assert_eq!(folder.run("convert in.log --to csv --to asc -").0, 2);
    assert_eq!(folder.run("convert in.log").0, 2);
}

#[test]
fn compressed_where_the_name_says_so() {
    let folder = Folder::new().with("in.log", recording::log());
    for (name, magic) in [("out.log.gz", &b"\x1F\x8B"[..]), ("out.pcapng.zst", b"\x28\xB5\x2F\xFD")] {
        folder.good(&format!("convert in.log {name}"));
        assert!(std::fs::read(folder.path(name)).unwrap().starts_with(magic));
        assert_eq!(rows(&folder.path(name)), rows(&folder.path("in.log")), "{name}");
    }
}

#[test]
fn nothing_is_overwritten_unasked() {
    let folder = Folder::new().with("in.log", LOG).with("out.log", "precious");
    let (status, _, errors) = folder.run("convert in.log out.log");
    assert_eq!((status, errors.as_str()), (2, "canvass: out.log exists: give --force to overwrite it\n"));
    assert_eq!(folder.read("out.log"), "precious");
    folder.good("convert in.log out.log --force");
    assert_eq!(folder.read("out.log"), LOG);
    let (status, _, errors) = folder.run("convert in.log in.log --force");
    assert_eq!(status, 2);
    assert!(errors.contains("can't be written at the same time"), "{errors}");
    assert_eq!(folder.read("in.log"), LOG);
}

#[test]
fn unreadable_input_leaves_no_file_and_touches_none() {
    let folder = Folder::new().with("junk", "no capture at all").with("out.log", "precious");
    assert_eq!(folder.run("convert junk new.log").0, 2);
    assert_eq!(folder.run("convert nosuch out.log --force").0, 2);
    assert!(!folder.path("new.log").exists());
    assert_eq!(folder.read("out.log"), "precious");
}

#[test]
fn damage_is_reported_and_the_rest_converted() {
    let damaged = format!("{LOG}rubbish\n{LOG}");
    let folder = Folder::new().with("in.log", damaged);
    let errors = folder.good("convert in.log out.log");
    assert!(errors.starts_with("in.log:3:1: malformed"), "{errors}");
    assert_eq!(folder.read("out.log"), format!("{LOG}{LOG}"));
    let (status, _, errors) = folder.run("convert in.log --strict strict.pcapng");
    assert_eq!(status, 2);
    assert!(errors.contains("in.log: stopped there"), "{errors}");
    assert_eq!(rows(&folder.path("strict.pcapng")).len(), 2, "what was written is a valid file");
}

#[test]
fn a_capture_without_frames_becomes_one_without_frames() {
    let folder = Folder::new().with("in.log", LOG);
    for format in canvass_traces::Format::all().filter(|format| format.is_written()) {
        folder.good(&format!("convert in.log --channel can7 --force out --to {format}"));
        // A log without lines is an empty file.
        if format != canvass_traces::Format::Candump {
            assert_eq!(rows(&folder.path("out")), [], "{format}");
        }
    }
}

#[test]
fn every_sample_converts() {
    let folder = Folder::new();
    let samples = std::fs::read_dir(sample("")).unwrap().map(|entry| entry.unwrap().path());
    let is_capture = |path: &std::path::Path| {
        !["md", "py", "frames"].iter().any(|other| path.extension().is_some_and(|extension| extension == *other))
    };
    for path in samples.filter(|path| is_capture(path)) {
        let output = folder.command("convert --force --to pcapng").arg(&path).arg("out").output().unwrap();
        let (status, _, errors) = ended(&output);
        assert_eq!(status, 0, "{}: {errors}", path.display());
        assert!(!rows(&folder.path("out")).is_empty(), "{}", path.display());
    }
}

#[test]
fn a_live_frame_comes_out_at_once() {
    let folder = Folder::new();
    for args in ["convert - --to candump -", "decode - --format json"] {
        let mut command = folder.command(args);
        let mut child = command.stdin(Stdio::piped()).stdout(Stdio::piped()).spawn().unwrap();
        let mut stdin = child.stdin.take().unwrap();
        let mut lines = BufReader::new(child.stdout.take().unwrap()).lines();
        for line in LOG.lines() {
            writeln!(stdin, "{line}").unwrap();
            assert!(lines.next().unwrap().unwrap().contains("can0"), "{args}");
        }
        drop(stdin);
        assert!(child.wait().unwrap().success());
    }
}

#[cfg(unix)]
#[test]
fn ctrl_c_ends_the_file() {
    let folder = Folder::new();
    let mut command = folder.command("convert - live.mcap");
    let mut child = command.stdin(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let mut stdin = child.stdin.take().unwrap();
    stdin.write_all(LOG.as_bytes()).unwrap();
    stdin.write_all(b"(1700000000.000003) can0 12").unwrap();
    // The program creates the file after it has read the first line.
    while !folder.path("live.mcap").exists() {
        std::thread::sleep(std::time::Duration::from_millis(10));
    }
    std::thread::sleep(std::time::Duration::from_millis(200));
    let kill = std::process::Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap();
    assert!(kill.success());
    let (status, _, errors) = ended(&child.wait_with_output().unwrap());
    drop(stdin);
    assert_eq!((status, errors.as_str()), (0, ""), "the line under way is no damage");
    assert_eq!(rows(&folder.path("live.mcap")).len(), 2);
}
