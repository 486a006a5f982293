//! Concise DCF (CiA 302-3, object 1F22h): the number of values, then index, sub-index, length and bytes of each,
//! little-endian.

use super::Download;
use crate::identity::Multiplexer;
use nom::bytes::complete::take;
use nom::number::complete::{le_u8, le_u16, le_u32};
use nom::{IResult, Parser};

/// Why bytes are no concise DCF.
#[derive(Clone, Copy, PartialEq, Eq, Debug, thiserror::Error)]
pub enum BadConcise {
    /// The bytes end within the head or a value.
    #[error("byte {at}: the concise DCF announces {announced} values, and ends within number {number}")]
    Short {
        /// The offset at which the value begins.
        at: usize,
        /// The announced number of values.
        announced: u32,
        /// The number of the incomplete value, from 1; 0 for the head.
        number: u32,
    },
    /// Bytes follow the last value.
    #[error("byte {at}: the concise DCF ends after {announced} values, but {rest} bytes follow")]
    Long {
        /// The offset of the first byte that follows.
        at: usize,
        /// The announced number of values.
        announced: u32,
        /// The number of bytes that follow.
        rest: usize,
    },
}

/// Reads a concise DCF.
///
/// # Errors
/// [`BadConcise`] if the announced number of values does not fill the bytes.
pub fn read_concise(bytes: &[u8]) -> Result<Vec<Download>, BadConcise> {
    let failed = |_| BadConcise::Short { at: 0, announced: 0, number: 0 };
    let (mut rest, announced) = le_u32::<_, nom::error::Error<&[u8]>>(bytes).map_err(failed)?;
    let mut downloads = Vec::new();
    for number in 1..=announced {
        let at = bytes.len() - rest.len();
        let (behind, download) = download(rest).map_err(|_| BadConcise::Short { at, announced, number })?;
        downloads.push(download);
        rest = behind;
    }
    match rest.len() {
        0 => Ok(downloads),
        more => Err(BadConcise::Long { at: bytes.len() - more, announced, rest: more }),
    }
}

fn download(bytes: &[u8]) -> IResult<&[u8], Download> {
    let (bytes, (index, sub, length)) = (le_u16, le_u8, le_u32).parse(bytes)?;
    let (bytes, value) = take(length)(bytes)?;
    Ok((bytes, Download { at: Multiplexer::new(index, sub), value: value.to_vec() }))
}

/// Writes a concise DCF.
pub fn write_concise(downloads: &[Download]) -> Vec<u8> {
    let mut bytes = (downloads.len() as u32).to_le_bytes().to_vec();
    for Download { at, value } in downloads {
        bytes.extend(at.index.0.to_le_bytes());
        bytes.push(at.sub.0);
        bytes.extend((value.len() as u32).to_le_bytes());
        bytes.extend(value);
    }
    bytes
}
