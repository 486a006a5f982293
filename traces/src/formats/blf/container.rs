//! Log containers: each holds a part of the stream of objects, deflated or plain.
//!
//! ```text
//! compression (16 bits: 0 none, 2 zlib), reserved (48), uncompressed size (32), reserved (32), bytes
//! ```

use super::reader::FILLING;
use crate::Source;
use crate::limited::{Limited, Unpacked};
use flate2::bufread::ZlibDecoder;
use nom::bytes::complete::take;
use nom::number::complete::{le_u16, le_u32};
use nom::{IResult, Parser};
use std::io::{self, Read};

pub(crate) const HEADER: usize = 16;
/// Limit of the uncompressed size in memory; Vector's tools write 128 KiB, some loggers some MiB.
const LARGEST: u32 = 32 * 1024 * 1024;

/// Parses compression and uncompressed size.
fn header(i: &[u8]) -> IResult<&[u8], (u16, u32)> {
    (le_u16, take(6usize), le_u32, le_u32).map(|(compression, _, size, _)| (compression, size)).parse(i)
}

/// Appends a container's content to `objects`, and consumes its `length` bytes, header included. If the container is
/// damaged or states too many bytes, only the bytes that it really has are consumed.
pub(crate) fn unpack(source: &mut Source, length: u64, objects: &mut Vec<u8>) -> Unpacked {
    let start = objects.len();
    let mut limited = Limited::new(source, length);
    let mut head = [0; HEADER];
    let read = limited.read_exact(&mut head).and_then(|()| {
        let (compression, size) = header(&head).map_or((u16::MAX, 0), |(_, header)| header);
        // Trying to read one byte more than stated reveals additional bytes.
        let most = u64::from(size.min(LARGEST)) + 1;
        match compression {
            _ if size > LARGEST => Err(io::Error::other(format!("{size} bytes, uncompressed"))),
            0 => (&mut limited).take(most).read_to_end(objects),
            2 => ZlibDecoder::new(&mut limited).take(most).read_to_end(objects),
            other => Err(io::Error::other(format!("compression {other}"))),
        }
        .map(|_| u64::from(size))
    });
    let (cut, unread) = (limited.is_cut(), limited.left());
    let unpacked = (objects.len() - start) as u64;
    match read {
        _ if cut => Unpacked::Cut,
        Ok(size) if unpacked == size && unread < FILLING as u64 => {
            if source.skip(unread).is_ok_and(|skipped| skipped == unread) { Unpacked::Whole } else { Unpacked::Cut }
        }
        Ok(size) if unpacked == size => Unpacked::Overlong(unread),
        Ok(size) => {
            let found = if unpacked > size { "more".to_owned() } else { format!("{unpacked}") };
            Unpacked::Damaged { expected: format!("a container of {size} bytes, uncompressed"), found }
        }
        Err(error) => {
            let expected = format!("a container deflated by zlib or plain, of at most {LARGEST} bytes");
            Unpacked::Damaged { expected, found: error.to_string() }
        }
    }
}
