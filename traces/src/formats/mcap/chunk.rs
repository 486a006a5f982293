//! Chunks: records compressed together, with a checksum.
//!
//! ```text
//! time of the first message, time of the last (64 bits each), uncompressed size (64), CRC-32 of the uncompressed
//! records (32, 0 for none), compression ("", "zstd" or "lz4", after its length of 32), compressed size (64), bytes
//! ```

use crate::Source;
use crate::limited::{Limited, Unpacked};
use crate::packed;
use nom::bytes::complete::take;
use nom::number::complete::{le_u32, le_u64};
use nom::{IResult, Parser};
use std::io::{self, Read};

/// Limit of the uncompressed size in memory; recorders write 1 to 8 MiB. A decompressor may need the same amount in
/// addition.
pub(crate) const LARGEST: u64 = 32 * 1024 * 1024;
/// The length of the longest header, including the name of the compression.
pub(crate) const HEADER: usize = 40 + LONGEST_NAME;
const LONGEST_NAME: usize = 32;

/// A chunk's header.
#[derive(Clone, PartialEq, Eq, Debug)]
pub(crate) struct Header {
    pub(crate) uncompressed: u64,
    pub(crate) crc: u32,
    pub(crate) compression: Compression,
    pub(crate) compressed: u64,
    /// The length of the header itself.
    pub(crate) length: usize,
}

#[derive(Clone, PartialEq, Eq, Debug)]
pub(crate) enum Compression {
    None,
    Zstd,
    Lz4,
    Other(String),
}

/// The header at the beginning of a chunk's record.
pub(crate) fn header(i: &[u8]) -> IResult<&[u8], Header> {
    let whole = i.len();
    let (i, (_, _, uncompressed, crc, name)) = (le_u64, le_u64, le_u64, le_u32, le_u32).parse(i)?;
    let name_length = usize::try_from(name).unwrap_or(usize::MAX);
    let (i, name) = take(name_length).parse(i)?;
    let (i, compressed) = le_u64(i)?;
    let compression = match name {
        b"" => Compression::None,
        b"zstd" => Compression::Zstd,
        b"lz4" => Compression::Lz4,
        other => Compression::Other(String::from_utf8_lossy(other).into_owned()),
    };
    Ok((i, Header { uncompressed, crc, compression, compressed, length: whole - i.len() }))
}

/// Unpacks a chunk's records from the source into `records`, and consumes all `left` bytes of the chunk. The checksum
/// of a cut chunk is not checked.
pub(crate) fn unpack(source: &mut Source, header: &Header, left: u64, records: &mut Vec<u8>) -> Unpacked {
    records.clear();
    let mut limited = Limited::new(source, header.compressed.min(left));
    let outer = left.saturating_sub(limited.left());
    // Trying to read one byte more than stated reveals additional bytes.
    let most = header.uncompressed.saturating_add(1);
    let read = match &header.compression {
        Compression::None => (&mut limited).take(most).read_to_end(records),
        Compression::Zstd => packed::zstd(&mut limited).and_then(|d| d.take(most).read_to_end(records)),
        Compression::Lz4 => packed::lz4(&mut limited).and_then(|d| d.take(most).read_to_end(records)),
        Compression::Other(name) => Err(io::Error::other(format!("compression {name}"))),
    };
    let (cut, unread) = (limited.is_cut(), limited.left());
    let skipped = source.skip(unread.saturating_add(outer)).unwrap_or_default();
    if cut || skipped < unread.saturating_add(outer) && read.is_ok() {
        records.truncate(header.uncompressed as usize);
        return Unpacked::Cut;
    }
    check(header, read.map(|_| ()), records)
}

fn check(header: &Header, read: io::Result<()>, records: &[u8]) -> Unpacked {
    if let Err(error) = read {
        return Unpacked::Damaged { expected: "a chunk in zstd, lz4 or plain".into(), found: error.to_string() };
    }
    if records.len() as u64 != header.uncompressed {
        let more = if records.len() as u64 > header.uncompressed { "more" } else { "less" };
        let expected = format!("a chunk of {} bytes, uncompressed", header.uncompressed);
        return Unpacked::Damaged { expected, found: more.into() };
    }
    let crc = if header.crc == 0 { 0 } else { crc32fast::hash(records) };
    if crc != header.crc {
        let expected = format!("a chunk with the checksum {:08X}h", header.crc);
        return Unpacked::Damaged { expected, found: format!("{crc:08X}h") };
    }
    Unpacked::Whole
}
