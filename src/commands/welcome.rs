//! `canvass` without a command: what can be done with what lies in this folder and is connected to this computer.

use super::doctor;
use crate::output::print;
use crate::status::{Failure, Status};
use canvass_reports::escape::Printable;
use std::fmt::Write;
use std::fs;
use std::io::Read as _;
use std::path::{Path, PathBuf};

/// The endings of captures. Files with other names may be captures, too, and are not opened here.
const CAPTURES: [&str; 11] = ["log", "asc", "blf", "trc", "mf4", "pcap", "pcapng", "mcap", "crtd", "gz", "zst"];
const DESCRIPTIONS: [&str; 4] = ["eds", "dcf", "xdd", "xdc"];
/// Maximum number of files of a folder that are looked at.
const MOST: usize = 10_000;
/// The beginning of a result in which its schema stands.
const HEAD: u64 = 256;

/// What lies in a folder.
#[derive(Default)]
struct Found {
    captures: Vec<String>,
    descriptions: Vec<String>,
    /// Results of `canvass test`.
    results: Vec<String>,
}

/// Prints what can be done here.
pub fn run() -> Result<Status, Failure> {
    let found = Found::of(Path::new("."));
    let mut text = format!(
        "canvass {}: what went wrong on a CANopen bus, and whether a device conforms\n",
        env!("CARGO_PKG_VERSION")
    );
    put(&mut text, "In this folder", &found.rows());
    let buses = doctor::buses();
    put(
        &mut text,
        "Buses of this computer",
        &buses.iter().map(|bus| row(bus, &format!("canvass scan {bus}"))).collect::<Vec<_>>(),
    );
    let others = [
        row("a tour", "canvass tour        five minutes with a simulated encoder that has a fault"),
        row("examples", "canvass examples    a capture and a description to try, in a folder"),
        row("the computer", "canvass doctor      which buses it can use, and what is missing"),
        row("all commands", "canvass --help"),
    ];
    put(&mut text, "To begin with", &others);
    print(&Printable::document(&text))?;
    Ok(Status::Good)
}

/// What there is, and the command for it.
type Row = (String, String);

fn row(what: &str, command: &str) -> Row {
    (what.to_owned(), command.to_owned())
}

fn put(text: &mut String, title: &str, rows: &[Row]) {
    if rows.is_empty() {
        return;
    }
    let width = rows.iter().map(|(what, _)| what.chars().count()).max().unwrap_or(0);
    // Writing to a string can't fail.
    let _ = writeln!(text, "\n{title}:");
    for (what, command) in rows {
        let _ = writeln!(text, "  {what:width$}   {command}");
    }
}

impl Found {
    fn of(folder: &Path) -> Self {
        let mut found = Self::default();
        let entries = fs::read_dir(folder).into_iter().flatten().flatten().take(MOST);
        let mut paths: Vec<PathBuf> = entries.map(|entry| entry.path()).filter(|path| path.is_file()).collect();
        paths.sort();
        for path in paths {
            let ending = path.extension().map(|ending| ending.to_string_lossy().to_ascii_lowercase());
            let (ending, name) = (ending.unwrap_or_default(), path.file_name().map(|name| name.to_string_lossy()));
            let name = name.unwrap_or_default().into_owned();
            if CAPTURES.contains(&&*ending) {
                found.captures.push(name);
            } else if DESCRIPTIONS.contains(&&*ending) {
                found.descriptions.push(name);
            } else if ending == "json" && is_result(&path) {
                found.results.push(name);
            }
        }
        found
    }

    fn rows(&self) -> Vec<Row> {
        let mut rows = Vec::new();
        if let Some(first) = self.captures.first() {
            let shown = quoted(first);
            rows.push((of(&self.captures, "capture"), format!("canvass diagnose {shown}    what is wrong in it")));
            rows.push((String::new(), format!("canvass decode {shown}      every frame with its meaning")));
        }
        if let Some(first) = self.descriptions.first() {
            rows.push((of(&self.descriptions, "description"), format!("canvass eds check {}", quoted(first))));
        }
        match &*self.results {
            [] => {}
            [only] => rows.push((only.clone(), format!("canvass compare {} NEWER.json", quoted(only)))),
            [one, .., last] => {
                rows.push((of(&self.results, "result"), format!("canvass compare {} {}", quoted(one), quoted(last))));
            }
        }
        rows
    }
}

/// `night.blf`, or `night.blf and 2 other captures`.
fn of(names: &[String], one: &str) -> String {
    match names {
        [] => String::new(),
        [only] => only.clone(),
        [first, _] => format!("{first} and 1 other {one}"),
        [first, others @ ..] => format!("{first} and {} other {one}s", others.len()),
    }
}

/// The name as a word of a shell.
fn quoted(name: &str) -> String {
    let is_plain = |c: char| c.is_alphanumeric() || "._-+@%".contains(c);
    match name.chars().all(is_plain) && !name.starts_with('-') {
        true => name.to_owned(),
        false => format!("'./{}'", name.replace('\'', r"'\''")),
    }
}

/// Whether a file is the result of `canvass test --format json`.
fn is_result(path: &Path) -> bool {
    let mut head = Vec::new();
    let read = fs::File::open(path).and_then(|file| file.take(HEAD).read_to_end(&mut head));
    read.is_ok() && String::from_utf8_lossy(&head).contains("\"canvass/test/")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_folder_is_told_with_its_commands() {
        let folder = tempfile::tempdir().unwrap();
        let put = |name: &str, content: &str| fs::write(folder.path().join(name), content).unwrap();
        put("night one.blf", "");
        put("b.log", "");
        put("c.LOG", "");
        put("motor.EDS", "");
        put("1.0.json", "{\"schema\": \"canvass/test/1\"}");
        put("other.json", "{}");
        put("readme.md", "");
        let rows = Found::of(folder.path()).rows();
        let told: Vec<String> = rows.iter().map(|(what, command)| format!("{what}: {command}")).collect();
        assert_eq!(
            told,
            [
                "b.log and 2 other captures: canvass diagnose b.log    what is wrong in it",
                ": canvass decode b.log      every frame with its meaning",
                "motor.EDS: canvass eds check motor.EDS",
                "1.0.json: canvass compare 1.0.json NEWER.json",
            ]
        );
        assert_eq!(
            (quoted("night one.blf"), quoted("it's")),
            ("'./night one.blf'".to_owned(), r"'./it'\''s'".to_owned())
        );
    }
}
