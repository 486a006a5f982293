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

/// What a rendering needs of one frame.
pub struct Line<'a> {
    /// The frame.
    pub record: &'a Record,
    /// Its channel's name is among these.
    pub channels: &'a Channels,
    /// What the network made of it.
    pub decoded: &'a Decoded,
    /// What it means, in words.
    pub meaning: Meaning<'a>,
}

/// Appends a comment as lines of its own.
pub(crate) fn push_comment(comment: &str, out: &mut Vec<u8>) {
    for line in comment.lines() {
        out.extend_from_slice(b"# ");
        push_visible(out, line);
        out.push(b'\n');
    }
}

/// Renders decoded frames.
pub trait Lines {
    /// Appends what comes before the first frame.
    fn begin(&mut self, _out: &mut Vec<u8>) {}

    /// Appends what the capture says before the next frame that is shown; where a frame's line says it, nothing.
    fn comment(&mut self, _comment: &str, _out: &mut Vec<u8>) {}

    /// Appends the frame to `out`.
    fn line(&mut self, line: &Line<'_>, out: &mut Vec<u8>);
}
