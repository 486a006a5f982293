//! The entry of a lake about each source file. Entries are plain data: the computer that read a file sends them back.

use crate::capture::CaptureFile;
use crate::devices::Devices;
use crate::table::{SCHEMA_VERSION, Table};
use canvass_traces::Timestamp;
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

/// Two times in nanoseconds since 1970.
pub type Span = (i64, i64);

/// A capture or result, and the files of the lake that hold its rows.
#[derive(Clone, PartialEq, Eq, Debug, Serialize, Deserialize)]
pub struct Entry {
    /// The source file.
    pub file: CaptureFile,
    /// The rules by which the file was read, from [`rules`].
    pub rules: String,
    /// The SHA-256 of the file in hexadecimal; empty if the file could not be read, so that the next run tries again.
    pub sha256: String,
    /// The first and the last time of the rows; `None` if they are not known.
    pub span: Option<Span>,
    /// The name of another file with the same content, whose rows count for both.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub copy_of: Option<String>,
    /// Why the file could not be read, or not to its end.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reason: Option<String>,
    /// The files of the lake that hold the rows.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub parts: Vec<Part>,
}

/// A Parquet file of a lake.
#[derive(Clone, PartialEq, Eq, Debug, Serialize, Deserialize)]
pub struct Part {
    /// The table.
    pub table: Table,
    /// The date of the first frame, such as `2025-01-28`.
    pub date: String,
    /// The file name without the folder.
    pub name: String,
    /// Number of rows.
    pub rows: u64,
    /// The length of the file in bytes.
    pub bytes: u64,
}

impl Part {
    /// The path of the file in the lake: `messages/date=2025-01-28/….parquet`.
    pub fn path(&self) -> String {
        format!("{}/date={}/{}", self.table.name(), self.date, self.name)
    }
}

impl Entry {
    /// Whether the lake holds rows made from the content of this file by these rules.
    pub fn stands(&self, rules: &str) -> bool {
        self.copy_of.is_none() && self.rules == rules && !self.sha256.is_empty()
    }

    /// Whether the file has not changed since it was read, and the rules are the same.
    pub fn is_of(&self, file: &CaptureFile, rules: &str) -> bool {
        self.file == *file && self.rules == rules && !self.sha256.is_empty()
    }
}

/// An identifier of the rules by which captures are read: a hash of the devices and the version of the tables.
pub fn rules(devices: &Devices) -> String {
    let mut digest = Sha256::new();
    digest.update(SCHEMA_VERSION.to_le_bytes());
    digest.update(serde_json::to_vec(devices).unwrap_or_default());
    short(&digest.finalize())
}

/// The name of the Parquet files of a capture. The same file and rules give the same name, so that a repeated run
/// replaces files instead of duplicating them.
pub fn part_name(file: &CaptureFile, rules: &str) -> String {
    let mut digest = Sha256::new();
    digest.update(file.name.as_bytes());
    digest.update([0]);
    digest.update(file.size.to_le_bytes());
    digest.update(file.modified.to_le_bytes());
    digest.update(rules);
    format!("{}.parquet", short(&digest.finalize()))
}

fn short(digest: &[u8]) -> String {
    digest.iter().take(16).map(|byte| format!("{byte:02x}")).collect()
}

/// The date of a time in UTC; 1970-01-01 for `None`.
pub fn day(time: Option<Timestamp>) -> String {
    let nanos = i128::from(time.unwrap_or_default().nanos());
    let moment = jiff::Timestamp::from_nanosecond(nanos).unwrap_or(jiff::Timestamp::UNIX_EPOCH);
    moment.to_zoned(jiff::tz::TimeZone::UTC).date().to_string()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_day_is_that_of_utc() {
        assert_eq!(day(None), "1970-01-01");
        assert_eq!(day(Some(Timestamp(1_738_061_235_000_000_000))), "2025-01-28");
        assert_eq!(day(Some(Timestamp(u64::MAX))), "2554-07-21");
    }

    #[test]
    fn a_name_tells_the_file_and_how_it_was_read() {
        let file = CaptureFile { name: "a.log".into(), path: None, size: 5, modified: 7 };
        let name = part_name(&file, "x");
        assert_eq!(name, part_name(&file, "x"));
        let changed = CaptureFile { modified: 8, ..file.clone() };
        assert!(name != part_name(&file, "y") && name != part_name(&changed, "x"));
    }
}
