//! JSON Lines: one object per frame, as `docs/json.md` describes it.

use super::{Line, Lines, push_decimal, push_hex};
use canvass_traces::Frame;
use std::io::Write;

/// The JSON rendering of `decode` and `monitor`.
#[derive(Default)]
pub struct JsonLines {
    begun: bool,
    /// The meaning before it is escaped; kept for its memory.
    text: String,
}

/// The contract's name and version.
const SCHEMA: &str = "canvass/decode/1";

impl JsonLines {
    /// A rendering that has written nothing yet.
    pub fn new() -> Self {
        Self::default()
    }
}

impl Lines for JsonLines {
    fn line(&mut self, line: &Line<'_>, out: &mut Vec<u8>) {
        use std::fmt::Write as _;
        let Line { record, channels, decoded, meaning } = line;
        out.push(b'{');
        if !std::mem::replace(&mut self.begun, true) {
            out.extend_from_slice(b"\"schema\":\"");
            out.extend_from_slice(SCHEMA.as_bytes());
            out.extend_from_slice(b"\",");
        }
        out.extend_from_slice(b"\"t\":");
        push_decimal(out, record.timestamp.nanos());
        out.extend_from_slice(b",\"channel\":");
        push_string(channels.name(record.channel), out);
        out.extend_from_slice(b",\"id\":");
        push_decimal(out, u64::from(record.frame.id().raw()));
        push_kind(&record.frame, out);
        out.extend_from_slice(b",\"data\":\"");
        push_hex(out, record.data(), None);
        out.extend_from_slice(b"\",\"node\":");
        match decoded.node {
            Some(node) => push_decimal(out, u64::from(node.raw())),
            None => out.extend_from_slice(b"null"),
        }
        out.extend_from_slice(b",\"service\":\"");
        out.extend_from_slice(decoded.service.name().as_bytes());
        out.extend_from_slice(b"\",");
        if let Some(object) = decoded.object {
            // Writing to a vector or string can't fail.
            let _ = write!(out, "\"index\":{},\"sub\":{},", object.index.0, object.sub.0);
        }
        out.extend_from_slice(b"\"text\":");
        self.text.clear();
        let _ = write!(self.text, "{meaning}");
        push_string(&self.text, out);
        out.extend_from_slice(b"}\n");
    }
}

/// What is not said of a classical data frame of 11 bits.
fn push_kind(frame: &Frame, out: &mut Vec<u8>) {
    let flags = [
        (frame.id().is_extended() && !frame.is_error(), "extended"),
        (frame.is_remote(), "remote"),
        (frame.is_error(), "error"),
        (frame.is_fd(), "fd"),
        (frame.is_xl(), "xl"),
    ];
    for (_, name) in flags.iter().filter(|flag| flag.0) {
        let _ = write!(out, ",\"{name}\":true");
    }
    if frame.is_remote() {
        let _ = write!(out, ",\"dlc\":{}", frame.len());
    }
}

/// Appends a JSON string.
fn push_string(text: &str, out: &mut Vec<u8>) {
    if text.bytes().all(|byte| byte >= b' ' && byte != b'"' && byte != b'\\') {
        out.push(b'"');
        out.extend_from_slice(text.as_bytes());
        out.push(b'"');
    } else {
        // Writing a string to a vector can't fail.
        let _ = serde_json::to_writer(out, text);
    }
}
