//! can-utils: `log2long`, whose parser of logs `canplayer` and `cansend` share, `log2asc` and `asc2log`.

use crate::agreement::Way;
use crate::kept::*;
use crate::recording::{self, START, Seen};
use canvass_traces::{ChunkCompression, Format};
use std::fs::File;
use std::path::Path;
use std::process::Command;

/// Runs a program that converts one format into another.
fn convert(program: &str, args: &[&str], from: &Path, to: &Path) {
    let mut command = Command::new(program);
    command.args(args).stdin(File::open(from).unwrap()).stdout(File::create(to).unwrap());
    let status = command.status().unwrap_or_else(|error| panic!("{program}: {error}; cargo xtask ci installs it"));
    assert!(status.success(), "{program}: {status}");
}

/// The frames after the peer has read and written them.
fn passed_on(program: &str, args: &[&str], [from, to]: [Format; 2], path: &Path, frames: &[Seen]) -> Vec<String> {
    let (input, output) = (path.with_extension("in"), path.with_extension("out"));
    recording::write(&input, from, ChunkCompression::None, frames);
    convert(program, args, &input, &output);
    recording::read(&output, to).unwrap()
}

#[test]
fn log2long_reads_logs_and_writes_what_candump_shows() {
    let formats = [Format::Candump, Format::CandumpConsole];
    Way { name: "log2long", before: &[], losses: &[no_direction, no_fd_flags], defects: &[] }
        .agrees(|path, frames| Ok(passed_on("log2long", &[], formats, path, frames)));
}

#[test]
fn log2asc_reads_logs_and_writes_asc() {
    let formats = [Format::Candump, Format::Asc];
    let losses: &[Kept] = &[numbered, no_error_detail, received_or_sent, no_direction_of_errors];
    // log2asc keeps six decimals of a second.
    Way { name: "log2asc", before: &[micros], losses, defects: &[] }
        .agrees(|path, frames| Ok(passed_on("log2asc", &["can0", "can1", "can2"], formats, path, frames)));
}

#[test]
fn asc2log_reads_asc_and_writes_logs() {
    let formats = [Format::Asc, Format::Candump];
    let losses: &[Kept] = &[zeros_of_errors, received_or_sent, no_direction_of_errors];
    Way { name: "asc2log", before: &[micros], losses, defects: &[] }
        .agrees(|path, frames| Ok(from_start(&passed_on("asc2log", &[], formats, path, frames))));
}

/// asc2log reads dates only if the locale en_US is installed; otherwise its times count from the present. So times are
/// compared relative to the first frame.
fn from_start(lines: &[String]) -> Vec<String> {
    let split: Vec<(u64, &str)> = lines
        .iter()
        .map(|line| line.split_once(' ').unwrap())
        .map(|(nanos, rest)| (nanos.parse().unwrap(), rest))
        .collect();
    split.iter().map(|(nanos, rest)| format!("{} {rest}", nanos - split[0].0 + START)).collect()
}
