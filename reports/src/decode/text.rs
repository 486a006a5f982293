//! One aligned line per frame: time, channel, identifier, data, node, service, meaning.

use super::{HEX, Line, Lines, pad, push_decimal, push_fraction, push_hex};
use canvass_analyzer::{Message, Service, network::sdo::Violation};
use canvass_traces::{Record, Timestamp};
use std::io::Write;

/// How the time of a frame is shown.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub enum TimeStyle {
    /// Seconds as they stand in the capture.
    #[default]
    Absolute,
    /// Seconds since the first frame.
    Relative,
    /// Seconds since the frame before.
    Delta,
}

/// The text rendering of `decode`, `send` and `monitor`.
pub struct TextLines {
    time: TimeStyle,
    color: bool,
    first: Option<Timestamp>,
    previous: Option<Timestamp>,
    channel_width: usize,
    id_width: usize,
}

/// Columns of eight data bytes.
const DATA_WIDTH: usize = 23;
const SERVICE_WIDTH: usize = 11;

impl TextLines {
    /// With that style of time, and with colours or without.
    pub const fn new(time: TimeStyle, color: bool) -> Self {
        Self { time, color, first: None, previous: None, channel_width: 4, id_width: 3 }
    }

    fn push_time(&mut self, now: Timestamp, out: &mut Vec<u8>) {
        let first = *self.first.get_or_insert(now);
        let previous = self.previous.replace(now).unwrap_or(now);
        let (negative, nanos) = match self.time {
            TimeStyle::Absolute => (false, now.nanos()),
            TimeStyle::Relative => (now < first, now.nanos().abs_diff(first.nanos())),
            TimeStyle::Delta => (now < previous, now.nanos().abs_diff(previous.nanos())),
        };
        if negative {
            out.push(b'-');
        }
        push_decimal(out, nanos / 1_000_000_000);
        out.push(b'.');
        match nanos % 1000 {
            0 => push_fraction(out, nanos % 1_000_000_000 / 1000, 6),
            _ => push_fraction(out, nanos % 1_000_000_000, 9),
        }
    }

    fn push_id(&mut self, record: &Record, out: &mut Vec<u8>) {
        let id = record.frame.id();
        let digits = if id.is_extended() { 8 } else { 3 };
        self.id_width = self.id_width.max(digits);
        out.resize(out.len() + self.id_width - digits, b' ');
        let raw = id.raw();
        out.extend((0..digits).rev().map(|n| HEX[(raw >> (4 * n) & 15) as usize]));
    }

    fn push_channel(&mut self, name: &str, out: &mut Vec<u8>) {
        let start = out.len();
        // A channel's name comes out of the file: it may be anything.
        for c in name.chars() {
            let c = if c.is_control() { char::REPLACEMENT_CHARACTER } else { c };
            out.extend_from_slice(c.encode_utf8(&mut [0; 4]).as_bytes());
        }
        self.channel_width = self.channel_width.max(out.len() - start);
        pad(out, start, self.channel_width);
    }
}

impl Lines for TextLines {
    fn line(&mut self, line: &Line<'_>, out: &mut Vec<u8>) {
        let Line { record, channels, decoded, meaning } = line;
        self.push_time(record.timestamp, out);
        out.extend_from_slice(b"  ");
        self.push_channel(channels.name(record.channel), out);
        out.extend_from_slice(b"  ");
        self.push_id(record, out);
        out.extend_from_slice(b"  ");
        push_data(record, out);
        let start = out.len();
        out.push(b' ');
        match decoded.node {
            Some(node) => {
                out.resize(out.len() + usize::from(node.raw() < 100) + usize::from(node.raw() < 10), b' ');
                push_decimal(out, u64::from(node.raw()));
            }
            None => out.push(b' '),
        }
        pad(out, start, 4);
        out.extend_from_slice(b"  ");
        let start = out.len();
        out.extend_from_slice(decoded.service.name().as_bytes());
        pad(out, start, SERVICE_WIDTH);
        out.extend_from_slice(b" ");
        let style = if self.color { style(decoded.service, &decoded.message, decoded.violation) } else { "" };
        out.extend_from_slice(style.as_bytes());
        // Writing to a vector can't fail.
        let _ = write!(out, "{meaning}");
        if !style.is_empty() {
            out.extend_from_slice(b"\x1b[0m");
        }
        out.push(b'\n');
    }
}

fn push_data(record: &Record, out: &mut Vec<u8>) {
    let start = out.len();
    if record.frame.is_remote() {
        out.extend_from_slice(b"remote, ");
        push_decimal(out, record.frame.len() as u64);
        out.extend_from_slice(b" bytes");
    } else {
        push_hex(out, record.data(), Some(b' '));
    }
    pad(out, start, DATA_WIDTH);
}

/// The escape sequence that sets off what a reader looks for: errors red, states yellow, commands cyan.
fn style(service: Service, message: &Message, violation: Option<Violation>) -> &'static str {
    use canvass_analyzer::wire::sdo::{Request, Response};
    match (service, message) {
        _ if violation.is_some() => "\x1b[31m",
        (_, Message::SdoRequest(Request::Abort(_)) | Message::SdoResponse(Response::Abort(_))) => "\x1b[31m",
        (_, Message::Malformed(..)) | (Service::ErrorFrame | Service::Emcy, _) => "\x1b[31m",
        (Service::BootUp, _) => "\x1b[33m",
        (Service::Nmt | Service::Lss | Service::Lmt, _) => "\x1b[36m",
        (Service::Pdo, _) => "\x1b[32m",
        (Service::Heartbeat | Service::Guarding | Service::Sync | Service::Unknown, _) => "\x1b[90m",
        _ => "",
    }
}
