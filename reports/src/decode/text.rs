//! One aligned line per frame: time, channel, identifier, data, node, service, meaning.

use super::{Line, Lines, push_comment};
use crate::color::{Color, push_begin, push_end};
use crate::push::{hex_pair, pad, push_decimal, push_front, push_hex, push_hex_number, push_meaning, push_visible};
use crate::time::{Clock, TimeStyle};
use canvass_analyzer::{Message, NodeId, Service, network::sdo::Violation};
use canvass_traces::Record;

/// The text rendering of `decode`, `send` and `monitor`.
pub struct TextLines {
    clock: Clock,
    color: bool,
    channel_width: usize,
    /// The shown names of the channels by their ids. A name is empty until its channel is first shown.
    channels: Vec<Vec<u8>>,
    id_width: usize,
}

/// Width of eight data bytes in columns.
pub(super) const DATA_WIDTH: usize = 23;
pub(super) const SERVICE_WIDTH: usize = 11;
/// Width of an identifier of 3 digits, data, node, and the blanks around them.
const USUAL_WIDTH: usize = 2 + 3 + 2 + DATA_WIDTH + 1 + 3 + 2;

/// The name of each service with the blanks after it, and the width of both in columns.
static SERVICES: [([u8; 16], usize); Service::ALL.len()] = {
    let mut columns = [([b' '; 16], 0); Service::ALL.len()];
    let mut n = 0;
    while n < Service::ALL.len() {
        let name = Service::ALL[n].name().as_bytes();
        let (column, width) = &mut columns[Service::ALL[n] as usize];
        column.split_at_mut(name.len()).0.copy_from_slice(name);
        *width = 1 + if name.len() > SERVICE_WIDTH { name.len() } else { SERVICE_WIDTH };
        n += 1;
    }
    columns
};

impl TextLines {
    /// A rendering with this style of time, with or without colours.
    pub const fn new(time: TimeStyle, color: bool) -> Self {
        Self { clock: Clock::new(time), color, channel_width: 4, channels: Vec::new(), id_width: 3 }
    }

    fn push_id(&mut self, record: &Record, out: &mut Vec<u8>) {
        let id = record.frame.id();
        let digits = if id.is_extended() { 8 } else { 3 };
        self.id_width = self.id_width.max(digits);
        pad(out, out.len(), self.id_width - digits);
        push_hex_number(out, record.frame.printed_id(), digits);
    }

    /// Appends identifier, data and node of any frame with the blanks around them.
    fn push_columns(&mut self, record: &Record, node: Option<NodeId>, out: &mut Vec<u8>) {
        out.extend_from_slice(b"  ");
        self.push_id(record, out);
        out.extend_from_slice(b"  ");
        push_data(record, out);
        out.push(b' ');
        push_node(node, out);
        out.extend_from_slice(b"  ");
    }

    /// Identifier, data and node of a classical data frame with 11 bits, if no wider identifier was shown. This is the
    /// fast way for nearly all frames of a bus.
    fn usual_columns(&self, record: &Record, node: Option<NodeId>) -> Option<[u8; USUAL_WIDTH]> {
        let (frame, data) = (&record.frame, record.data());
        if self.id_width != 3 || frame.id().is_extended() || frame.is_remote() || data.len() > 8 {
            return None;
        }
        let mut columns = [b' '; USUAL_WIDTH];
        let [high, low] = (frame.id().raw() as u16).to_be_bytes().map(hex_pair);
        columns[2..5].copy_from_slice(&[high[1], low[0], low[1]]);
        for (place, &byte) in columns[7..].chunks_exact_mut(3).zip(data) {
            place[..2].copy_from_slice(&hex_pair(byte));
        }
        columns[8 + DATA_WIDTH..][..3].copy_from_slice(&node_columns(node));
        Some(columns)
    }

    fn push_channel(&mut self, line: &Line<'_>, out: &mut Vec<u8>) {
        let (start, id) = (out.len(), usize::from(line.record.channel.0));
        match self.channels.get(id).filter(|shown| !shown.is_empty()) {
            Some(shown) => out.extend_from_slice(shown),
            None => self.push_new_channel(id, line.channels.name(line.record.channel), out),
        }
        pad(out, start, self.channel_width);
    }

    #[cold]
    fn push_new_channel(&mut self, id: usize, name: &str, out: &mut Vec<u8>) {
        let start = out.len();
        // A channel's name comes from the file and may contain any characters.
        push_visible(out, name);
        let shown = &out[start..];
        self.channel_width = self.channel_width.max(shown.len());
        if self.channels.len() <= id {
            self.channels.resize(id + 1, Vec::new());
        }
        self.channels[id] = shown.to_vec();
    }
}

impl Lines for TextLines {
    fn comment(&mut self, comment: &str, out: &mut Vec<u8>) {
        push_comment(comment, out);
    }

    fn line(&mut self, line: &Line<'_>, out: &mut Vec<u8>) {
        let Line { record, decoded, meaning, .. } = line;
        self.clock.push(record.timestamp, out);
        out.extend_from_slice(b"  ");
        self.push_channel(line, out);
        match self.usual_columns(record, decoded.node) {
            Some(columns) => out.extend_from_slice(&columns),
            None => self.push_columns(record, decoded.node, out),
        }
        let (name, width) = &SERVICES[decoded.service as usize];
        push_front(out, name, *width);
        let color = service_color(decoded.service, &decoded.message, decoded.violation).filter(|_| self.color);
        push_begin(color, out);
        push_meaning(out, meaning);
        push_end(color, out);
        out.push(b'\n');
    }
}

/// Appends the node-ID, three columns wide.
pub(crate) fn push_node(node: Option<NodeId>, out: &mut Vec<u8>) {
    out.extend_from_slice(&node_columns(node));
}

fn node_columns(node: Option<NodeId>) -> [u8; 3] {
    let mut columns = *b"   ";
    if let Some(node) = node.map(NodeId::raw) {
        columns[2] = b'0' + node % 10;
        if node >= 10 {
            columns[1] = b'0' + node / 10 % 10;
        }
        if node >= 100 {
            columns[0] = b'1';
        }
    }
    columns
}

pub(super) fn push_data(record: &Record, out: &mut Vec<u8>) {
    let start = out.len();
    if record.frame.is_remote() {
        out.extend_from_slice(b"remote, ");
        push_decimal(out, record.frame.len() as u64);
        out.extend_from_slice(b" bytes");
        return pad(out, start, DATA_WIDTH);
    }
    let data = record.data();
    push_hex(out, data, Some(b' '));
    pad(out, start, DATA_WIDTH);
}

/// The colour of a message: red for errors, yellow for boot-ups, cyan for commands, green for PDOs, grey for SYNC,
/// heartbeats, node guarding and unknown messages. Other messages have none.
pub(super) fn service_color(service: Service, message: &Message, violation: Option<Violation>) -> Option<Color> {
    use canvass_analyzer::wire::sdo::{Request, Response};
    match (service, message) {
        _ if violation.is_some() => Some(Color::Red),
        (_, Message::SdoRequest(Request::Abort(_)) | Message::SdoResponse(Response::Abort(_))) => Some(Color::Red),
        (_, Message::Malformed(..)) | (Service::ErrorFrame | Service::Emcy, _) => Some(Color::Red),
        (Service::BootUp, _) => Some(Color::Yellow),
        (Service::Nmt | Service::Lss | Service::Lmt, _) => Some(Color::Cyan),
        (Service::Pdo, _) => Some(Color::Green),
        (Service::Heartbeat | Service::Guarding | Service::Sync | Service::Unknown, _) => Some(Color::Grey),
        _ => None,
    }
}
