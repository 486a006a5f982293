//! Messages of an SDO server.

use super::{Abort, Payload, Segment, emit_initiate, emit_short, layouts, multiplexer, skip_reserved};
use crate::Multiplexer;
use crate::wire::{Fields, Layout, Malformed, Wire, named, tail_of};
use nom::{
    IResult, Parser,
    number::complete::{le_u16, le_u32, u8},
};

/// A message from server to client. The upper three bits of byte 0 are the server command specifier.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub enum Response {
    /// `000tnnnc`: a segment of an upload.
    UploadSegment(Segment),
    /// `001t----`: confirms a segment of a download.
    DownloadSegment {
        /// The toggle bit.
        toggle: bool,
    },
    /// `010-nnes`, multiplexer, value or size: answers the request to read.
    InitiateUpload {
        /// The object.
        multiplexer: Multiplexer,
        /// The value, or the announcement of segments.
        payload: Payload,
    },
    /// `011-----`, multiplexer: confirms the request to write.
    InitiateDownload {
        /// The object.
        multiplexer: Multiplexer,
    },
    /// `100-----`: ends the transfer.
    Abort(Abort),
    /// `101--c00`, multiplexer, block size: confirms the request to write in blocks.
    InitiateBlockDownload {
        /// The object.
        multiplexer: Multiplexer,
        /// The server can check a CRC.
        crc: bool,
        /// Segments in the first block, 1 to 127.
        block_size: u8,
    },
    /// `101---10`, last good sequence number, next block size: confirms a block.
    ConfirmBlockDownload {
        /// The sequence number of the last segment that came in order; 0: none.
        sequence: u8,
        /// Segments in the next block, 1 to 127.
        block_size: u8,
    },
    /// `101---01`: confirms the end of a block download.
    EndBlockDownload,
    /// `110--cs0`, multiplexer, size: answers the request to read in blocks.
    InitiateBlockUpload {
        /// The object.
        multiplexer: Multiplexer,
        /// The server can send a CRC.
        crc: bool,
        /// The total number of bytes, if given.
        size: Option<u32>,
    },
    /// `110nnn-1`, CRC: ends a block upload.
    EndBlockUpload {
        /// Number of unused bytes in the last segment, 0 to 7.
        unused: u8,
        /// The CRC over all data; 0 without CRC.
        crc: u16,
    },
    /// Command specifier 7, or a byte 0 that has no other form.
    Unknown {
        /// Byte 0.
        command: u8,
        /// The bytes after byte 0, filled up with zeros.
        tail: [u8; 7],
    },
}

impl Response {
    /// The answer with a value of 1 to 4 bytes, or the announcement of a longer value.
    pub fn upload(multiplexer: Multiplexer, value: &[u8]) -> Self {
        Self::InitiateUpload { multiplexer, payload: Payload::of(value) }
    }

    /// The abort of a transfer.
    pub const fn abort(multiplexer: Multiplexer, code: super::AbortCode) -> Self {
        Self::Abort(Abort { multiplexer, code })
    }

    /// The object that the message names.
    pub const fn multiplexer(&self) -> Option<Multiplexer> {
        match self {
            Self::InitiateDownload { multiplexer }
            | Self::InitiateUpload { multiplexer, .. }
            | Self::InitiateBlockUpload { multiplexer, .. }
            | Self::InitiateBlockDownload { multiplexer, .. }
            | Self::Abort(Abort { multiplexer, .. }) => Some(*multiplexer),
            _ => None,
        }
    }
}

impl Wire for Response {
    fn parse(input: &[u8]) -> IResult<&[u8], Self, Malformed> {
        let (rest, command) = named("an SDO command byte", u8).parse(input)?;
        match command >> 5 {
            0 => Segment::parse(command, rest).map(|(rest, segment)| (rest, Self::UploadSegment(segment))),
            1 => Ok((skip_reserved(rest, 7), Self::DownloadSegment { toggle: command & 0x10 != 0 })),
            2 => {
                let (rest, multiplexer) = multiplexer(rest)?;
                let (rest, payload) = Payload::parse(command, rest)?;
                Ok((rest, Self::InitiateUpload { multiplexer, payload }))
            }
            3 => {
                let (rest, multiplexer) = multiplexer(rest)?;
                Ok((skip_reserved(rest, 4), Self::InitiateDownload { multiplexer }))
            }
            4 => Abort::parse(input).map(|(rest, abort)| (rest, Self::Abort(abort))),
            5 => block_download(command, rest),
            6 => block_upload(command, rest),
            _ => Ok(unknown(command, rest)),
        }
    }

    fn emit(&self, buffer: &mut [u8; 8]) -> usize {
        match *self {
            Self::UploadSegment(segment) => segment.emit(0, buffer),
            Self::DownloadSegment { toggle } => emit_short(&[0x20 | u8::from(toggle) << 4], buffer),
            Self::InitiateUpload { multiplexer, payload } => {
                emit_initiate(0x40 | payload.bits(), multiplexer, payload.bytes(), buffer);
            }
            Self::InitiateDownload { multiplexer } => emit_initiate(0x60, multiplexer, [0; 4], buffer),
            Self::Abort(abort) => return abort.emit(buffer),
            Self::InitiateBlockDownload { multiplexer, crc, block_size } => {
                emit_initiate(0xA0 | u8::from(crc) << 2, multiplexer, [block_size, 0, 0, 0], buffer);
            }
            Self::ConfirmBlockDownload { sequence, block_size } => emit_short(&[0xA2, sequence, block_size], buffer),
            Self::EndBlockDownload => emit_short(&[0xA1], buffer),
            Self::InitiateBlockUpload { multiplexer, crc, size } => {
                let command = 0xC0 | u8::from(crc) << 2 | u8::from(size.is_some()) << 1;
                emit_initiate(command, multiplexer, size.unwrap_or(0).to_le_bytes(), buffer);
            }
            Self::EndBlockUpload { unused, crc } => {
                let [low, high] = crc.to_le_bytes();
                emit_short(&[0xC1 | (unused & 7) << 2, low, high], buffer);
            }
            Self::Unknown { command, tail } => {
                buffer[0] = command;
                buffer[1..].copy_from_slice(&tail);
            }
        }
        8
    }
}

static UPLOAD_SEGMENT: Layout = Layout { name: "upload segment", fields: layouts::SEGMENT };
static DOWNLOAD_SEGMENT: Layout = Layout { name: "download segment", fields: layouts::TOGGLE_ONLY };
static INITIATE_UPLOAD: Layout = Layout { name: "initiate upload", fields: layouts::INITIATE };
static INITIATE_DOWNLOAD: Layout = Layout { name: "initiate download", fields: layouts::OBJECT_ONLY };
static INITIATE_BLOCK_DOWNLOAD: Layout = Layout { name: "initiate block download", fields: layouts::BLOCK_ACCEPTED };
static CONFIRM_BLOCK_DOWNLOAD: Layout = Layout { name: "confirm block download", fields: layouts::BLOCK_CONFIRMED };
static END_BLOCK_DOWNLOAD: Layout = Layout { name: "end block download", fields: layouts::BLOCK_COMMAND };
static INITIATE_BLOCK_UPLOAD: Layout = Layout { name: "initiate block upload", fields: layouts::BLOCK_SIZE_STATED };
static END_BLOCK_UPLOAD: Layout = Layout { name: "end block upload", fields: layouts::BLOCK_ENDED };

impl Fields for Response {
    const LAYOUTS: &'static [&'static Layout] = &[
        &UPLOAD_SEGMENT,
        &DOWNLOAD_SEGMENT,
        &INITIATE_UPLOAD,
        &INITIATE_DOWNLOAD,
        &layouts::ABORT,
        &INITIATE_BLOCK_DOWNLOAD,
        &CONFIRM_BLOCK_DOWNLOAD,
        &END_BLOCK_DOWNLOAD,
        &INITIATE_BLOCK_UPLOAD,
        &END_BLOCK_UPLOAD,
        &layouts::UNKNOWN,
    ];

    fn layout(&self) -> &'static Layout {
        match self {
            Self::UploadSegment(_) => &UPLOAD_SEGMENT,
            Self::DownloadSegment { .. } => &DOWNLOAD_SEGMENT,
            Self::InitiateUpload { .. } => &INITIATE_UPLOAD,
            Self::InitiateDownload { .. } => &INITIATE_DOWNLOAD,
            Self::Abort(_) => &layouts::ABORT,
            Self::InitiateBlockDownload { .. } => &INITIATE_BLOCK_DOWNLOAD,
            Self::ConfirmBlockDownload { .. } => &CONFIRM_BLOCK_DOWNLOAD,
            Self::EndBlockDownload => &END_BLOCK_DOWNLOAD,
            Self::InitiateBlockUpload { .. } => &INITIATE_BLOCK_UPLOAD,
            Self::EndBlockUpload { .. } => &END_BLOCK_UPLOAD,
            Self::Unknown { .. } => &layouts::UNKNOWN,
        }
    }
}

fn block_download(command: u8, rest: &[u8]) -> IResult<&[u8], Response, Malformed> {
    match command & 0b11 {
        0 => {
            let (rest, multiplexer) = multiplexer(rest)?;
            let (rest, block_size) = named("a block size", u8).parse(rest)?;
            let crc = command & 0b100 != 0;
            Ok((skip_reserved(rest, 3), Response::InitiateBlockDownload { multiplexer, crc, block_size }))
        }
        1 => Ok((skip_reserved(rest, 7), Response::EndBlockDownload)),
        2 => {
            let (rest, (sequence, block_size)) =
                (named("a sequence number", u8), named("a block size", u8)).parse(rest)?;
            Ok((skip_reserved(rest, 5), Response::ConfirmBlockDownload { sequence, block_size }))
        }
        _ => Ok(unknown(command, rest)),
    }
}

fn block_upload(command: u8, rest: &[u8]) -> IResult<&[u8], Response, Malformed> {
    if command & 1 != 0 {
        let (rest, crc) = named("a CRC in two bytes", le_u16).parse(rest)?;
        return Ok((skip_reserved(rest, 5), Response::EndBlockUpload { unused: command >> 2 & 7, crc }));
    }
    let (rest, multiplexer) = multiplexer(rest)?;
    let crc = command & 0b100 != 0;
    if command & 0b10 == 0 {
        return Ok((skip_reserved(rest, 4), Response::InitiateBlockUpload { multiplexer, crc, size: None }));
    }
    let (rest, size) = named("a size in four bytes", le_u32).parse(rest)?;
    Ok((rest, Response::InitiateBlockUpload { multiplexer, crc, size: Some(size) }))
}

fn unknown(command: u8, rest: &[u8]) -> (&[u8], Response) {
    let (tail, rest) = tail_of(rest);
    (rest, Response::Unknown { command, tail })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::wire::fields::tests::heeded;
    use crate::wire::sdo::AbortCode;
    use crate::wire::vectors::{both_ways, stable, whole};
    use proptest::prelude::*;

    /// Kübler manual 000, 5.3.7.4 and 5.8.4.
    #[test]
    fn responses_of_the_manual() {
        let multiplexer = Multiplexer::new(0x6000, 0);
        both_ways(&[0x60, 0x00, 0x60, 0x00, 0, 0, 0, 0], Response::InitiateDownload { multiplexer });
        both_ways(&[0x4B, 0x00, 0x60, 0x00, 1, 0, 0, 0], Response::upload(multiplexer, &[1, 0]));
        let refused = Response::abort(Multiplexer::new(0x5000, 0), AbortCode::READ_ONLY);
        both_ways(&[0x80, 0x00, 0x50, 0x00, 0x02, 0x00, 0x01, 0x06], refused);
    }

    /// The layouts of CiA 301, 7.2.4.3.
    #[test]
    fn every_command() {
        let multiplexer = Multiplexer::new(0x1008, 0);
        both_ways(
            &[0x41, 0x08, 0x10, 0, 22, 0, 0, 0],
            Response::InitiateUpload { multiplexer, payload: Payload::Segmented(22) },
        );
        both_ways(&[0x0D, b'x', 0, 0, 0, 0, 0, 0], Response::UploadSegment(Segment::new(false, b"x", true).unwrap()));
        both_ways(
            &[0x10, 1, 2, 3, 4, 5, 6, 7],
            Response::UploadSegment(Segment::new(true, &[1, 2, 3, 4, 5, 6, 7], false).unwrap()),
        );
        both_ways(&[0x30, 0, 0, 0, 0, 0, 0, 0], Response::DownloadSegment { toggle: true });
        both_ways(
            &[0xA4, 0x08, 0x10, 0, 127, 0, 0, 0],
            Response::InitiateBlockDownload { multiplexer, crc: true, block_size: 127 },
        );
        both_ways(&[0xA2, 3, 20, 0, 0, 0, 0, 0], Response::ConfirmBlockDownload { sequence: 3, block_size: 20 });
        both_ways(&[0xA1, 0, 0, 0, 0, 0, 0, 0], Response::EndBlockDownload);
        both_ways(
            &[0xC6, 0x08, 0x10, 0, 22, 0, 0, 0],
            Response::InitiateBlockUpload { multiplexer, crc: true, size: Some(22) },
        );
        both_ways(&[0xD9, 0x34, 0x12, 0, 0, 0, 0, 0], Response::EndBlockUpload { unused: 6, crc: 0x1234 });
        both_ways(&[0xA3, 1, 2, 3, 4, 5, 6, 7], Response::Unknown { command: 0xA3, tail: [1, 2, 3, 4, 5, 6, 7] });
        both_ways(&[0xFF, 0, 0, 0, 0, 0, 0, 0], Response::Unknown { command: 0xFF, tail: [0; 7] });
    }

    /// Bits that the standard reserves (`-` in the pictures above) do not change the message.
    #[test]
    fn reserved_bits_are_ignored() {
        assert_eq!(Response::read(&[0x2F, 0, 0, 0, 0, 0, 0, 0]), Ok(Response::DownloadSegment { toggle: false }));
        assert_eq!(Response::read(&[0x3F, 0, 0, 0, 0, 0, 0, 0]), Ok(Response::DownloadSegment { toggle: true }));
        let multiplexer = Multiplexer::new(0x1008, 0);
        assert_eq!(Response::read(&[0x7F, 8, 0x10, 0, 0, 0, 0, 0]), Ok(Response::InitiateDownload { multiplexer }));
        assert_eq!(Response::read(&[0xBD, 0, 0, 0, 0, 0, 0, 0]), Ok(Response::EndBlockDownload));
    }

    /// The parser takes exactly the bytes as reserved that the standard reserves (CiA 301, 7.2.4.3).
    #[test]
    fn reserved_bytes_belong_to_the_message() {
        let multiplexer = Multiplexer::new(0x1008, 0);
        let initiate = |payload| Response::InitiateUpload { multiplexer, payload };
        whole([0x60, 0x08, 0x10, 0, 0, 0, 0, 0], Response::InitiateDownload { multiplexer }, 4);
        whole([0x20, 0, 0, 0, 0, 0, 0, 0], Response::DownloadSegment { toggle: false }, 7);
        whole([0x30, 0, 0, 0, 0, 0, 0, 0], Response::DownloadSegment { toggle: true }, 7);
        whole([0x80, 0x08, 0x10, 0, 0, 0, 4, 5], Response::abort(multiplexer, AbortCode::TIMEOUT), 0);
        for (length, command) in [(1, 0x4F), (2, 0x4B), (3, 0x47), (4, 0x43)] {
            let value = &[1, 2, 3, 4][..length];
            let mut bytes = [command, 0x08, 0x10, 0, 0, 0, 0, 0];
            bytes[4..4 + length].copy_from_slice(value);
            whole(bytes, Response::upload(multiplexer, value), 4 - length);
        }
        whole([0x40, 0x08, 0x10, 0, 0, 0, 0, 0], initiate(Payload::SegmentedUnsized), 4);
        whole([0x41, 0x08, 0x10, 0, 8, 0, 0, 0], initiate(Payload::Segmented(8)), 0);
        whole([0x42, 0x08, 0x10, 0, 1, 2, 3, 4], initiate(Payload::ExpeditedUnsized([1, 2, 3, 4])), 0);
        let accepted = |crc| Response::InitiateBlockDownload { multiplexer, crc, block_size: 9 };
        whole([0xA0, 0x08, 0x10, 0, 9, 0, 0, 0], accepted(false), 3);
        whole([0xA4, 0x08, 0x10, 0, 9, 0, 0, 0], accepted(true), 3);
        whole([0xA1, 0, 0, 0, 0, 0, 0, 0], Response::EndBlockDownload, 7);
        whole([0xA2, 5, 9, 0, 0, 0, 0, 0], Response::ConfirmBlockDownload { sequence: 5, block_size: 9 }, 5);
        let upload = |crc, size| Response::InitiateBlockUpload { multiplexer, crc, size };
        whole([0xC0, 0x08, 0x10, 0, 0, 0, 0, 0], upload(false, None), 4);
        whole([0xC4, 0x08, 0x10, 0, 0, 0, 0, 0], upload(true, None), 4);
        whole([0xC2, 0x08, 0x10, 0, 9, 0, 0, 0], upload(false, Some(9)), 0);
        for unused in 0..=7 {
            let end = Response::EndBlockUpload { unused, crc: 0x31C3 };
            whole([0xC1 | unused << 2, 0xC3, 0x31, 0, 0, 0, 0, 0], end, 5);
        }
        whole([0xE0, 1, 2, 3, 4, 5, 6, 7], Response::Unknown { command: 0xE0, tail: [1, 2, 3, 4, 5, 6, 7] }, 0);
    }

    /// Whether the field has no meaning in this response: bytes that hold no data, and a size that is not indicated.
    fn carries_nothing(response: &Response, field: crate::wire::Field) -> bool {
        match response {
            Response::UploadSegment(segment) => field.name == "data" && segment.data().len() < 7,
            Response::InitiateUpload { payload: Payload::Expedited(value), .. } => {
                field.name == "data" && value.data().len() < 4
            }
            Response::InitiateUpload { payload: Payload::SegmentedUnsized, .. } => {
                matches!(field.name, "data" | "unused bytes")
            }
            Response::InitiateUpload { .. } => field.name == "unused bytes",
            Response::InitiateBlockUpload { size: None, .. } => field.name == "size",
            _ => false,
        }
    }

    proptest! {
        #[test]
        fn every_field_is_heeded(bytes: [u8; 8]) {
            heeded::<Response>(&bytes, carries_nothing);
        }

        #[test]
        fn any_bytes(bytes in proptest::collection::vec(any::<u8>(), 0..=8)) {
            stable::<Response>(&bytes);
        }
    }
}
