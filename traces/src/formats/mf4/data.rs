//! The records of a data group, and values of variable length: in one block, in deflated blocks, or in lists of both.

use super::block::{Block, chain, name};
use crate::damage::Flaw;
use flate2::bufread::ZlibDecoder;
use nom::bytes::complete::take;
use nom::number::complete::{le_u32, le_u64, u8};
use nom::{IResult, Parser};
use std::borrow::Cow;
use std::io::Read;

/// Limit of the unpacked size of all blocks of a list, in bytes: 1 GiB.
const LARGEST: u64 = 1 << 30;

/// The bytes of a block or of a list of blocks, up to the first damaged block.
#[derive(Debug, Default)]
pub(super) struct Content<'a> {
    pub bytes: Cow<'a, [u8]>,
    /// The flaw of the first damaged block, and its offset.
    pub flaw: Option<(Flaw, u64)>,
    /// Whether the file ends within a block.
    pub is_cut: bool,
}

/// Reads the block, or the list of blocks, to which a link leads.
pub(super) fn content(file: &[u8], link: Option<u64>) -> Content<'_> {
    let mut content = Content::default();
    if let Some(offset) = link
        && let Err(flaw) = append(file, offset, &mut content)
    {
        content.flaw.get_or_insert((flaw, offset));
    }
    content
}

fn append<'a>(file: &'a [u8], offset: u64, content: &mut Content<'a>) -> Result<(), Flaw> {
    let block = Block::read(file, offset)?;
    match &block.id {
        b"HL" => list(file, block.link(0), content),
        b"DL" => list(file, Some(offset), content),
        _ => part(&block, content),
    }
}

/// Appends the blocks of a list.
fn list<'a>(file: &'a [u8], first: Option<u64>, content: &mut Content<'a>) -> Result<(), Flaw> {
    for block in chain(file, first, b"DL") {
        let block = block?;
        for offset in block.links().skip(1).filter(|offset| *offset != 0) {
            let whole = Block::read(file, offset).and_then(|block| part(&block, content));
            if let Err(flaw) = whole {
                // What follows may belong to other records.
                content.flaw = Some((flaw, offset));
                return Ok(());
            }
        }
    }
    Ok(())
}

/// Appends a plain or a deflated block.
fn part<'a>(block: &Block<'a>, content: &mut Content<'a>) -> Result<(), Flaw> {
    content.is_cut |= block.is_cut;
    let bytes = match &block.id {
        b"DT" | b"SD" | b"DV" => Cow::Borrowed(block.data),
        b"DZ" => Cow::Owned(unpack(block.data)?),
        other => return Err(Flaw::unsupported("a block DT, DZ, DL or HL with records", name(other))),
    };
    if content.bytes.len() as u64 + bytes.len() as u64 > LARGEST {
        return Err(Flaw::unsupported(format!("at most {LARGEST} bytes of records"), "more"));
    }
    if content.bytes.is_empty() {
        content.bytes = bytes;
    } else {
        content.bytes.to_mut().extend_from_slice(&bytes);
    }
    Ok(())
}

/// The header of a deflated block.
struct Packed {
    is_transposed: bool,
    /// Length of a record, if transposed.
    columns: u32,
    /// Length of the plain bytes.
    length: u64,
}

/// Parses type of the plain block, kind of compression, its parameter, lengths of the plain and of the deflated bytes.
fn packed(i: &[u8]) -> IResult<&[u8], Result<Packed, u8>> {
    let (i, (_, kind, _, columns, length, _)) = (take(2usize), u8, u8, le_u32, le_u64, le_u64).parse(i)?;
    Ok((i, if kind <= 1 { Ok(Packed { is_transposed: kind == 1, columns, length }) } else { Err(kind) }))
}

fn unpack(data: &[u8]) -> Result<Vec<u8>, Flaw> {
    let Ok((deflated, header)) = packed(data) else {
        return Err(Flaw::malformed("the header of a deflated block", format!("{} bytes", data.len())));
    };
    let header = header.map_err(|kind| Flaw::unsupported("deflated records, plain or transposed", kind.to_string()))?;
    if header.length > LARGEST {
        return Err(Flaw::unsupported(format!("at most {LARGEST} bytes of records"), header.length.to_string()));
    }
    let mut plain = Vec::new();
    let read = ZlibDecoder::new(deflated).take(header.length + 1).read_to_end(&mut plain);
    let found = match read {
        Err(error) => error.to_string(),
        Ok(_) if plain.len() as u64 != header.length => format!("{} bytes", plain.len()),
        Ok(_) if header.is_transposed => return Ok(transposed(&plain, header.columns as usize)),
        Ok(_) => return Ok(plain),
    };
    Err(Flaw::malformed(format!("{} bytes deflated by zlib", header.length), found))
}

/// The records of bytes that were sorted by their place in the record. Bytes after the last whole record stay.
fn transposed(bytes: &[u8], columns: usize) -> Vec<u8> {
    let rows = bytes.len().checked_div(columns).unwrap_or_default();
    let (sorted, rest) = bytes.split_at(rows * columns);
    let mut records = Vec::with_capacity(bytes.len());
    for row in 0..rows {
        records.extend(sorted.iter().skip(row).step_by(rows));
    }
    records.extend(rest);
    records
}

#[cfg(test)]
mod tests {
    use super::*;
    use flate2::Compression;
    use flate2::write::ZlibEncoder;
    use std::io::Write;

    fn deflated(kind: u8, columns: u32, length: u64, plain: &[u8]) -> Vec<u8> {
        let mut packer = ZlibEncoder::new(Vec::new(), Compression::fast());
        packer.write_all(plain).unwrap();
        let bytes = packer.finish().unwrap();
        let mut block = [b'D', b'T', kind, 0].to_vec();
        block.extend(columns.to_le_bytes());
        block.extend(length.to_le_bytes());
        block.extend((bytes.len() as u64).to_le_bytes());
        block.extend(bytes);
        block
    }

    #[test]
    fn deflated_records() {
        assert_eq!(unpack(&deflated(0, 0, 5, b"abcde")).unwrap(), b"abcde");
        assert_eq!(
            unpack(&deflated(1, 3, 8, b"adbecfgh")).unwrap(),
            b"abcdefgh",
            "two records of three bytes, and two bytes"
        );
        assert_eq!(unpack(&deflated(1, 0, 2, b"ab")).unwrap(), b"ab");
        assert!(unpack(&deflated(0, 0, 4, b"abcde")).is_err(), "more than stated");
        assert!(unpack(&deflated(2, 0, 5, b"abcde")).is_err() && unpack(b"DT").is_err());
        assert!(unpack(&deflated(0, 0, u64::MAX, b"abcde")).is_err());
    }
}
