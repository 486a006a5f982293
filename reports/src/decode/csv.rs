//! CSV (RFC 4180, with plain line feeds): a header, then one row per frame.

use super::{Line, Lines};
use crate::escape::push_csv_cell;
use crate::push::{push_decimal, push_hex, push_hex_number};
use crate::time::{Clock, TimeStyle};
use canvass_traces::Direction;
use std::fmt::Write;

/// The CSV rendering of `decode`.
///
/// CAN-IDs and addresses have `0x` before them, and data bytes blanks between them: `1E5` alone would become the
/// number 100000 in a spreadsheet.
pub struct CsvLines {
    clock: Clock,
    /// A buffer for the meaning before it is escaped.
    text: String,
}

const HEADER: &[u8] = b"t,channel,direction,id,extended,remote,dlc,data,node,service,index,sub,text,comment\n";

impl CsvLines {
    /// A CSV rendering with this style of time, always with nanoseconds.
    pub const fn new(time: TimeStyle) -> Self {
        Self { clock: Clock::full(time), text: String::new() }
    }
}

impl Lines for CsvLines {
    fn begin(&mut self, out: &mut Vec<u8>) {
        out.extend_from_slice(HEADER);
    }

    fn line(&mut self, line: &Line<'_>, out: &mut Vec<u8>) {
        let Line { record, channels, decoded, meaning } = line;
        let frame = &record.frame;
        self.clock.push(record.timestamp, out);
        out.push(b',');
        push_csv_cell(out, channels.name(record.channel));
        out.extend_from_slice(match record.direction {
            Direction::Unknown => b",,0x",
            Direction::Rx => b",rx,0x",
            Direction::Tx => b",tx,0x",
        });
        push_hex_number(out, frame.id().raw(), if frame.id().is_extended() { 8 } else { 3 });
        push_flag(out, frame.id().is_extended());
        push_flag(out, frame.is_remote());
        out.push(b',');
        push_decimal(out, u64::from(frame.dlc()));
        out.push(b',');
        push_hex(out, record.data(), Some(b' '));
        out.push(b',');
        if let Some(node) = decoded.node {
            push_decimal(out, u64::from(node.raw()));
        }
        out.push(b',');
        out.extend_from_slice(decoded.service.name().as_bytes());
        match decoded.object {
            Some(object) => {
                out.extend_from_slice(b",0x");
                push_hex_number(out, u32::from(object.index.0), 4);
                out.extend_from_slice(b",0x");
                push_hex_number(out, u32::from(object.sub.0), 2);
            }
            None => out.extend_from_slice(b",,"),
        }
        out.push(b',');
        self.text.clear();
        // Writing to a string can't fail.
        let _ = write!(self.text, "{meaning}");
        push_csv_cell(out, &self.text);
        out.push(b',');
        push_csv_cell(out, record.comment().unwrap_or_default());
        out.push(b'\n');
    }
}

fn push_flag(out: &mut Vec<u8>, flag: bool) {
    out.extend_from_slice(if flag { b",true" } else { b",false" });
}
