//! can-utils: `log2long`, which reads logs with the parser that `canplayer` and `cansend` have too, `log2asc`, `asc2log`.

use crate::agreement::{Defect, Way};
use crate::kept::*;
use crate::recording::{self, Seen};
use canvass_traces::{ChunkCompression, Format};
use std::fs::File;
use std::path::Path;
use std::process::Command;

/// A program that turns one format into another.
fn convert(program: &str, args: &[&str], from: &Path, to: &Path) {
    let mut command = Command::new(program);
    command.args(args).stdin(File::open(from).unwrap()).stdout(File::create(to).unwrap());
    let status = command.status().unwrap_or_else(|error| panic!("{program}: {error}; cargo xtask ci installs it"));
    assert!(status.success(), "{program}: {status}");
}

/// The peer reads what canvass writes, and canvass reads what the peer writes.
fn passes_on(program: &str, args: &[&str], [from, to]: [Format; 2], losses: &[Kept], defects: &[Defect]) {
    Way { name: program, losses, defects }.agrees(|path: &Path, frames: &[Seen]| {
        let (input, output) = (path.with_extension("in"), path.with_extension("out"));
        recording::write(&input, from, ChunkCompression::None, frames);
        convert(program, args, &input, &output);
        Ok(recording::read(&output, to))
    });
}

#[test]
fn log2long_reads_logs_and_writes_what_candump_shows() {
    passes_on("log2long", &[], [Format::Candump, Format::CandumpConsole], &[no_direction], &[]);
}

#[test]
fn log2asc_reads_logs_and_writes_asc() {
    let losses: &[Kept] = &[micros, numbered, no_error_detail, received_or_sent, no_direction_of_errors];
    passes_on("log2asc", &["can0", "can1", "can2"], [Format::Candump, Format::Asc], losses, &[]);
}

#[test]
fn asc2log_reads_asc_and_writes_logs() {
    let losses: &[Kept] = &[micros, no_error_detail, received_or_sent];
    passes_on("asc2log", &[], [Format::Asc, Format::Candump], losses, &[]);
}
