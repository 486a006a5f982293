//! Blocks, of which a file consists: an id, links to other blocks, and data.

use crate::damage::Flaw;
use nom::bytes::complete::{tag, take};
use nom::number::complete::le_u64;
use nom::{IResult, Parser};
use std::collections::BTreeSet;

/// Length of id, reserved bytes, length, and number of links.
const HEADER: u64 = 24;
const LINK: usize = 8;

/// Two letters that tell what a block is.
pub(super) type Id = [u8; 2];

/// A block of a file.
#[derive(Clone, Copy, Debug)]
pub(super) struct Block<'a> {
    pub id: Id,
    /// The offset in the file.
    pub offset: u64,
    links: &'a [u8],
    /// The bytes after the links.
    pub data: &'a [u8],
    /// Whether the file ends before the block.
    pub is_cut: bool,
}

/// Parses id, length, and number of links.
fn header(i: &[u8]) -> IResult<&[u8], (Id, u64, u64)> {
    (tag("##"), take(2usize), take(4usize), le_u64, le_u64)
        .map(|(_, id, _, length, links): (_, &[u8], _, _, _)| ([id[0], id[1]], length, links))
        .parse(i)
}

impl<'a> Block<'a> {
    /// The block at an offset of the file.
    pub fn read(file: &'a [u8], offset: u64) -> Result<Self, Flaw> {
        let bytes = usize::try_from(offset).ok().and_then(|at| file.get(at..)).unwrap_or_default();
        let Ok((after, (id, length, links))) = header(bytes) else {
            return Err(Flaw::malformed(
                format!("a block at byte {offset}"),
                String::from_utf8_lossy(&bytes[..bytes.len().min(4)]),
            ));
        };
        let links_end = usize::try_from(links).ok().and_then(|links| links.checked_mul(LINK));
        let Some((links, rest)) = links_end.and_then(|end| after.split_at_checked(end)) else {
            return Err(Flaw::malformed("the links of a block within the file", format!("{links} links")));
        };
        // A recorder writes the length of its last block of records when it finishes the file.
        let is_open = length <= HEADER + links.len() as u64 && matches!(&id, b"DT" | b"SD" | b"DV");
        let stated = usize::try_from(length.saturating_sub(HEADER)).unwrap_or(usize::MAX).saturating_sub(links.len());
        let is_empty = is_open && length == HEADER + links.len() as u64 && rest.starts_with(b"##");
        let taken = if is_open && !is_empty { rest.len() } else { stated.min(rest.len()) };
        let data = rest.get(..taken).unwrap_or_default();
        Ok(Self { id, offset, links, data, is_cut: stated > rest.len() })
    }

    /// The block at an offset, which must have this id.
    pub fn expect(file: &'a [u8], offset: u64, id: &Id) -> Result<Self, Flaw> {
        let block = Self::read(file, offset)?;
        match block.id == *id && !block.is_cut {
            true => Ok(block),
            false => Err(Flaw::malformed(format!("a whole block {} at byte {offset}", name(id)), name(&block.id))),
        }
    }

    /// The offset to which a link leads; `None` for an absent or empty link.
    pub fn link(&self, number: usize) -> Option<u64> {
        self.links().nth(number).filter(|offset| *offset != 0)
    }

    /// All links; 0 is an empty one.
    pub fn links(&self) -> impl Iterator<Item = u64> + use<'a> {
        let number = |link: &[u8]| link.iter().rev().fold(0, |all, byte| all << 8 | u64::from(*byte));
        self.links.chunks_exact(LINK).map(number)
    }
}

/// The id as text, such as `DT`.
pub(super) fn name(id: &Id) -> String {
    String::from_utf8_lossy(id).into_owned()
}

/// Follows a chain of blocks: the first link of each block leads to the next block. A link to a block of the same chain that
/// came before is an error, as the chain would not end.
pub(super) fn chain<'a>(
    file: &'a [u8],
    first: Option<u64>,
    id: &'static Id,
) -> impl Iterator<Item = Result<Block<'a>, Flaw>> {
    let mut seen = BTreeSet::new();
    let mut next = first;
    std::iter::from_fn(move || {
        let offset = next.take()?;
        if !seen.insert(offset) {
            let expected = format!("a chain of blocks {} that ends", name(id));
            return Some(Err(Flaw::malformed(expected, "one that comes back")));
        }
        let block = Block::expect(file, offset, id);
        next = block.as_ref().ok().and_then(|block| block.link(0));
        Some(block)
    })
}

/// The result of a look at all blocks of a file in their order, without their links.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub(super) struct Survey {
    /// Whether the file ends within a block, or before a block to which a link leads.
    pub is_cut: bool,
    /// Number of data groups.
    pub data_groups: usize,
    /// Number of channel groups.
    pub groups: usize,
}

/// Looks at block after block from `first` on, up to the end of the file, or to bytes that are no block.
pub(super) fn survey(file: &[u8], first: u64) -> Survey {
    let end = file.len() as u64;
    let (mut survey, mut at) = (Survey::default(), first);
    while at < end {
        let Ok(block) = Block::read(file, at) else {
            let rest = usize::try_from(at).ok().and_then(|at| file.get(at..)).unwrap_or_default();
            survey.is_cut |=
                rest.starts_with(b"##") || rest.len() < HEADER as usize && rest.iter().any(|byte| *byte != 0);
            return survey;
        };
        survey.is_cut |= block.is_cut || block.links().any(|link| link >= end);
        survey.data_groups += usize::from(block.id == *b"DG");
        survey.groups += usize::from(block.id == *b"CG");
        let length = HEADER + (block.links.len() + block.data.len()) as u64;
        // Blocks begin at multiples of eight bytes.
        at += length.next_multiple_of(8);
    }
    survey
}

#[cfg(test)]
mod tests {
    use super::*;

    fn block(id: &[u8; 2], links: &[u64], data: &[u8]) -> Vec<u8> {
        let length = HEADER + 8 * links.len() as u64 + data.len() as u64;
        let mut bytes = [b"##", &id[..], &[0; 4]].concat();
        bytes.extend(length.to_le_bytes());
        bytes.extend((links.len() as u64).to_le_bytes());
        links.iter().for_each(|link| bytes.extend(link.to_le_bytes()));
        bytes.extend(data);
        bytes
    }

    #[test]
    fn a_block_has_links_and_data() {
        let file = [block(b"DG", &[0, 77], b"data"), b"more".to_vec()].concat();
        let read = Block::read(&file, 0).unwrap();
        assert_eq!(
            (read.id, read.link(0), read.link(1), read.link(2), read.data),
            (*b"DG", None, Some(77), None, &b"data"[..])
        );
        assert!(Block::expect(&file, 0, b"CG").is_err() && Block::read(&file, 5).is_err());
    }

    #[test]
    fn what_the_recorder_did_not_finish_goes_to_the_end_of_the_file() {
        let mut file = [block(b"DT", &[], b""), b"records".to_vec()].concat();
        assert_eq!(Block::read(&file, 0).unwrap().data, b"records");
        file[8..16].copy_from_slice(&100u64.to_le_bytes());
        let cut = Block::read(&file, 0).unwrap();
        assert!(cut.is_cut && cut.data == b"records");
        let followed = [block(b"DT", &[], b""), block(b"DG", &[], b"")].concat();
        assert_eq!(Block::read(&followed, 0).unwrap().data, b"", "no records");
    }

    #[test]
    fn hostile_links() {
        let mut many = block(b"DL", &[], b"");
        many[16..24].copy_from_slice(&u64::MAX.to_le_bytes());
        assert!(Block::read(&many, 0).is_err() && Block::read(&many, u64::MAX).is_err());
        let round = block(b"DG", &[0], b"");
        let mut round_again = vec![0; 8];
        round_again.extend(round);
        round_again[32..40].copy_from_slice(&8u64.to_le_bytes());
        let blocks: Vec<_> = chain(&round_again, Some(8), b"DG").collect();
        assert!(blocks.len() < 4 && blocks.last().unwrap().is_err(), "{blocks:?}");
    }

    #[test]
    fn a_survey_tells_where_the_file_is_cut() {
        let file = [block(b"CG", &[], b"12345678"), block(b"DG", &[0, 0], b""), block(b"DT", &[], b"records")].concat();
        let whole = Survey { is_cut: false, data_groups: 1, groups: 1 };
        assert_eq!(survey(&file, 0), whole);
        assert_eq!(survey(&[file.clone(), vec![0; 9]].concat(), 0), whole, "filling at the end");
        for end in 1..file.len() {
            let is_between = [32, 72].contains(&end);
            assert_eq!(survey(&file[..end], 0).is_cut, !is_between, "cut at {end}");
        }
        let linked = block(b"DG", &[0, 500], b"");
        assert!(survey(&linked, 0).is_cut, "to a block that is missing");
    }
}
