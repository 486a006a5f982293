//! Decoded frames, rendered one by one.
//!
//! Every rendering appends to a buffer that the caller writes out and clears: nothing is allocated per frame.

mod csv;
mod json;
mod table;
mod text;

pub use crate::time::TimeStyle;
pub use csv::CsvLines;
pub use json::{JsonLines, source_name};
pub(crate) use json::{push_number, push_schema, push_violation};
pub use table::TableLines;
pub use text::TextLines;
pub(crate) use text::push_node;

use crate::push::push_visible;
use canvass_analyzer::{Meaning, network::Decoded};
use canvass_traces::{Channels, Record};

/// The data of one frame for a rendering.
pub struct Line<'a> {
    /// The frame.
    pub record: &'a Record,
    /// The names of the channels of the frames.
    pub channels: &'a Channels,
    /// The frame as the network decoded it.
    pub decoded: &'a Decoded,
    /// The meaning of the frame in words.
    pub meaning: Meaning<'a>,
}

/// Appends a comment on lines of its own.
pub(crate) fn push_comment(comment: &str, out: &mut Vec<u8>) {
    for line in comment.lines() {
        out.extend_from_slice(b"# ");
        push_visible(out, line);
        out.push(b'\n');
    }
}

/// A rendering of decoded frames.
pub trait Lines {
    /// Appends the header before the first frame.
    fn begin(&mut self, _out: &mut Vec<u8>) {}

    /// Appends a comment of the capture before the next shown frame. Some renderings leave comments out.
    fn comment(&mut self, _comment: &str, _out: &mut Vec<u8>) {}

    /// Appends the frame to `out`.
    fn line(&mut self, line: &Line<'_>, out: &mut Vec<u8>);
}
