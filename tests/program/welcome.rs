//! The first minutes: the program without a command, the tour, the examples.

use crate::running::{Run, finished, run};
use std::path::Path;
use std::process::{Command, Stdio};

fn run_in(folder: &Path, args: &[&str]) -> Run {
    let mut command = Command::new(env!("CARGO_BIN_EXE_canvass"));
    finished(command.args(args).current_dir(folder).stdin(Stdio::null()).output().unwrap())
}

#[test]
fn without_a_command_it_tells_what_can_be_done_here() {
    let folder = tempfile::tempdir().unwrap();
    let empty = run_in(folder.path(), &[]);
    assert_eq!((empty.status, &*empty.stderr), (0, ""));
    assert!(empty.stdout.contains("canvass tour") && !empty.stdout.contains("In this folder"), "{}", empty.stdout);
    std::fs::write(folder.path().join("a b.log"), "(1.0) can0 705#00\n").unwrap();
    let told = run_in(folder.path(), &[]).stdout;
    let command = told.lines().find_map(|line| line.split_once("canvass diagnose ")).map(|(_, rest)| rest.to_owned());
    assert!(command.is_some_and(|rest| rest.starts_with("'./a b.log' ")), "{told}");
    // What is typed wrong is still an error.
    assert_eq!(run(&["diagnoes"]).status, 2);
}

#[test]
fn how_it_was_built_is_told() {
    let told = run(&["--version", "--verbose"]);
    assert_eq!((told.status, &*told.stderr), (0, ""));
    let names: Vec<&str> = told.stdout.lines().map(|line| line.split(' ').next().unwrap()).collect();
    assert_eq!(names, ["canvass", "commit", "target", "features", "optimised"]);
    assert_eq!(run(&["--version"]).stdout.lines().count(), 1);
}

/// Every command of the examples runs on the example files.
#[test]
fn examples_can_be_tried() {
    let folder = tempfile::tempdir().unwrap();
    let told = run_in(folder.path(), &["examples", "here"]);
    assert_eq!(told.status, 0, "{}", told.stderr);
    let commands: Vec<&str> = told.stdout.lines().filter_map(|line| line.trim().strip_prefix("canvass ")).collect();
    assert_eq!(commands.len(), 5, "{}", told.stdout);
    for command in commands {
        let args: Vec<&str> = command.split(' ').collect();
        let args: Vec<&str> = if args[0] == "test" { [&args[..], &["--select", "301/boot-up"]].concat() } else { args };
        let ran = run_in(folder.path(), &args);
        assert!(ran.status < 2 && !ran.stdout.is_empty(), "{command}: {}", ran.stderr);
    }
    let again = run_in(folder.path(), &["examples", "here"]);
    assert_eq!(again.status, 2);
    assert!(again.stderr.contains("exists already"), "{}", again.stderr);
}

/// The tour runs to its end and leaves what it promises; the fault is found.
#[test]
fn the_tour_shows_a_fault() {
    let folder = tempfile::tempdir().unwrap();
    let told = run_in(folder.path(), &["tour"]);
    assert_eq!(told.status, 0, "{}", told.stderr);
    for station in 1..=6 {
        assert!(told.stdout.contains(&format!("\n{station}/6  ")), "{}", told.stdout);
    }
    assert!(
        told.stdout.contains("fail  301/boot-up/reset-node") && told.stdout.contains("Position value"),
        "{}",
        told.stdout
    );
    let report = std::fs::read_to_string(folder.path().join("canvass-tour/report.html")).unwrap();
    assert!(report.contains("301/boot-up/reset-node"));
    assert!(folder.path().join("canvass-tour/run.log").metadata().unwrap().len() > 1000);
    assert_eq!(run_in(folder.path(), &["tour"]).status, 2, "nothing is overwritten");
}
