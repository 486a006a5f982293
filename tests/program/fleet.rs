//! `canvass fleet` runs `canvass-fleet`, for which a script stands in here.

use crate::running::{Run, finished};
use std::os::unix::fs::PermissionsExt as _;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// A script that prints its own name, its arguments and its standard input, and ends with status 7.
const STAND_IN: &str = "#!/bin/sh\nprintf '%s\\n' \"$0\" \"$@\"\ncat\necho told >&2\nexit 7\n";

fn stand_in(folder: &Path) -> PathBuf {
    let program = folder.join("canvass-fleet");
    std::fs::write(&program, STAND_IN).unwrap();
    std::fs::set_permissions(&program, std::fs::Permissions::from_mode(0o755)).unwrap();
    program
}

/// Puts `canvass` into a folder of its own.
fn canvass(folder: &Path) -> PathBuf {
    let program = folder.join("canvass");
    std::fs::hard_link(env!("CARGO_BIN_EXE_canvass"), &program)
        .or_else(|_| std::fs::copy(env!("CARGO_BIN_EXE_canvass"), &program).map(|_| ()))
        .unwrap();
    program
}

fn run(program: &Path, path: &Path, args: &[&str]) -> Run {
    let path = format!("{}:/usr/bin:/bin", path.display());
    let output = Command::new(program).arg("fleet").args(args).env("PATH", path).stdin(Stdio::null()).output();
    finished(output.unwrap())
}

#[test]
fn arguments_output_and_status_are_those_of_the_other_program() {
    let (own, other) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let (canvass, other_program) = (canvass(own.path()), stand_in(other.path()));
    let typed = ["sql", "SELECT 'a b'\nFROM x", "--format", "json", "--help", "-V", "--color", "x", "--", "-q"];
    let ended = run(&canvass, other.path(), &typed);
    let mut told: Vec<&str> = ended.stdout.split('\n').collect();
    assert_eq!(told.pop(), Some(""));
    assert_eq!(told.remove(0), other_program.display().to_string(), "from PATH");
    assert_eq!(told.join("\n"), typed.join("\n"));
    assert_eq!((ended.status, &*ended.stderr), (7, "told\n"));
}

#[test]
fn options_alone_are_the_other_programs_too() {
    let (own, other) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let canvass = canvass(own.path());
    stand_in(other.path());
    for option in ["--help", "-h", "--version", "-V"] {
        let ended = run(&canvass, other.path(), &[option]);
        assert_eq!((ended.status, ended.stdout.lines().nth(1)), (7, Some(option)));
    }
    assert_eq!(run(&canvass, other.path(), &[]).stdout.lines().count(), 1);
}

#[test]
fn the_one_beside_canvass_goes_before_that_of_the_path() {
    let (own, other) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let canvass = canvass(own.path());
    let beside = stand_in(own.path());
    stand_in(other.path());
    let ended = run(&canvass, other.path(), &["schema"]);
    assert_eq!(ended.stdout, format!("{}\nschema\n", beside.display()));
}

#[test]
fn without_it_the_error_says_how_to_get_it() {
    let (own, empty) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let ended = run(&canvass(own.path()), empty.path(), &["sql"]);
    assert_eq!((ended.status, &*ended.stdout), (2, ""));
    let how = "cargo build --release --manifest-path fleet/Cargo.toml";
    assert!(ended.stderr.starts_with("canvass: canvass-fleet, a separate program, is neither in"), "{}", ended.stderr);
    assert!(ended.stderr.contains(how), "{}", ended.stderr);
}

#[test]
fn one_that_can_not_be_run_is_told_of() {
    let (own, empty) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let canvass = canvass(own.path());
    let beside = stand_in(own.path());
    std::fs::set_permissions(&beside, std::fs::Permissions::from_mode(0o644)).unwrap();
    let ended = run(&canvass, empty.path(), &["sql"]);
    assert_eq!(ended.status, 2);
    assert!(ended.stderr.contains(&format!("can't run {}", beside.display())), "{}", ended.stderr);
}

#[test]
fn whoever_wants_parquet_is_told_where_to_get_it() {
    for command in ["decode", "signals", "diagnose"] {
        for format in ["parquet", "arrow"] {
            let ended = crate::running::run(&[command, "a.log", "--format", format]);
            assert_eq!((ended.status, &*ended.stdout), (2, ""));
            assert!(ended.stderr.contains("tip: canvass-fleet writes Parquet and Arrow"), "{}", ended.stderr);
        }
    }
    let ended = crate::running::run(&["decode", "a.log", "--format", "xml"]);
    assert!(ended.status == 2 && !ended.stderr.contains("fleet"), "{}", ended.stderr);
}
