//! Messages of an SDO client.

use super::{Abort, Payload, Segment, emit_initiate, emit_short, layouts, multiplexer, skip_reserved};
use crate::Multiplexer;
use crate::wire::{Fields, Layout, Malformed, Wire, named, tail_of};
use nom::{
    IResult, Parser,
    number::complete::{le_u16, le_u32, u8},
};

/// A message from client to server. The upper three bits of byte 0 are the client command specifier.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub enum Request {
    /// `000tnnnc`: a segment of a download.
    DownloadSegment(Segment),
    /// `001-nnes`, multiplexer, value or size: writes an object.
    InitiateDownload {
        /// The object.
        multiplexer: Multiplexer,
        /// The value, or the announcement of segments.
        payload: Payload,
    },
    /// `010-----`, multiplexer: reads an object.
    InitiateUpload {
        /// The object.
        multiplexer: Multiplexer,
    },
    /// `011t----`: requests the next segment of an upload.
    UploadSegment {
        /// The toggle bit.
        toggle: bool,
    },
    /// `100-----`: ends the transfer.
    Abort(Abort),
    /// `101--c00`, multiplexer, block size, protocol switch threshold: reads an object in blocks.
    InitiateBlockUpload {
        /// The object.
        multiplexer: Multiplexer,
        /// The client can check a CRC.
        crc: bool,
        /// Segments in a block, 1 to 127.
        block_size: u8,
        /// Up to this size the server may answer with a normal upload; 0: never.
        threshold: u8,
    },
    /// `101---01`: confirms the end of a block upload.
    EndBlockUpload,
    /// `101---10`, last good sequence number, next block size: confirms a block.
    ConfirmBlockUpload {
        /// The sequence number of the last segment that came in order; 0: none.
        sequence: u8,
        /// Segments in the next block, 1 to 127.
        block_size: u8,
    },
    /// `101---11`: requests the first block.
    StartBlockUpload,
    /// `110--cs0`, multiplexer, size: writes an object in blocks.
    InitiateBlockDownload {
        /// The object.
        multiplexer: Multiplexer,
        /// The client can send a CRC.
        crc: bool,
        /// The total number of bytes, if given.
        size: Option<u32>,
    },
    /// `110nnn-1`, CRC: ends a block download.
    EndBlockDownload {
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

impl Request {
    /// The request to read an object.
    pub const fn upload(multiplexer: Multiplexer) -> Self {
        Self::InitiateUpload { multiplexer }
    }

    /// The request that writes a value of 1 to 4 bytes, or announces a longer value.
    pub fn download(multiplexer: Multiplexer, value: &[u8]) -> Self {
        Self::InitiateDownload { multiplexer, payload: Payload::of(value) }
    }

    /// The abort of a transfer.
    pub const fn abort(multiplexer: Multiplexer, code: super::AbortCode) -> Self {
        Self::Abort(Abort { multiplexer, code })
    }

    /// The object that the message names.
    pub const fn multiplexer(&self) -> Option<Multiplexer> {
        match self {
            Self::InitiateDownload { multiplexer, .. }
            | Self::InitiateUpload { multiplexer }
            | Self::InitiateBlockUpload { multiplexer, .. }
            | Self::InitiateBlockDownload { multiplexer, .. }
            | Self::Abort(Abort { multiplexer, .. }) => Some(*multiplexer),
            _ => None,
        }
    }
}

impl Wire for Request {
    fn parse(input: &[u8]) -> IResult<&[u8], Self, Malformed> {
        let (rest, command) = named("an SDO command byte", u8).parse(input)?;
        match command >> 5 {
            0 => Segment::parse(command, rest).map(|(rest, segment)| (rest, Self::DownloadSegment(segment))),
            1 => {
                let (rest, multiplexer) = multiplexer(rest)?;
                let (rest, payload) = Payload::parse(command, rest)?;
                Ok((rest, Self::InitiateDownload { multiplexer, payload }))
            }
            2 => {
                let (rest, multiplexer) = multiplexer(rest)?;
                Ok((skip_reserved(rest, 4), Self::InitiateUpload { multiplexer }))
            }
            3 => Ok((skip_reserved(rest, 7), Self::UploadSegment { toggle: command & 0x10 != 0 })),
            4 => Abort::parse(input).map(|(rest, abort)| (rest, Self::Abort(abort))),
            5 => block_upload(command, rest),
            6 => block_download(command, rest),
            _ => Ok(unknown(command, rest)),
        }
    }

    fn emit(&self, buffer: &mut [u8; 8]) -> usize {
        match *self {
            Self::DownloadSegment(segment) => segment.emit(0, buffer),
            Self::InitiateDownload { multiplexer, payload } => {
                emit_initiate(0x20 | payload.bits(), multiplexer, payload.bytes(), buffer);
            }
            Self::InitiateUpload { multiplexer } => emit_initiate(0x40, multiplexer, [0; 4], buffer),
            Self::UploadSegment { toggle } => emit_short(&[0x60 | u8::from(toggle) << 4], buffer),
            Self::Abort(abort) => return abort.emit(buffer),
            Self::InitiateBlockUpload { multiplexer, crc, block_size, threshold } => {
                emit_initiate(0xA0 | u8::from(crc) << 2, multiplexer, [block_size, threshold, 0, 0], buffer);
            }
            Self::EndBlockUpload => emit_short(&[0xA1], buffer),
            Self::ConfirmBlockUpload { sequence, block_size } => emit_short(&[0xA2, sequence, block_size], buffer),
            Self::StartBlockUpload => emit_short(&[0xA3], buffer),
            Self::InitiateBlockDownload { multiplexer, crc, size } => {
                let command = 0xC0 | u8::from(crc) << 2 | u8::from(size.is_some()) << 1;
                emit_initiate(command, multiplexer, size.unwrap_or(0).to_le_bytes(), buffer);
            }
            Self::EndBlockDownload { unused, crc } => {
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

static DOWNLOAD_SEGMENT: Layout = Layout { name: "download segment", fields: layouts::SEGMENT };
static INITIATE_DOWNLOAD: Layout = Layout { name: "initiate download", fields: layouts::INITIATE };
static INITIATE_UPLOAD: Layout = Layout { name: "initiate upload", fields: layouts::OBJECT_ONLY };
static UPLOAD_SEGMENT: Layout = Layout { name: "upload segment", fields: layouts::TOGGLE_ONLY };
static INITIATE_BLOCK_UPLOAD: Layout = Layout { name: "initiate block upload", fields: layouts::BLOCK_REQUESTED };
static END_BLOCK_UPLOAD: Layout = Layout { name: "end block upload", fields: layouts::BLOCK_COMMAND };
static START_BLOCK_UPLOAD: Layout = Layout { name: "start block upload", fields: layouts::BLOCK_COMMAND };
static CONFIRM_BLOCK_UPLOAD: Layout = Layout { name: "confirm block upload", fields: layouts::BLOCK_CONFIRMED };
static INITIATE_BLOCK_DOWNLOAD: Layout = Layout { name: "initiate block download", fields: layouts::BLOCK_SIZE_STATED };
static END_BLOCK_DOWNLOAD: Layout = Layout { name: "end block download", fields: layouts::BLOCK_ENDED };

impl Fields for Request {
    const LAYOUTS: &'static [&'static Layout] = &[
        &DOWNLOAD_SEGMENT,
        &INITIATE_DOWNLOAD,
        &INITIATE_UPLOAD,
        &UPLOAD_SEGMENT,
        &layouts::ABORT,
        &INITIATE_BLOCK_UPLOAD,
        &END_BLOCK_UPLOAD,
        &CONFIRM_BLOCK_UPLOAD,
        &START_BLOCK_UPLOAD,
        &INITIATE_BLOCK_DOWNLOAD,
        &END_BLOCK_DOWNLOAD,
        &layouts::UNKNOWN,
    ];

    fn layout(&self) -> &'static Layout {
        match self {
            Self::DownloadSegment(_) => &DOWNLOAD_SEGMENT,
            Self::InitiateDownload { .. } => &INITIATE_DOWNLOAD,
            Self::InitiateUpload { .. } => &INITIATE_UPLOAD,
            Self::UploadSegment { .. } => &UPLOAD_SEGMENT,
            Self::Abort(_) => &layouts::ABORT,
            Self::InitiateBlockUpload { .. } => &INITIATE_BLOCK_UPLOAD,
            Self::EndBlockUpload => &END_BLOCK_UPLOAD,
            Self::ConfirmBlockUpload { .. } => &CONFIRM_BLOCK_UPLOAD,
            Self::StartBlockUpload => &START_BLOCK_UPLOAD,
            Self::InitiateBlockDownload { .. } => &INITIATE_BLOCK_DOWNLOAD,
            Self::EndBlockDownload { .. } => &END_BLOCK_DOWNLOAD,
            Self::Unknown { .. } => &layouts::UNKNOWN,
        }
    }
}

fn block_upload(command: u8, rest: &[u8]) -> IResult<&[u8], Request, Malformed> {
    match command & 0b11 {
        0 => {
            let (rest, multiplexer) = multiplexer(rest)?;
            let (rest, block_size) = named("a block size", u8).parse(rest)?;
            // Old clients leave out the threshold.
            let (rest, threshold) = (rest.get(1..).unwrap_or(&[]), rest.first().copied().unwrap_or(0));
            let crc = command & 0b100 != 0;
            Ok((skip_reserved(rest, 2), Request::InitiateBlockUpload { multiplexer, crc, block_size, threshold }))
        }
        1 => Ok((skip_reserved(rest, 7), Request::EndBlockUpload)),
        2 => {
            let (rest, (sequence, block_size)) =
                (named("a sequence number", u8), named("a block size", u8)).parse(rest)?;
            Ok((skip_reserved(rest, 5), Request::ConfirmBlockUpload { sequence, block_size }))
        }
        _ => Ok((skip_reserved(rest, 7), Request::StartBlockUpload)),
    }
}

fn block_download(command: u8, rest: &[u8]) -> IResult<&[u8], Request, Malformed> {
    if command & 1 != 0 {
        let (rest, crc) = named("a CRC in two bytes", le_u16).parse(rest)?;
        return Ok((skip_reserved(rest, 5), Request::EndBlockDownload { unused: command >> 2 & 7, crc }));
    }
    let (rest, multiplexer) = multiplexer(rest)?;
    let crc = command & 0b100 != 0;
    if command & 0b10 == 0 {
        return Ok((skip_reserved(rest, 4), Request::InitiateBlockDownload { multiplexer, crc, size: None }));
    }
    let (rest, size) = named("a size in four bytes", le_u32).parse(rest)?;
    Ok((rest, Request::InitiateBlockDownload { multiplexer, crc, size: Some(size) }))
}

fn unknown(command: u8, rest: &[u8]) -> (&[u8], Request) {
    let (tail, rest) = tail_of(rest);
    (rest, Request::Unknown { command, tail })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::wire::fields::tests::heeded;
    use crate::wire::sdo::{AbortCode, Expedited};
    use crate::wire::vectors::{both_ways, stable, whole};
    use proptest::prelude::*;

    const COUNTING_DIRECTION: Multiplexer = Multiplexer::new(0x6000, 0);

    /// Kübler manual 000, 5.3.7.4 and 5.7.7.
    #[test]
    fn expedited_requests_of_the_manual() {
        let write = Request::download(COUNTING_DIRECTION, &[1, 0]);
        both_ways(&[0x2B, 0x00, 0x60, 0x00, 0x01, 0x00, 0x00, 0x00], write);
        both_ways(&[0x40, 0x00, 0x60, 0x00, 0, 0, 0, 0], Request::upload(COUNTING_DIRECTION));
        let save = Request::download(Multiplexer::new(0x1010, 1), b"save");
        both_ways(&[0x23, 0x10, 0x10, 0x01, 0x73, 0x61, 0x76, 0x65], save);
        let bit_rate = Request::download(Multiplexer::new(0x2100, 0), &[5]);
        both_ways(&[0x2F, 0x00, 0x21, 0x00, 0x05, 0x00, 0x00, 0x00], bit_rate);
    }

    /// The layouts of CiA 301, 7.2.4.3.
    #[test]
    fn every_command() {
        let multiplexer = Multiplexer::new(0x1F50, 1);
        let initiate = |payload| Request::InitiateDownload { multiplexer, payload };
        both_ways(&[0x22, 0x50, 0x1F, 1, 1, 2, 3, 4], initiate(Payload::ExpeditedUnsized([1, 2, 3, 4])));
        both_ways(&[0x21, 0x50, 0x1F, 1, 0, 1, 0, 0], initiate(Payload::Segmented(256)));
        both_ways(&[0x20, 0x50, 0x1F, 1, 0, 0, 0, 0], initiate(Payload::SegmentedUnsized));
        both_ways(
            &[0x27, 0x50, 0x1F, 1, 1, 2, 3, 0],
            initiate(Payload::Expedited(Expedited::new(&[1, 2, 3]).unwrap())),
        );
        both_ways(
            &[0x00, 1, 2, 3, 4, 5, 6, 7],
            Request::DownloadSegment(Segment::new(false, &[1, 2, 3, 4, 5, 6, 7], false).unwrap()),
        );
        both_ways(&[0x1D, 9, 0, 0, 0, 0, 0, 0], Request::DownloadSegment(Segment::new(true, &[9], true).unwrap()));
        both_ways(&[0x60, 0, 0, 0, 0, 0, 0, 0], Request::UploadSegment { toggle: false });
        both_ways(&[0x70, 0, 0, 0, 0, 0, 0, 0], Request::UploadSegment { toggle: true });
        both_ways(&[0x80, 0x50, 0x1F, 1, 0, 0, 4, 5], Request::abort(multiplexer, AbortCode::TIMEOUT));
        both_ways(
            &[0xA4, 0x50, 0x1F, 1, 0x7F, 0x0E, 0, 0],
            Request::InitiateBlockUpload { multiplexer, crc: true, block_size: 127, threshold: 14 },
        );
        both_ways(&[0xA1, 0, 0, 0, 0, 0, 0, 0], Request::EndBlockUpload);
        both_ways(&[0xA2, 5, 127, 0, 0, 0, 0, 0], Request::ConfirmBlockUpload { sequence: 5, block_size: 127 });
        both_ways(&[0xA3, 0, 0, 0, 0, 0, 0, 0], Request::StartBlockUpload);
        both_ways(
            &[0xC6, 0x50, 0x1F, 1, 9, 0, 0, 0],
            Request::InitiateBlockDownload { multiplexer, crc: true, size: Some(9) },
        );
        both_ways(
            &[0xC0, 0x50, 0x1F, 1, 0, 0, 0, 0],
            Request::InitiateBlockDownload { multiplexer, crc: false, size: None },
        );
        both_ways(&[0xD5, 0xC3, 0x31, 0, 0, 0, 0, 0], Request::EndBlockDownload { unused: 5, crc: 0x31C3 });
        both_ways(&[0xE0, 1, 2, 3, 4, 5, 6, 7], Request::Unknown { command: 0xE0, tail: [1, 2, 3, 4, 5, 6, 7] });
    }

    /// Bits that the standard reserves (`-` in the pictures above) do not change the message.
    #[test]
    fn reserved_bits_are_ignored() {
        assert_eq!(Request::read(&[0x6F, 0, 0, 0, 0, 0, 0, 0]), Ok(Request::UploadSegment { toggle: false }));
        assert_eq!(Request::read(&[0x7F, 0, 0, 0, 0, 0, 0, 0]), Ok(Request::UploadSegment { toggle: true }));
        assert_eq!(Request::read(&[0x5F, 0, 0x60, 0, 0, 0, 0, 0]), Ok(Request::upload(COUNTING_DIRECTION)));
        assert_eq!(Request::read(&[0xBD, 0, 0, 0, 0, 0, 0, 0]), Ok(Request::EndBlockUpload));
        assert_eq!(Request::read(&[0xBF, 0, 0, 0, 0, 0, 0, 0]), Ok(Request::StartBlockUpload));
    }

    /// Requests with fewer than eight bytes occur; they are read as far as their meaning needs.
    #[test]
    fn short_requests() {
        assert_eq!(Request::read(&[0x40, 0x00, 0x60, 0x00]), Ok(Request::upload(COUNTING_DIRECTION)));
        assert_eq!(Request::read(&[0x2B, 0x00, 0x60, 0x00, 1, 0]), Ok(Request::download(COUNTING_DIRECTION, &[1, 0])));
        assert_eq!(
            Request::read(&[0x2B, 0x00, 0x60, 0x00, 1]),
            Err(Malformed { offset: 4, expected: "the value that the command byte announces" })
        );
        assert_eq!(Request::read(&[0x40, 0x00]), Err(Malformed { offset: 1, expected: "index and sub-index" }));
        assert_eq!(Request::read(&[]), Err(Malformed { offset: 0, expected: "an SDO command byte" }));
    }

    /// The parser takes exactly the bytes as reserved that the standard reserves (CiA 301, 7.2.4.3).
    #[test]
    fn reserved_bytes_belong_to_the_message() {
        let multiplexer = Multiplexer::new(0x1F50, 1);
        let initiate = |payload| Request::InitiateDownload { multiplexer, payload };
        whole([0x40, 0x50, 0x1F, 1, 0, 0, 0, 0], Request::upload(multiplexer), 4);
        whole([0x60, 0, 0, 0, 0, 0, 0, 0], Request::UploadSegment { toggle: false }, 7);
        whole([0x70, 0, 0, 0, 0, 0, 0, 0], Request::UploadSegment { toggle: true }, 7);
        whole([0x80, 0x50, 0x1F, 1, 0, 0, 4, 5], Request::abort(multiplexer, AbortCode::TIMEOUT), 0);
        for (length, command) in [(1, 0x2F), (2, 0x2B), (3, 0x27), (4, 0x23)] {
            let value = &[1, 2, 3, 4][..length];
            let mut bytes = [command, 0x50, 0x1F, 1, 0, 0, 0, 0];
            bytes[4..4 + length].copy_from_slice(value);
            whole(bytes, Request::download(multiplexer, value), 4 - length);
        }
        whole([0x20, 0x50, 0x1F, 1, 0, 0, 0, 0], initiate(Payload::SegmentedUnsized), 4);
        whole([0x21, 0x50, 0x1F, 1, 8, 0, 0, 0], initiate(Payload::Segmented(8)), 0);
        whole([0x22, 0x50, 0x1F, 1, 1, 2, 3, 4], initiate(Payload::ExpeditedUnsized([1, 2, 3, 4])), 0);
        for length in 0..=7 {
            let data = &[1, 2, 3, 4, 5, 6, 7][..length];
            let mut bytes = [(7 - length as u8) << 1, 0, 0, 0, 0, 0, 0, 0];
            bytes[1..=length].copy_from_slice(data);
            whole(bytes, Request::DownloadSegment(Segment::new(false, data, false).unwrap()), 7 - length);
        }
        let upload = |crc, threshold| Request::InitiateBlockUpload { multiplexer, crc, block_size: 9, threshold };
        whole([0xA0, 0x50, 0x1F, 1, 9, 0, 0, 0], upload(false, 0), 3);
        whole([0xA4, 0x50, 0x1F, 1, 9, 7, 0, 0], upload(true, 7), 2);
        whole([0xA1, 0, 0, 0, 0, 0, 0, 0], Request::EndBlockUpload, 7);
        whole([0xA2, 5, 9, 0, 0, 0, 0, 0], Request::ConfirmBlockUpload { sequence: 5, block_size: 9 }, 5);
        whole([0xA3, 0, 0, 0, 0, 0, 0, 0], Request::StartBlockUpload, 7);
        let download = |crc, size| Request::InitiateBlockDownload { multiplexer, crc, size };
        whole([0xC0, 0x50, 0x1F, 1, 0, 0, 0, 0], download(false, None), 4);
        whole([0xC4, 0x50, 0x1F, 1, 0, 0, 0, 0], download(true, None), 4);
        whole([0xC2, 0x50, 0x1F, 1, 9, 0, 0, 0], download(false, Some(9)), 0);
        for unused in 0..=7 {
            let end = Request::EndBlockDownload { unused, crc: 0x31C3 };
            whole([0xC1 | unused << 2, 0xC3, 0x31, 0, 0, 0, 0, 0], end, 5);
        }
        whole([0xE0, 1, 2, 3, 4, 5, 6, 7], Request::Unknown { command: 0xE0, tail: [1, 2, 3, 4, 5, 6, 7] }, 0);
    }

    /// Whether the field has no meaning in this request: bytes that hold no data, and a size that is not indicated.
    fn carries_nothing(request: &Request, field: crate::wire::Field) -> bool {
        match request {
            Request::DownloadSegment(segment) => field.name == "data" && segment.data().len() < 7,
            Request::InitiateDownload { payload: Payload::Expedited(value), .. } => {
                field.name == "data" && value.data().len() < 4
            }
            Request::InitiateDownload { payload: Payload::SegmentedUnsized, .. } => {
                matches!(field.name, "data" | "unused bytes")
            }
            Request::InitiateDownload { .. } => field.name == "unused bytes",
            Request::InitiateBlockDownload { size: None, .. } => field.name == "size",
            _ => false,
        }
    }

    proptest! {
        #[test]
        fn every_field_is_heeded(bytes: [u8; 8]) {
            heeded::<Request>(&bytes, carries_nothing);
        }

        #[test]
        fn any_bytes(bytes in proptest::collection::vec(any::<u8>(), 0..=8)) {
            stable::<Request>(&bytes);
        }
    }
}
