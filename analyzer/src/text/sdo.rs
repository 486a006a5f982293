//! SDO messages as text.

use super::Meaning;
use super::object::Object;
use crate::Multiplexer;
use crate::network::sdo::{Mode, Outcome, Side, Transfer};
use crate::wire::sdo::{Abort, BlockSegment, Payload, Request, Response, Segment};
use std::fmt::{self, Display};

impl Meaning<'_> {
    pub(super) fn sdo_request(&self, request: &Request, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *request {
            Request::InitiateUpload { multiplexer } => {
                f.write_str("read ")?;
                self.object(multiplexer).fmt(f)
            }
            Request::InitiateDownload { multiplexer, payload } => {
                f.write_str("write ")?;
                self.object(multiplexer).fmt(f)?;
                self.payload(multiplexer, payload, f)
            }
            Request::DownloadSegment(segment) => self.segment(segment, f),
            Request::UploadSegment { toggle } => {
                write!(f, "next segment of {}, toggle {}", self.current(), u8::from(toggle))
            }
            Request::Abort(abort) => self.abort(Side::Client, abort, f),
            Request::InitiateBlockUpload { multiplexer, crc, block_size, threshold } => {
                write!(f, "block read {}, {block_size} segments a block", self.object(multiplexer))?;
                crc_text(crc, f)?;
                if threshold > 0 { write!(f, ", normal upload up to {threshold} bytes") } else { Ok(()) }
            }
            Request::StartBlockUpload => write!(f, "start block read of {}", self.current()),
            Request::ConfirmBlockUpload { sequence, block_size } => self.confirm(sequence, block_size, f),
            Request::EndBlockUpload => {
                write!(f, "end of block read confirmed: ")?;
                self.result(f)
            }
            Request::InitiateBlockDownload { multiplexer, crc, size } => {
                write!(f, "block write {}", self.object(multiplexer))?;
                size_text(size, f)?;
                crc_text(crc, f)
            }
            Request::EndBlockDownload { unused, crc } => end(unused, crc, f),
            Request::Unknown { command, .. } => write!(f, "unknown client command {command:02X}h"),
        }
    }

    pub(super) fn sdo_response(&self, response: &Response, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *response {
            Response::InitiateUpload { multiplexer, payload } => {
                f.write_str("read answered: ")?;
                self.object(multiplexer).fmt(f)?;
                self.payload(multiplexer, payload, f)
            }
            Response::InitiateDownload { multiplexer } => {
                let open = self.transfer().is_some_and(|transfer| transfer.is_open());
                let what = if open { "write accepted" } else { "write confirmed" };
                f.write_str(what)?;
                f.write_str(": ")?;
                self.object(multiplexer).fmt(f)
            }
            Response::UploadSegment(segment) => self.segment(segment, f),
            Response::DownloadSegment { toggle } => {
                write!(f, "segment of {} confirmed, toggle {}", self.current(), u8::from(toggle))?;
                self.result_if_complete(f)
            }
            Response::Abort(abort) => self.abort(Side::Server, abort, f),
            Response::InitiateBlockDownload { multiplexer, crc, block_size } => {
                write!(f, "block write accepted: {}, {block_size} segments a block", self.object(multiplexer))?;
                crc_text(crc, f)
            }
            Response::ConfirmBlockDownload { sequence, block_size } => self.confirm(sequence, block_size, f),
            Response::EndBlockDownload => {
                write!(f, "end of block write confirmed: ")?;
                self.result(f)
            }
            Response::InitiateBlockUpload { multiplexer, crc, size } => {
                write!(f, "block read accepted: {}", self.object(multiplexer))?;
                size_text(size, f)?;
                crc_text(crc, f)
            }
            Response::EndBlockUpload { unused, crc } => end(unused, crc, f),
            Response::Unknown { command, .. } => write!(f, "unknown server command {command:02X}h"),
        }
    }

    pub(super) fn sdo_block(&self, segment: &BlockSegment, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "block segment {} of {}", segment.sequence, self.current())?;
        if segment.last { f.write_str(", the last") } else { Ok(()) }
    }

    /// The transfer of the frame.
    fn transfer(&self) -> Option<&Transfer> {
        self.bus.transfer(self.decoded.channel?)
    }

    fn object(&self, multiplexer: Multiplexer) -> Object<'_> {
        Object::new(self.decoded.node, self.decoded.node.and_then(|node| self.bus.node(node)), multiplexer)
    }

    /// The object of the open transfer.
    fn current(&self) -> Current<'_> {
        Current(self.decoded.object.map(|multiplexer| self.object(multiplexer)))
    }

    fn payload(&self, multiplexer: Multiplexer, payload: Payload, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match payload {
            Payload::Expedited(value) => {
                f.write_str(" = ")?;
                self.object(multiplexer).value(value.data()).fmt(f)
            }
            Payload::ExpeditedUnsized(value) => {
                write!(f, " = {} (length not said)", self.object(multiplexer).leading(&value))
            }
            Payload::Segmented(size) => write!(f, ", {size} bytes in segments"),
            Payload::SegmentedUnsized => f.write_str(", in segments of unsaid length"),
        }
    }

    fn segment(&self, segment: Segment, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let last = if segment.last { "last segment" } else { "segment" };
        let (n, toggle) = (segment.data().len(), u8::from(segment.toggle));
        write!(f, "{last} of {}, {n} bytes, toggle {toggle}", self.current())?;
        self.result_if_complete(f)
    }

    fn confirm(&self, sequence: u8, block_size: u8, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "block of {} confirmed up to segment {sequence}, next {block_size} segments", self.current())
    }

    fn abort(&self, side: Side, abort: Abort, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{side} aborts {}: {}", self.object(abort.multiplexer), abort.code)
    }

    /// The whole value, at the frame that completes its transfer.
    fn result_if_complete(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.decoded.event.is_none() || self.transfer().is_none_or(|t| t.outcome != Outcome::Complete) {
            return Ok(());
        }
        f.write_str(": ")?;
        self.result(f)
    }

    fn result(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Some(transfer) = self.transfer() else { return f.write_str("no transfer") };
        let object = self.object(transfer.multiplexer);
        match transfer.mode {
            Mode::Expedited => write!(f, "{object} = {}", object.value(transfer.data())),
            _ => write!(f, "{object} = {} ({} bytes)", object.value(transfer.data()), transfer.length()),
        }
    }
}

/// The object of a transfer, if known.
struct Current<'a>(Option<Object<'a>>);

impl fmt::Display for Current<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.0 {
            Some(object) => object.fmt(f),
            None => f.write_str("an unknown transfer"),
        }
    }
}

fn size_text(size: Option<u32>, f: &mut fmt::Formatter<'_>) -> fmt::Result {
    match size {
        Some(size) => write!(f, ", {size} bytes"),
        None => Ok(()),
    }
}

fn crc_text(crc: bool, f: &mut fmt::Formatter<'_>) -> fmt::Result {
    f.write_str(if crc { ", with CRC" } else { ", without CRC" })
}

fn end(unused: u8, crc: u16, f: &mut fmt::Formatter<'_>) -> fmt::Result {
    write!(f, "end of blocks, {} bytes in the last segment, CRC {crc:04X}h", 7 - unused.min(7))
}
