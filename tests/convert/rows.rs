//! Captures as rows that can be compared.

use canvass_traces::{Capture, Direction, ReadOptions, Reader, XlHeader};
use std::path::Path;

/// The content of a record without its place in the file.
#[derive(Clone, PartialEq, Debug)]
pub struct RecordContent {
    pub nanos: u64,
    pub channel: String,
    /// The class of an error frame.
    pub id: u32,
    pub is_extended: bool,
    pub is_remote: bool,
    pub is_error: bool,
    /// The flags BRS 1, ESI 2, FDF 4, XLF 8.
    pub flags: u8,
    pub dlc: u8,
    pub data: Vec<u8>,
    pub xl: Option<XlHeader>,
    pub direction: Direction,
}

/// The rows of a capture that must be without damage.
pub fn rows(path: &Path) -> Vec<RecordContent> {
    let mut capture = Capture::open(path, &ReadOptions::default()).unwrap();
    let mut rows = Vec::new();
    while let Some(item) = capture.next() {
        let record = item.unwrap_or_else(|damage| panic!("{}: {damage}", path.display()));
        let frame = &record.frame;
        rows.push(RecordContent {
            nanos: record.timestamp.nanos(),
            channel: capture.channels().name(record.channel).to_owned(),
            id: frame.id().raw(),
            is_extended: frame.id().is_extended(),
            is_remote: frame.is_remote(),
            is_error: frame.is_error(),
            flags: frame.flags().bits(),
            dlc: frame.dlc(),
            data: record.data().to_vec(),
            xl: record.xl_header(),
            direction: record.direction,
        });
    }
    rows
}
