//! A table for terminals: a header, column rules, one row per frame, no wider than the terminal.
//!
//! Rows are written at once: a column that turns out too narrow is wider from that row on.

use super::text::{DATA_WIDTH, SERVICE_WIDTH, push_data, push_node, service_color};
use super::{Line, Lines, push_comment};
use crate::color::{push_begin, push_end};
use crate::push::{pad, push_hex_number, push_visible};
use crate::time::{Clock, TimeStyle};
use canvass_traces::Record;
use std::fmt::Write;

/// The table rendering of `decode`.
pub struct TableLines {
    clock: Clock,
    color: bool,
    /// The width of the terminal in columns, if the output is a terminal.
    width: Option<usize>,
    begun: bool,
    time_width: usize,
    channel_width: usize,
    id_width: usize,
    /// A buffer for the meaning before it is cut.
    text: String,
}

const RULE: &str = " │ ";
/// Columns that a narrow terminal leaves out: the meaning contains the service, most captures have one channel, and
/// other renderings show the data.
const SERVICE: usize = 5;
const CHANNEL: usize = 1;
const DATA: usize = 3;
/// Minimum width of the meaning, below which it says nothing.
const LEAST_MEANING: usize = 20;

impl TableLines {
    /// A table with this style of time, with or without colours, and of this width if it is for a terminal.
    pub const fn new(time: TimeStyle, color: bool, width: Option<usize>) -> Self {
        let clock = Clock::new(time);
        let time_width = clock.width();
        Self { clock, color, width, begun: false, time_width, channel_width: 7, id_width: 3, text: String::new() }
    }

    fn push_header(&self, out: &mut Vec<u8>) {
        let columns = self.columns();
        let names = ["time", "channel", "id", "data", "node", "service", "meaning"];
        for (n, (name, width)) in names.iter().zip(columns).enumerate().filter(|(_, (_, width))| *width > 0) {
            if n > 0 {
                out.extend_from_slice(RULE.as_bytes());
            }
            let start = out.len();
            out.extend_from_slice(name.as_bytes());
            if n + 1 < names.len() {
                pad(out, start, width);
            }
        }
        out.push(b'\n');
        for (n, width) in columns.into_iter().enumerate().filter(|(_, width)| *width > 0) {
            if n > 0 {
                out.extend_from_slice("─┼─".as_bytes());
            }
            (0..width).for_each(|_| out.extend_from_slice("─".as_bytes()));
        }
        out.push(b'\n');
    }

    /// The widths of all columns. The meaning gets the rest of the terminal. A column of width 0 is left out, because
    /// the meaning would not have room beside it.
    fn columns(&self) -> [usize; 7] {
        let mut columns = [self.time_width, self.channel_width, self.id_width, DATA_WIDTH, 4, SERVICE_WIDTH, 0];
        let used =
            |columns: &[usize; 7]| -> usize { columns.iter().filter(|&&width| width > 0).map(|width| width + 3).sum() };
        if let Some(width) = self.width {
            for column in [SERVICE, CHANNEL, DATA] {
                if used(&columns) + LEAST_MEANING > width {
                    columns[column] = 0;
                }
            }
        }
        columns[6] = self.width.map_or(40, |width| width.saturating_sub(used(&columns)).max(10));
        columns
    }

    fn push_id(&mut self, record: &Record, out: &mut Vec<u8>) {
        let id = record.frame.id();
        let digits = if id.is_extended() { 8 } else { 3 };
        self.id_width = self.id_width.max(digits);
        out.resize(out.len() + self.id_width - digits, b' ');
        push_hex_number(out, record.frame.printed_id(), digits);
    }

    /// Appends the meaning, cut to its column.
    fn push_meaning(&self, out: &mut Vec<u8>) {
        let [.., room] = self.columns();
        let cut = self.text.char_indices().nth(room).filter(|_| self.width.is_some());
        match cut.and_then(|_| self.text.char_indices().nth(room - 1)) {
            Some((end, _)) => {
                out.extend_from_slice(&self.text.as_bytes()[..end]);
                out.extend_from_slice("…".as_bytes());
            }
            None => out.extend_from_slice(self.text.as_bytes()),
        }
    }
}

impl Lines for TableLines {
    fn comment(&mut self, comment: &str, out: &mut Vec<u8>) {
        push_comment(comment, out);
    }

    fn line(&mut self, line: &Line<'_>, out: &mut Vec<u8>) {
        let Line { record, channels, decoded, meaning } = line;
        let begun = out.len();
        let name = channels.name(record.channel);
        self.channel_width = self.channel_width.max(name.chars().count());
        if record.frame.id().is_extended() {
            self.id_width = 8;
        }
        if !std::mem::replace(&mut self.begun, true) {
            // Times on a live bus have nanoseconds.
            self.clock.clone().push(record.timestamp, out);
            self.time_width = self.time_width.max(out.drain(begun..).count());
            self.push_header(out);
        }
        let start = out.len();
        self.clock.push(record.timestamp, out);
        // Numbers are aligned right.
        let written = out.len() - start;
        self.time_width = self.time_width.max(written);
        out.resize(start + self.time_width, b' ');
        out[start..].rotate_right(self.time_width - written);
        let columns = self.columns();
        if columns[CHANNEL] > 0 {
            out.extend_from_slice(RULE.as_bytes());
            push_visible(out, name);
            out.resize(out.len() + self.channel_width - name.chars().count(), b' ');
        }
        out.extend_from_slice(RULE.as_bytes());
        self.push_id(record, out);
        if columns[DATA] > 0 {
            out.extend_from_slice(RULE.as_bytes());
            push_data(record, out);
        }
        out.extend_from_slice(RULE.as_bytes());
        out.push(b' ');
        push_node(decoded.node, out);
        if columns[SERVICE] > 0 {
            out.extend_from_slice(RULE.as_bytes());
            let start = out.len();
            out.extend_from_slice(decoded.service.name().as_bytes());
            pad(out, start, SERVICE_WIDTH);
        }
        out.extend_from_slice(RULE.as_bytes());
        self.text.clear();
        // Writing to a string can't fail.
        let _ = write!(self.text, "{meaning}");
        let color = service_color(decoded.service, &decoded.message, decoded.violation).filter(|_| self.color);
        push_begin(color, out);
        self.push_meaning(out);
        push_end(color, out);
        out.push(b'\n');
    }
}
