//! python-can, the Python library of MCAP, and rosbags.

use crate::agreement::{Defect, Way};
use crate::kept::*;
use crate::recording::{self, Seen};
use canvass_traces::{ChunkCompression, Flags, Format};
use std::io::Write;
use std::path::Path;
use std::process::{Command, Stdio};

const PYTHON: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/target/peers-venv/bin/python");
const SCRIPT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/peers/peers.py");

/// Runs `peers.py`; gives its lines, or its last words.
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

/// The peer reads what canvass writes.
fn reads(reader: &str, format: Format, losses: &[Kept], defects: &[Defect]) {
    reads_compressed(reader, format, ChunkCompression::Zstd, losses, defects);
}

fn reads_compressed(reader: &str, format: Format, compression: ChunkCompression, losses: &[Kept], defects: &[Defect]) {
    let name = format!("{reader} reads {format} ({compression:?})");
    Way { name: &name, losses, defects }.agrees(|path, frames| {
        let path = path.with_extension(format.extensions()[0]);
        recording::write(&path, format, compression, frames);
        python("read", reader, &path, &[])
    });
}

/// Canvass reads what the peer writes.
fn writes(writer: &str, format: Format, losses: &[Kept], defects: &[Defect]) {
    let name = format!("{writer} writes {format}");
    Way { name: &name, losses, defects }.agrees(|path, frames| {
        let path = path.with_extension(format.extensions()[0]);
        python("write", writer, &path, frames)?;
        Ok(recording::read(&path, format))
    });
}

#[test]
fn python_can_reads_candump_logs() {
    let defects = [Defect {
        what: "error frames of bus errors lose their bytes and channel, all others become data frames",
        concerns: |frame| frame.is_error(),
    }];
    reads("candump", Format::Candump, &[micros, received_or_sent], &defects);
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
    writes("candump", Format::Candump, &[micros, received_or_sent], &defects);
}

#[test]
fn python_can_reads_asc() {
    let defects = [Defect {
        what: "CAN FD frames without data become remote frames",
        concerns: |frame| frame.is_fd() && frame.is_empty(),
    }];
    reads("asc", Format::Asc, &[micros, numbered, no_error_detail, received_or_sent], &defects);
}

#[test]
fn python_can_writes_asc() {
    let losses: &[Kept] = &[micros, numbered, no_error_detail, received_or_sent, no_direction_of_errors];
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
    reads("trc", Format::Trc, &[micros, numbered, received_or_sent], &defects);
}

#[test]
fn python_can_writes_trc() {
    let defects = [
        Defect { what: "error frames are left out", concerns: |frame| frame.is_error() },
        Defect { what: "remote frames become data frames", concerns: |frame| frame.is_remote() },
        Defect { what: "CAN FD frames are left out", concerns: |frame| frame.is_fd() },
    ];
    writes("trc", Format::Trc, &[micros, numbered, received_or_sent], &defects);
}

#[test]
fn python_can_reads_csv() {
    let defects = [Defect {
        what: "CAN FD frames become classical frames of more than 8 bytes",
        concerns: |frame| frame.is_fd() && frame.len() > 8,
    }];
    reads("csv", Format::PythonCanCsv, &[micros, channel_1, received, no_short_fd], &defects);
}

#[test]
fn python_can_writes_csv() {
    let losses: &[Kept] = &[micros, channel_1, no_direction, no_fd_flags, no_short_fd];
    writes("csv", Format::PythonCanCsv, losses, &[]);
}

#[test]
fn python_can_writes_blf() {
    writes("blf", Format::Blf, &[micros, numbered, received_or_sent, no_direction_of_errors], &[]);
}

const MCAP: &[Kept] = &[no_direction, no_fd_flags];

#[test]
fn the_mcap_library_reads_mcap() {
    for compression in [ChunkCompression::Zstd, ChunkCompression::Lz4, ChunkCompression::None] {
        reads_compressed("mcap", Format::Mcap, compression, MCAP, &[]);
    }
}

#[test]
fn the_mcap_library_writes_mcap() {
    for writer in ["mcap-zstd", "mcap-lz4", "mcap-plain"] {
        writes(writer, Format::Mcap, MCAP, &[]);
    }
}

#[test]
fn rosbags_reads_mcap() {
    for compression in [ChunkCompression::Zstd, ChunkCompression::Lz4, ChunkCompression::None] {
        reads_compressed("rosbags", Format::Mcap, compression, MCAP, &[]);
    }
}

#[test]
fn rosbags_writes_mcap() {
    writes("rosbags", Format::Mcap, MCAP, &[]);
}
