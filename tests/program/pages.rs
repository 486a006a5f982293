//! The terminal sessions in the documentation agree with the program.

use std::path::Path;
use std::process::{Command, Stdio};

const ROOT: &str = env!("CARGO_MANIFEST_DIR");

/// A command with the output shown below it.
struct Shown {
    command: String,
    lines: Vec<String>,
}

/// The commands of a page that are shown with output.
fn shown(page: &str) -> Vec<Shown> {
    let mut all: Vec<Shown> = Vec::new();
    for block in page.split("\n```").skip(1).step_by(2).filter(|block| block.contains("\n$ canvass")) {
        for line in block.lines().skip(1) {
            match (line.strip_prefix("$ "), all.last_mut()) {
                (Some(command), _) => all.push(Shown { command: command.to_owned(), lines: Vec::new() }),
                (None, Some(last)) => last.lines.push(line.to_owned()),
                (None, None) => {}
            }
        }
    }
    all
}

/// The output of a command and its exit status, in a folder that has the samples; a simulated encoder stands in for a
/// device on vcan0.
fn printed(folder: &Path, command: &str) -> (String, Option<i32>) {
    let program = Path::new(env!("CARGO_BIN_EXE_canvass")).parent().unwrap();
    let path = format!("{}:{}", program.display(), std::env::var("PATH").unwrap());
    let command = command.replace("vcan0", "sim:kuebler-sendix-58x8");
    let mut shell = Command::new("sh");
    shell.args(["-c", &command]).current_dir(folder).env("PATH", path).stdin(Stdio::null());
    let ended = shell.output().unwrap();
    (String::from_utf8([ended.stdout, ended.stderr].concat()).unwrap(), ended.status.code())
}

/// A line without the time of its frame, which a later version may change.
fn timeless(line: &str) -> String {
    let is_time = |text: &str| text.len() > 9 && text.chars().all(|c| c.is_ascii_digit() || c == '.');
    match line.split_once('(').and_then(|(before, rest)| Some((before, rest.split_once(") ")?))) {
        Some((before, (time, rest))) if is_time(time) => format!("{before}{rest}"),
        _ => line.trim_end().to_owned(),
    }
}

/// The exit status that a shown line names.
fn status(line: &str) -> Option<i32> {
    line.strip_prefix("(exit status ")?.strip_suffix(')')?.parse().ok()
}

/// Checks that the program prints the shown lines in their order; `…` stands for further lines.
fn check(page: &str, folder: &Path, at_least: usize) {
    let text = std::fs::read_to_string(Path::new(ROOT).join(page)).unwrap();
    let mut lines = 0;
    for Shown { command, lines: shown } in shown(&text) {
        let (printed, ended) = printed(folder, &command);
        let mut rest = printed.lines();
        for line in shown.iter().filter(|line| !line.trim().is_empty() && line.trim() != "…") {
            lines += 1;
            if let Some(status) = status(line) {
                assert_eq!(ended, Some(status), "{page}: {command}\n{printed}");
                continue;
            }
            let begins = timeless(line.trim_end_matches('…').trim_end());
            assert!(
                rest.any(|printed| timeless(printed).starts_with(&begins)),
                "{page}: {command}\nshows, and does not print:\n{line}\n\n{printed}"
            );
        }
    }
    assert!(lines >= at_least, "{page}: {lines}");
}

#[test]
fn terminals_in_the_documentation_are_real() {
    let folder = tempfile::tempdir().unwrap();
    for name in ["traces", "docs", "conformance"] {
        std::os::unix::fs::symlink(Path::new(ROOT).join(name), folder.path().join(name)).unwrap();
    }
    for (page, at_least) in [
        ("README.md", 15),
        ("docs/captures.md", 6),
        ("docs/conformance.md", 7),
        ("docs/ways.md", 40),
        ("docs/evidence.md", 1),
        ("docs/outputs.md", 3),
        ("docs/fuzzing.md", 5),
    ] {
        check(page, folder.path(), at_least);
    }
}

/// The versions in a text: three numbers with dots, behind `canvass` on a line that is no command of an example.
fn versions(text: &str) -> Vec<&str> {
    text.lines()
        .filter(|line| !line.starts_with('$'))
        .filter_map(|line| line.split_once("canvass"))
        .flat_map(|(_, rest)| rest.split(|c: char| !c.is_ascii_digit() && c != '.'))
        .map(|word| word.trim_matches('.'))
        .filter(|word| word.split('.').count() == 3 && word.split('.').all(|part| !part.is_empty()))
        .collect()
}

#[test]
fn pages_that_name_a_version_name_that_of_the_program() {
    for page in
        ["README.md", "docs/install.md", "docs/ci.md", "docs/editors.md", "docs/python.md", "editors/vscode/README.md"]
    {
        let text = std::fs::read_to_string(Path::new(ROOT).join(page)).unwrap();
        let versions = versions(&text);
        assert!(!versions.is_empty(), "{page}");
        assert!(versions.iter().all(|version| *version == env!("CARGO_PKG_VERSION")), "{page}: {versions:?}");
    }
}
