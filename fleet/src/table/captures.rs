//! `captures`: the recordings, their quality, and files that could not be read.

use super::column::{Column, Rows, write, write_str};
use canvass_reports::quality::{time_base, warnings};
use canvass_tables::columns;
use canvass_traces::{Format, Quality, TimeBase};

/// The rows of `captures`.
pub struct Captures;

/// A capture as a whole.
pub struct CaptureRow<'a> {
    /// The name of the capture.
    pub capture: &'a str,
    /// The SHA-256 of the file in hexadecimal; of a compressed file, the hash of the compressed bytes.
    pub sha256: Option<&'a str>,
    /// The file's length in bytes.
    pub size: u64,
    /// The format of the capture; `None` if no known format matches.
    pub format: Option<Format>,
    /// The time base of the capture.
    pub time_base: Option<TimeBase>,
    /// The quality of the capture.
    pub quality: &'a Quality,
    /// Why the file could not be read, or not to its end.
    pub reason: Option<&'a str>,
}

impl Rows for Captures {
    type Row<'a> = CaptureRow<'a>;
    const COLUMNS: &'static [Column<Self>] = columns![Self:
        "capture" name "the file" = |row, out| write_str(out, Some(row.capture));
        "sha256" text "its SHA-256 in hexadecimal, of the file as it is" = |row, out| write_str(out, row.sha256);
        "size" u64 "its length in bytes" = |row| Some(row.size);
        "format" word "its format, as `canvass list formats` names it; null where none is known" = |row| row.format.map(Format::id);
        "time_base" word "what its times count from: `utc`, `local`, `start`, `none`" = |row| row.time_base.map(time_base);
        "reason" text "why it could not be read, or not to its end; null: it was read" = |row, out| write_str(out, row.reason);
        "t" time "its first frame" = |row| row.quality.first;
        "t_last" time "its last frame" = |row| row.quality.last;
        "duration_ns" i64 "from the first to the last frame" = |row| i64::try_from(row.quality.duration().nanos()).ok();
        "channels" u32 "how many channels have frames" = |row| Some(row.quality.channels.iter().filter(|frames| **frames > 0).count() as u64);
        "frames" u64 "frames" = |row| Some(row.quality.frames.total());
        "standard" u64 "of these classical data frames of 11 bits" = |row| Some(row.quality.frames.standard);
        "extended" u64 "of 29 bits" = |row| Some(row.quality.frames.extended);
        "remote" u64 "remote frames" = |row| Some(row.quality.frames.remote);
        "error" u64 "error frames" = |row| Some(row.quality.frames.error);
        "fd" u64 "CAN FD frames" = |row| Some(row.quality.frames.fd);
        "xl" u64 "CAN XL frames" = |row| Some(row.quality.frames.xl);
        "malformed" u64 "lines, packets or messages that break the rules of their format" = |row| Some(row.quality.damages.malformed);
        "truncated" u64 "those that end early" = |row| Some(row.quality.damages.truncated);
        "unsupported" u64 "those of a kind that is not read" = |row| Some(row.quality.damages.unsupported);
        "lost" u64 "frames that the recorder says it lost" = |row| Some(row.quality.damages.dropped);
        "unfinished" u64 "1: the file has no proper end" = |row| Some(row.quality.damages.unfinished);
        "resolution_ns" i64 "how fine the times are" = |row| row.quality.resolution.get().and_then(|unit| i64::try_from(unit.nanos()).ok());
        "clock_steps_back" u64 "how often the clock stepped back" = |row| Some(row.quality.steps.count);
        "gaps" u64 "silences that are far longer than usual" = |row| Some(row.quality.gaps.count);
        "warnings" text "what to be careful with" = |row, out| {
            let told = warnings(row.quality);
            write(out, (!told.is_empty()).then(|| told.join("; ")))
        };
    ];
}
