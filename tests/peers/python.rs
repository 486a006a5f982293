//! python-can, the Python library of MCAP, and rosbags.

use crate::agreement::{Defect, Way};
use crate::kept::*;
use crate::recording::{self, Seen};
use canvass_traces::{ChunkCompression, Flags, Format};
use std::io::Write;
use std::path::Path;
use std::process::{Command, Stdio};

pub const PYTHON: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/target/peers-venv/bin/python");
const SCRIPT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/peers/peers.py");

/// Runs `peers.py`; returns the lines of its output, or its error messages.
fn python(way: &str, name: &str, path: &Path, frames: &[Seen]) -> Result<Vec<String>, String> {
    let mut command = Command::new(PYTHON);
    // ASC and TRC hold local times.
    command.args([SCRIPT, way, name]).arg(path).env("TZ", "UTC");
    let piped = command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn();
    let mut child = piped
        .unwrap_or_else(|error| panic!("{PYTHON}: {error}; cargo xtask ci installs the peers that these tests need"));
    let lines: String = frames.iter().map(|seen| format!("{seen}\n")).collect();
    let written = child.stdin.take().unwrap().write_all(lines.as_bytes());
    let output = child.wait_with_output().unwrap();
    if !output.status.success() {
        return Err(String::from_utf8_lossy(&output.stderr).into_owned());
    }
    written.map_err(|error| error.to_string())?;
    Ok(String::from_utf8(output.stdout).unwrap().lines().map(str::to_owned).collect())
}

/// python-can computes times in floating point, which can't hold nanoseconds of present dates.
const FLOAT: &[Kept] = &[micros];

/// python-can reads what canvass writes.
fn reads(reader: &str, format: Format, losses: &[Kept], defects: &[Defect]) {
    let name = format!("python-can reads {format}");
    Way { name: &name, before: FLOAT, losses, defects }.agrees(|path, frames| {
        let path = path.with_extension(format.extensions()[0]);
        recording::write(&path, format, ChunkCompression::None, frames);
        python("read", reader, &path, &[])
    });
}

/// Canvass reads what python-can writes.
fn writes(writer: &str, format: Format, losses: &[Kept], defects: &[Defect]) {
    let name = format!("python-can writes {format}");
    Way { name: &name, before: FLOAT, losses, defects }.agrees(|path, frames| {
        let path = path.with_extension(format.extensions()[0]);
        python("write", writer, &path, frames)?;
        Ok(recording::read(&path, format)?.iter().map(|line| rounded(line)).collect())
    });
}

/// The line with its time rounded to the microsecond from which the floating-point number was made.
fn rounded(line: &str) -> String {
    let (nanos, rest) = line.split_once(' ').unwrap();
    let micros = (nanos.parse::<u64>().unwrap() + 500) / 1_000;
    format!("{micros}000 {rest}")
}

#[test]
fn python_can_reads_candump_logs() {
    let defects = [Defect {
        what: "error frames of bus errors lose their bytes and channel, all others become data frames",
        concerns: |frame| frame.is_error(),
    }];
    reads("candump", Format::Candump, &[received_or_sent], &defects);
}

#[test]
fn python_can_writes_candump_logs() {
    let defects = [
        Defect { what: "error frames have no bytes", concerns: |frame| frame.is_error() },
        Defect {
            what: "remote frames lose the length that they ask for",
            concerns: |frame| frame.is_remote() && !frame.is_empty(),
        },
    ];
    writes("candump", Format::Candump, &[received_or_sent], &defects);
}

#[test]
fn python_can_reads_asc() {
    let defects = [Defect {
        what: "CAN FD frames without data become remote frames",
        concerns: |frame| frame.is_fd() && frame.is_empty(),
    }];
    reads("asc", Format::Asc, &[numbered, no_error_detail, received_or_sent, received_errors], &defects);
}

#[test]
fn python_can_writes_asc() {
    let losses: &[Kept] = &[numbered, no_error_detail, received_or_sent, no_direction_of_errors];
    writes("asc", Format::Asc, losses, &[]);
}

#[test]
fn python_can_reads_trc() {
    let defects = [
        Defect { what: "error frames are left out", concerns: |frame| frame.is_error() },
        Defect {
            what: "the column L, a DLC, is taken for a length",
            concerns: |frame| frame.is_fd() && frame.len() > 8,
        },
        Defect {
            what: "kind FE gets BRS, kind BI loses it",
            concerns: |frame| frame.is_fd() && frame.flags().contains(Flags::ESI),
        },
    ];
    reads("trc", Format::Trc, &[numbered, received_or_sent], &defects);
}

#[test]
fn python_can_writes_trc() {
    let defects = [
        Defect { what: "error frames are left out", concerns: |frame| frame.is_error() },
        Defect { what: "remote frames become data frames", concerns: |frame| frame.is_remote() },
        Defect { what: "CAN FD frames are left out", concerns: |frame| frame.is_fd() },
    ];
    writes("trc", Format::Trc, &[numbered, received_or_sent], &defects);
}

#[test]
fn python_can_reads_csv() {
    let defects = [Defect {
        what: "CAN FD frames become classical frames of more than 8 bytes",
        concerns: |frame| frame.is_fd() && frame.len() > 8,
    }];
    reads("csv", Format::PythonCanCsv, &[channel_1, received, no_short_fd], &defects);
}

#[test]
fn python_can_writes_csv() {
    let losses: &[Kept] = &[channel_1, no_direction, no_fd_flags, no_short_fd];
    writes("csv", Format::PythonCanCsv, losses, &[]);
}

#[test]
fn python_can_reads_blf() {
    reads("blf", Format::Blf, &[numbered, received_or_sent, received_errors], &[]);
}

/// python-can reads by asammdf, which reads each group of records.
#[test]
fn python_can_reads_mf4() {
    reads("mf4", Format::Mf4, &[numbered, no_error_detail, received_or_sent], &[]);
}

#[test]
fn python_can_writes_sqlite() {
    writes("sqlite", Format::Sqlite, &[channel_1, no_direction, no_fd_flags, no_short_fd], &[]);
}

/// python-can writes a group of records each for data, remote and error frames.
#[test]
fn python_can_writes_mf4() {
    writes("mf4", Format::Mf4, &[numbered_from_0, no_error_detail, received_or_sent], &[]);
}

#[test]
fn python_can_writes_blf() {
    writes("blf", Format::Blf, &[numbered, received_or_sent, no_direction_of_errors], &[]);
}

/// can_msgs/Frame and FdFrame have no place for directions and CAN FD flags.
const MCAP: &[Kept] = &[no_direction, no_fd_flags];

fn reads_mcap(reader: &str) {
    for compression in [ChunkCompression::Zstd, ChunkCompression::Lz4, ChunkCompression::None] {
        let name = format!("{reader} reads MCAP ({compression:?})");
        Way { name: &name, before: &[], losses: MCAP, defects: &[] }.agrees(|path, frames| {
            let path = path.with_extension("mcap");
            recording::write(&path, Format::Mcap, compression, frames);
            python("read", reader, &path, &[])
        });
    }
}

fn writes_mcap(writer: &str) {
    let name = format!("{writer} writes MCAP");
    Way { name: &name, before: &[], losses: MCAP, defects: &[] }.agrees(|path, frames| {
        let path = path.with_extension("mcap");
        python("write", writer, &path, frames)?;
        recording::read(&path, Format::Mcap)
    });
}

#[test]
fn the_mcap_library_reads_mcap() {
    reads_mcap("mcap");
}

#[test]
fn the_mcap_library_writes_mcap() {
    for writer in ["mcap-zstd", "mcap-lz4", "mcap-plain"] {
        writes_mcap(writer);
    }
}

#[test]
fn rosbags_reads_mcap() {
    reads_mcap("rosbags");
}

#[test]
fn rosbags_writes_mcap() {
    writes_mcap("rosbags");
}
