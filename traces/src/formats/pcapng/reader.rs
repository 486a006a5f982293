//! Reads pcapng.

use super::block::{self, FRAMING, Head, LONGEST};
use super::packets::{Content, Section};
use super::usual;
use crate::{Channels, Damage, DamageKind, Place, ReadOptions, Reader, Record, Source, SourceError, TimeBase};
use pcap_file::Endianness;
use pcap_file::pcapng::blocks::SECTION_HEADER_BLOCK;
use pcap_file::pcapng::blocks::section_header::SectionHeaderBlock;
use pcap_file::pcapng::{PcapNgFormatError, PcapNgState, RawBlock, RawBlockParseError};
use std::borrow::Cow;

pub(crate) fn sniff(head: &[u8]) -> bool {
    head.first_chunk().is_some_and(|head| block::head(None, head).is_some())
}

pub(crate) fn open(source: Source, _options: &ReadOptions) -> Box<dyn Reader> {
    Box::new(PcapngReader::new(source))
}

struct PcapngReader {
    source: Source,
    /// The byte order of the current section; `None` before the first section, and after a damaged section header.
    order: Option<Endianness>,
    section: Section,
    /// The end of the current section, if its header gives its length.
    section_end: Option<u64>,
    channels: Channels,
    /// Number of the last block.
    number: u64,
    /// The record that follows a damage of the same block.
    pending: Option<Record>,
    done: bool,
}

/// The result of a block.
enum Yield {
    Content(Content),
    End,
}

impl From<Damage> for Yield {
    fn from(damage: Damage) -> Self {
        Self::Content(damage.into())
    }
}

impl PcapngReader {
    fn new(source: Source) -> Self {
        Self {
            source,
            order: None,
            section: Section::default(),
            section_end: None,
            channels: Channels::new(),
            number: 0,
            pending: None,
            done: false,
        }
    }

    fn place(&self) -> Place {
        Place { number: self.number, offset: self.source.offset() }
    }

    fn damage(&self, kind: DamageKind, expected: impl Into<Cow<'static, str>>, found: &str) -> Damage {
        Damage::new(kind, self.place(), expected, found.as_bytes())
    }

    fn failed(&mut self, error: &SourceError) -> Damage {
        self.done = true;
        Damage::source(error, self.place())
    }

    /// A quick reader for the next block, if it has the usual form.
    #[inline]
    fn usual_block(&mut self) -> Option<Record> {
        if self.order != Some(Endianness::Little) {
            return None;
        }
        let place = Place { number: self.number + 1, offset: self.source.offset() };
        let (record, size) = usual::packet(&self.section.interfaces, self.source.window(), place)?;
        self.number = place.number;
        self.section.latest = Some(record.timestamp);
        self.source.consume(size);
        Some(record)
    }

    fn block(&mut self) -> Yield {
        self.number += 1;
        match self.source.fill_to(FRAMING) {
            Ok(_) => {}
            Err(error) => return self.failed(&error).into(),
        }
        let Some(head) = self.source.window().first_chunk() else { return self.end() };
        let Some((order, head)) = block::head(self.order, head) else { return self.no_section().into() };
        let length = head.length as usize;
        if length > LONGEST {
            return self.too_long(head);
        }
        match self.source.fill_to(length) {
            Ok(true) => {}
            Ok(false) => return self.cut(length).into(),
            Err(error) => return self.failed(&error).into(),
        }
        let place = self.place();
        match block::raw(order, self.source.window()) {
            Ok((_, block)) if block.type_ == SECTION_HEADER_BLOCK => {
                let header = header(order, &block);
                self.begin(order, header, length, place)
            }
            Ok((_, block)) => {
                let content = self.section.content(order, block.type_, &block.body, place, &mut self.channels);
                self.source.consume(length);
                Yield::Content(content)
            }
            Err(error) => {
                let (expected, found) = explained(&error);
                let damage = self.damage(DamageKind::Malformed, expected, &found);
                if head.kind == SECTION_HEADER_BLOCK {
                    // The magic number is right, so a section begins, even if its header is damaged.
                    self.order = Some(order);
                    self.section.begin(order);
                }
                self.search(damage).into()
            }
        }
    }

    /// Handles the end, at which no complete block is left.
    fn end(&mut self) -> Yield {
        if !self.source.window().is_empty() {
            return self.cut(0).into();
        }
        match self.missing_end_of_section() {
            Some(damage) => {
                self.done = true;
                damage.into()
            }
            None => Yield::End,
        }
    }

    /// The damage if the section ends before the length in its header.
    fn missing_end_of_section(&mut self) -> Option<Damage> {
        let end = self.section_end.take().filter(|end| *end > self.source.offset())?;
        let expected = format!("a section up to offset {end}, as its header says");
        Some(self.damage(DamageKind::Unfinished, expected, "its end"))
    }

    /// The damage for a section header that is missing or has no magic number.
    fn no_section(&mut self) -> Damage {
        let Some(&head) = self.source.window().first_chunk() else {
            return self.damage(DamageKind::Fatal, "a section header block at the beginning", "");
        };
        if !block::is_section(&head) {
            return self.damage(DamageKind::Fatal, "a section header block at the beginning", "");
        }
        let damage = self.damage(DamageKind::Malformed, "the byte order magic 1A2B3C4Dh in a section header", "");
        // The two lengths of a block are equal in only one byte order.
        for order in [Endianness::Little, Endianness::Big] {
            let length = block::length(order, &head) as usize;
            if !(FRAMING..=LONGEST).contains(&length) {
                continue;
            }
            match self.source.fill_to(length) {
                Ok(true) => {}
                Ok(false) => continue,
                Err(error) => return self.failed(&error),
            }
            let window = self.source.window();
            if window.get(length - 4..length) == window.get(4..8) {
                self.section_end = None;
                self.order = Some(order);
                self.section.begin(order);
                self.source.consume(length);
                return damage;
            }
        }
        // Until the next section, byte order and interfaces are unknown.
        self.order = None;
        self.search(damage)
    }

    /// Begins a section: byte order and interfaces are reset.
    fn begin(&mut self, order: Endianness, header: Option<(u16, i64, bool)>, length: usize, place: Place) -> Yield {
        let Some((major, section_length, whole)) = header else {
            return self.damage(DamageKind::Fatal, "a section header of at least 16 bytes", "").into();
        };
        if major != 1 {
            return self.damage(DamageKind::Fatal, "pcapng version 1", &major.to_string()).into();
        }
        let missing = self.missing_end_of_section();
        self.source.consume(length);
        // A length of -1 means unknown.
        self.section_end = u64::try_from(section_length).ok().and_then(|n| self.source.offset().checked_add(n));
        self.order = Some(order);
        self.section.begin(order);
        let options = || Damage::new(DamageKind::Malformed, place, "options that fit into the section header", b"");
        Yield::Content(Content { damage: missing.or_else(|| (!whole).then(options)), record: None })
    }

    /// Handles a block that is too long for a frame: a known type without frames is skipped.
    fn too_long(&mut self, head: Head) -> Yield {
        // Blocks begin at multiples of four, even if a writer's length is not one.
        let size = u64::from(head.length).next_multiple_of(4);
        let place = self.place();
        if head.is_aside() {
            match self.source.skip(size) {
                Ok(skipped) if skipped == size => return Yield::Content(Content::default()),
                Ok(_) => {}
                Err(error) => return self.failed(&error).into(),
            }
        } else {
            let expected = format!("a block of at most {LONGEST} bytes");
            let damage = self.search(self.damage(DamageKind::Malformed, expected, &size.to_string()));
            // Handles the end of the file, or of its readable part.
            if !damage.kind.is_fatal() || damage.place != place {
                return damage.into();
            }
        }
        self.done = true;
        let found = format!("the end of the file after {}", self.source.offset() - place.offset);
        Damage::new(DamageKind::Truncated, place, format!("a block of {size} bytes"), found.as_bytes()).into()
    }

    /// Reports a block that the file's end cuts, or a damaged length if another block follows.
    fn cut(&mut self, length: usize) -> Damage {
        let found = format!("the end of the file after {}", self.source.window().len());
        let expected = match length {
            0 => "a block of at least 12 bytes".into(),
            _ => format!("a block of {length} bytes"),
        };
        let damage = self.search(self.damage(DamageKind::Malformed, expected, &found));
        match damage.kind {
            DamageKind::Fatal => Damage { kind: DamageKind::Truncated, ..damage },
            _ => damage,
        }
    }

    /// Skips an invalid block, up to the next valid one. If there is none, the damage is fatal.
    fn search(&mut self, damage: Damage) -> Damage {
        match self.next_likely() {
            Ok(true) => damage,
            Ok(false) => {
                self.done = true;
                Damage { kind: DamageKind::Fatal, ..damage }
            }
            Err(error) => self.failed(&error),
        }
    }

    /// Moves to the next bytes that have the two equal lengths of a block of known type; returns whether it found any.
    fn next_likely(&mut self) -> Result<bool, SourceError> {
        self.source.consume(1);
        while self.source.fill_to(FRAMING)? {
            let window = self.source.window();
            let candidate = window.windows(FRAMING).position(|bytes| {
                let head = bytes.first_chunk().and_then(|bytes| block::head(self.order, bytes));
                head.is_some_and(|(_, head)| head.is_likely())
            });
            let Some(at) = candidate else {
                self.source.consume(window.len() - FRAMING + 1);
                continue;
            };
            self.source.consume(at);
            let head = self.source.window().first_chunk().and_then(|bytes| block::head(self.order, bytes));
            if let Some((order, head)) = head
                && self.source.fill_to(head.length as usize)?
                && block::raw(order, self.source.window()).is_ok()
            {
                return Ok(true);
            }
            self.source.consume(1);
        }
        self.source.consume(FRAMING);
        Ok(false)
    }
}

/// Parses a section header: major version, length of the section, and whether all options are readable.
fn header(order: Endianness, block: &RawBlock<'_>) -> Option<(u16, i64, bool)> {
    let state = PcapNgState::default();
    let (header, whole) = block::content::<SectionHeaderBlock<'_>>(order, &state, &block.body, 16).ok()?;
    Some((header.major_version, header.section_length, whole))
}

/// The expected text and the found text for an invalid block.
fn explained(error: &RawBlockParseError) -> (String, String) {
    use PcapNgFormatError::{BlockLengthMismatch, BlockNotAligned, BlockTooShort};
    match error {
        RawBlockParseError::InvalidFormat(BlockTooShort(_, length) | BlockNotAligned(length)) if *length < FRAMING => {
            (format!("a block of at least {FRAMING} bytes"), format!("length {length}"))
        }
        RawBlockParseError::InvalidFormat(BlockNotAligned(length)) => {
            ("a block's length, a multiple of four".into(), format!("length {length}"))
        }
        RawBlockParseError::InvalidFormat(BlockLengthMismatch(length, again)) => {
            (format!("the block's length {length} again at its end"), again.to_string())
        }
        other => ("a block".into(), other.to_string()),
    }
}

impl Iterator for PcapngReader {
    type Item = Result<Record, Damage>;

    fn next(&mut self) -> Option<Self::Item> {
        if self.pending.is_some() {
            return self.pending.take().map(Ok);
        }
        while !self.done {
            if let Some(record) = self.usual_block() {
                return Some(Ok(record));
            }
            match self.block() {
                Yield::End => self.done = true,
                Yield::Content(Content { damage: Some(damage), record }) => {
                    self.done |= damage.kind.is_fatal();
                    self.pending = record;
                    return Some(Err(damage));
                }
                Yield::Content(Content { damage: None, record: Some(record) }) => return Some(Ok(record)),
                Yield::Content(Content { damage: None, record: None }) => {}
            }
        }
        None
    }
}

impl Reader for PcapngReader {
    fn channels(&self) -> &Channels {
        &self.channels
    }

    fn time_base(&self) -> TimeBase {
        if self.section.untimed && self.section.latest.is_none() { TimeBase::None } else { TimeBase::Utc }
    }
}

#[cfg(test)]
mod tests;
