//! Reads MCAP.

use super::chunk;
use super::lengths::{attachment_fits, metadata_fits};
use super::topics::{Slot, Topics};
use super::writer::COMMENT;
use crate::damage::Flaw;
use crate::limited::Unpacked;
use crate::{Channels, Damage, DamageKind, Place, ReadOptions, Reader, Record, Source, TimeBase, Timestamp};
use mcap::records::{self, op};
use nom::number::complete::{le_u16, le_u32, le_u64, u8};
use nom::{IResult, Parser};
use std::collections::VecDeque;

/// Length of the header of each record: its operation code and length.
const RECORD_HEADER: usize = 9;
/// Length of the header of a message: channel, sequence number, log time and publish time.
const MESSAGE_HEADER: usize = 22;
/// Length of the footer.
const FOOTER: u64 = 20;
/// Maximum length of a parsed record other than a chunk. Longer records are skipped: no CAN frame is that long.
const LONGEST: u64 = 512 * 1024;

pub(crate) fn sniff(head: &[u8]) -> bool {
    head.starts_with(mcap::MAGIC)
}

pub(crate) fn open(source: Source, options: &ReadOptions) -> Box<dyn Reader> {
    Box::new(McapReader {
        source,
        topics: Topics::new(options.topics.clone()),
        chunk: Vec::new(),
        chunk_at: 0,
        chunk_place: 0,
        chunk_cut: false,
        messages: 0,
        statistics: None,
        previous: None,
        summary: false,
        pending: VecDeque::new(),
        comment: None,
        state: McapState::Magic,
    })
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum McapState {
    Magic,
    Records,
    Chunk,
    /// The end is reached; the last damages remain to be reported.
    Ended,
}

struct McapReader {
    source: Source,
    topics: Topics,
    /// The uncompressed records of the current chunk, and the offset of the next one.
    chunk: Vec<u8>,
    chunk_at: usize,
    /// The offset of the chunk in the source.
    chunk_place: u64,
    /// Whether the source ended inside the chunk.
    chunk_cut: bool,
    messages: u64,
    /// The number of messages according to the file's own statistics.
    statistics: Option<Box<records::Statistics>>,
    /// The code of the record before. Together with `summary`, whether the summary has begun, this code determines
    /// which records are allowed.
    previous: Option<u8>,
    summary: bool,
    pending: VecDeque<Damage>,
    /// The comment for the next frame.
    comment: Option<String>,
    state: McapState,
}

/// Parses a record's operation code and length.
fn record_header(i: &[u8]) -> IResult<&[u8], (u8, u64)> {
    (u8, le_u64).parse(i)
}

/// Parses a message's channel and log time.
#[inline]
fn message_header(i: &[u8]) -> IResult<&[u8], (u16, u64)> {
    (le_u16, le_u32, le_u64, le_u64).map(|(channel, _, logged, _)| (channel, logged)).parse(i)
}

impl McapReader {
    fn place(&self) -> Place {
        Place { number: self.messages, offset: self.source.offset() }
    }

    fn has(&mut self, n: usize) -> Result<bool, Damage> {
        self.source.fill_to(n).map_err(|error| {
            self.state = McapState::Ended;
            Damage::source(&error, self.place())
        })
    }

    fn magic(&mut self) -> Result<(), Damage> {
        if !self.has(mcap::MAGIC.len())? || !sniff(self.source.window()) {
            self.state = McapState::Ended;
            return Err(Damage::new(DamageKind::Fatal, self.place(), "the magic number of MCAP", b""));
        }
        self.source.consume(mcap::MAGIC.len());
        self.state = McapState::Records;
        Ok(())
    }

    /// Reads the next record of the file; gives a frame if the record is a message with one.
    fn record(&mut self) -> Result<Option<Record>, Damage> {
        if !self.has(RECORD_HEADER)? {
            let cut = !self.source.window().is_empty();
            return self.unfinished(cut.then(|| "a record header of 9 bytes".to_owned()));
        }
        let Ok((_, (code, length))) = record_header(self.source.window()) else { return Ok(None) };
        let previous = self.previous.replace(code);
        match code {
            op::CHUNK => return self.open_chunk(length),
            op::FOOTER if length == FOOTER => return self.footer(),
            // Code 0: space that a recorder reserved and did not write.
            0 => return self.unfinished(Some("a record of MCAP".to_owned())),
            op::MESSAGE | op::SCHEMA | op::CHANNEL if length <= LONGEST => {}
            _ => return self.aside(code, length, previous),
        }
        let end = RECORD_HEADER + length as usize;
        if !self.has(end)? {
            return self.unfinished(Some(format!("a record of {length} bytes")));
        }
        let place = Place { number: self.messages + 1, offset: self.source.offset() };
        let bytes = self.source.window().get(RECORD_HEADER..end).unwrap_or_default();
        let result = inner_record(&mut self.topics, code, bytes, place);
        self.messages += u64::from(code == op::MESSAGE);
        self.source.consume(end);
        result
    }

    /// Skips a record without frames, if a record with this content is allowed at this place. Any other record is
    /// reported: it may be a message with a damaged code.
    fn aside(&mut self, code: u8, length: u64, previous: Option<u8>) -> Result<Option<Record>, Damage> {
        let place = self.place();
        let head = RECORD_HEADER + usize::try_from(length.min(LONGEST)).unwrap_or_default();
        self.has(head)?;
        let window = self.source.window();
        let bytes = window.get(RECORD_HEADER..head.min(window.len())).unwrap_or_default();
        let fits = match code {
            op::HEADER => previous.is_none(),
            op::MESSAGE_INDEX => matches!(previous, Some(op::CHUNK | op::MESSAGE_INDEX)),
            op::ATTACHMENT => attachment_fits(bytes, length),
            op::METADATA => {
                let fits = metadata_fits(bytes);
                let comment = fits.then(|| comment(bytes)).flatten();
                self.comment = comment.or(self.comment.take());
                length > LONGEST || fits
            }
            op::DATA_END => length == 4,
            op::STATISTICS => {
                let parsed = mcap::parse_record(op::STATISTICS, bytes);
                let fits = self.summary && parsed.is_ok();
                if let Ok(records::Record::Statistics(statistics)) = parsed {
                    self.statistics = Some(Box::new(statistics));
                }
                fits
            }
            op::CHUNK_INDEX | op::ATTACHMENT_INDEX | op::METADATA_INDEX | op::SUMMARY_OFFSET => self.summary,
            // The record is too long to be parsed.
            op::MESSAGE | op::SCHEMA | op::CHANNEL => true,
            _ => false,
        };
        self.summary |= code == op::DATA_END && fits;
        self.pass_over(code, length)?;
        if fits {
            return Ok(None);
        }
        let found = format!("code {code:02X}h, {length} bytes");
        Err(Damage::new(DamageKind::Unsupported, place, "a record of MCAP in its place", found.as_bytes()))
    }

    /// Skips a record without frames, or a record that is too long to be parsed.
    fn pass_over(&mut self, code: u8, length: u64) -> Result<(), Damage> {
        let place = self.place();
        self.source.consume(RECORD_HEADER);
        let skipped = self.source.skip(length).map_err(|error| {
            self.state = McapState::Ended;
            Damage::source(&error, place)
        })?;
        if skipped < length {
            return self.unfinished(Some(format!("a record of {length} bytes"))).map(drop);
        }
        self.messages += u64::from(code == op::MESSAGE);
        if matches!(code, op::SCHEMA | op::CHANNEL) {
            let expected = format!("a schema or channel of at most {LONGEST} bytes");
            return Err(Damage::new(DamageKind::Unsupported, place, expected, length.to_string().as_bytes()));
        }
        Ok(())
    }

    /// Reports a source that ends without a footer, perhaps inside a record.
    fn unfinished(&mut self, cut_record: Option<String>) -> Result<Option<Record>, Damage> {
        self.state = McapState::Ended;
        let place = self.place();
        let unfinished = Damage::new(DamageKind::Unfinished, place, "a footer at the end of the file", b"");
        self.nothing_found(place);
        let Some(expected) = cut_record else { return Err(unfinished) };
        self.pending.push_front(unfinished);
        Err(Damage::new(DamageKind::Truncated, place, expected, b"the end of the file"))
    }

    /// Reads the regular end of the file.
    fn footer(&mut self) -> Result<Option<Record>, Damage> {
        let magic = mcap::MAGIC.len();
        let end = RECORD_HEADER + FOOTER as usize;
        if !self.has(end + magic)? || !self.source.window().get(end..).is_some_and(sniff) {
            return self.unfinished(Some("a footer and the magic number of MCAP".to_owned()));
        }
        self.state = McapState::Ended;
        let place = self.place();
        self.nothing_found(place);
        let missing = self.missing_messages(place);
        self.pending.extend(missing);
        self.source.consume(end + magic);
        if self.has(1)? {
            let expected = "the end of the file after the magic number";
            self.pending.push_back(Damage::new(DamageKind::Malformed, self.place(), expected, b"more bytes"));
        }
        Ok(None)
    }

    /// The damage if the file has fewer messages than its statistics state.
    fn missing_messages(&self, place: Place) -> Option<Damage> {
        let damage = |kind, expected, found: String| Damage::new(kind, place, expected, found.as_bytes());
        if !self.summary {
            let expected = "the end of the data section, as every file has it".to_owned();
            return Some(damage(DamageKind::Truncated, expected, "the footer".to_owned()));
        }
        let statistics = self.statistics.as_ref()?;
        if let Some((channel, told, found)) = self.topics.missing(statistics) {
            let expected = format!("{told} messages on {channel}, as the file's statistics say");
            return Some(damage(DamageKind::Malformed, expected, found.to_string()));
        }
        let told = statistics.message_count;
        (told > self.messages).then(|| {
            let expected = format!("{told} messages, as the file's statistics say");
            damage(DamageKind::Malformed, expected, self.messages.to_string())
        })
    }

    /// Reports a file without CAN channels, or without the topics that the user asked for.
    fn nothing_found(&mut self, place: Place) {
        let topics = &self.topics;
        let seen = || format!("topics {}", topics.seen.join(", "));
        let missing = topics.wanted.iter().filter(|wanted| !topics.seen.contains(wanted));
        let mut expected: Vec<String> = missing.map(|wanted| format!("the topic {wanted}")).collect();
        if topics.wanted.is_empty() && !topics.found && !topics.seen.is_empty() {
            expected.push("a topic with CAN frames".to_owned());
        }
        let damage = |expected, found: String| Damage::new(DamageKind::Unsupported, place, expected, found.as_bytes());
        let frameless = topics.frameless().map(|(channel, messages)| {
            damage(format!("a frame in each message on {channel}"), format!("{messages} without"))
        });
        let missing = expected.into_iter().map(|expected| damage(expected, seen()));
        let damages: Vec<Damage> = missing.chain(frameless).collect();
        self.pending.extend(damages);
    }

    fn open_chunk(&mut self, length: u64) -> Result<Option<Record>, Damage> {
        let place = self.place();
        let whole = length.saturating_add(RECORD_HEADER as u64);
        let head = usize::try_from(whole).unwrap_or(usize::MAX).min(RECORD_HEADER + chunk::HEADER);
        if !self.has(head)? {
            return self.unfinished(Some(format!("a chunk of {length} bytes")));
        }
        let parsed = chunk::header(self.source.window().get(RECORD_HEADER..head).unwrap_or_default());
        let malformed =
            |expected: String, found: String| Damage::new(DamageKind::Malformed, place, expected, found.as_bytes());
        let header = parsed.ok().map(|(_, header)| header);
        let Some(header) = header.filter(|header| header.compressed <= length.saturating_sub(header.length as u64))
        else {
            self.pass_over(op::CHUNK, length)?;
            return Err(malformed("a chunk whose header fits into it".into(), String::new()));
        };
        if header.uncompressed > chunk::LARGEST {
            self.pass_over(op::CHUNK, length)?;
            let expected = format!("a chunk of at most {} bytes, uncompressed", chunk::LARGEST);
            return Err(malformed(expected, header.uncompressed.to_string()));
        }
        self.source.consume(RECORD_HEADER + header.length);
        let left = length - header.length as u64;
        self.chunk_at = 0;
        self.chunk_place = place.offset;
        match chunk::unpack(&mut self.source, &header, left, &mut self.chunk) {
            Unpacked::Damaged { expected, found } => {
                self.chunk.clear();
                return Err(malformed(expected, found));
            }
            unpacked => self.chunk_cut = matches!(unpacked, Unpacked::Cut),
        }
        self.state = McapState::Chunk;
        Ok(None)
    }

    /// Reads the next record of the chunk.
    #[inline]
    fn chunk_record(&mut self) -> Result<Option<Record>, Damage> {
        let rest = self.chunk.get(self.chunk_at..).unwrap_or_default();
        let place = Place { number: self.messages + 1, offset: self.chunk_place };
        if rest.is_empty() {
            return self.end_of_chunk(None);
        }
        let Ok((behind, (code, length))) = record_header(rest) else {
            return self.end_of_chunk(Some("a record header of 9 bytes".to_owned()));
        };
        if code == 0 {
            return self.end_of_chunk(Some("a record in the chunk".to_owned()));
        }
        let Some(bytes) = usize::try_from(length).ok().and_then(|length| behind.get(..length)) else {
            return self.end_of_chunk(Some(format!("a record of {length} bytes in its chunk")));
        };
        self.chunk_at += RECORD_HEADER + bytes.len();
        self.messages += u64::from(code == op::MESSAGE);
        inner_record(&mut self.topics, code, bytes, place)
    }

    fn end_of_chunk(&mut self, missing: Option<String>) -> Result<Option<Record>, Damage> {
        self.state = McapState::Records;
        if std::mem::take(&mut self.chunk_cut) {
            return self.unfinished(Some(missing.unwrap_or_else(|| "the rest of a chunk".to_owned())));
        }
        let place = Place { number: self.messages, offset: self.chunk_place };
        match missing {
            Some(expected) => Err(Damage::new(DamageKind::Malformed, place, expected, b"the end of the chunk")),
            None => Ok(None),
        }
    }
}

/// The comment for the next message, from a metadata record whose lengths fit.
fn comment(bytes: &[u8]) -> Option<String> {
    match mcap::parse_record(op::METADATA, bytes).ok()? {
        records::Record::Metadata(mut read) if read.name == COMMENT => read.metadata.remove(COMMENT),
        _ => None,
    }
}

/// Handles a schema, channel or message, inside or outside a chunk.
#[inline]
fn inner_record(topics: &mut Topics, code: u8, bytes: &[u8], place: Place) -> Result<Option<Record>, Damage> {
    match code {
        op::MESSAGE => message(topics, bytes, place),
        op::SCHEMA => topics.schema(bytes).map(|()| None).map_err(|flaw| flaw.damage(place)),
        op::CHANNEL => topics.channel(bytes).map(|()| None).map_err(|flaw| flaw.damage(place)),
        _ => {
            let found = format!("code {code:02X}h, {} bytes", bytes.len());
            let expected = "a schema, a channel or a message in a chunk";
            Err(Damage::new(DamageKind::Unsupported, place, expected, found.as_bytes()))
        }
    }
}

#[inline]
fn message(topics: &mut Topics, bytes: &[u8], place: Place) -> Result<Option<Record>, Damage> {
    let Ok((data, (channel, logged))) = message_header(bytes) else {
        let flaw =
            Flaw::malformed(format!("a message header of {MESSAGE_HEADER} bytes"), format!("{} bytes", bytes.len()));
        return Err(flaw.damage(place));
    };
    let decoder = match topics.slots.get_mut(usize::from(channel)) {
        Some(Slot::Can(decoder)) => decoder,
        Some(Slot::Other) => return Ok(None),
        Some(Slot::Unreadable) => {
            let flaw = Flaw::unsupported("a message of a channel that can be read", format!("channel {channel}"));
            return Err(flaw.damage(place));
        }
        Some(Slot::Undeclared) | None => {
            let flaw = Flaw::malformed("a message of a channel declared before", format!("channel {channel}"));
            return Err(flaw.damage(place));
        }
    };
    decoder.messages += 1;
    // The limit holds inside a chunk too: decoding a message may need many times its length.
    if data.len() as u64 > LONGEST {
        let flaw = Flaw::malformed(format!("a message of at most {LONGEST} bytes"), data.len().to_string());
        return Err(flaw.damage(place));
    }
    let record = decoder.record(data, Timestamp(logged)).map_err(|flaw| flaw.damage(place))?;
    let Some(mut record) = record else {
        decoder.frameless += 1;
        return Ok(None);
    };
    topics.found = true;
    decoder.frames += 1;
    (record.channel, record.place) = (decoder.channel, place);
    Ok(Some(record))
}

impl Iterator for McapReader {
    type Item = Result<Record, Damage>;

    fn next(&mut self) -> Option<Self::Item> {
        loop {
            let next = match self.state {
                McapState::Chunk => self.chunk_record(),
                McapState::Records => self.record(),
                McapState::Magic => self.magic().map(|()| None),
                McapState::Ended => return self.pending.pop_front().map(Err),
            };
            match next {
                Ok(None) => {}
                Ok(Some(record)) => {
                    return Some(Ok(match self.comment.take() {
                        Some(comment) => record.with_comment(&comment),
                        None => record,
                    }));
                }
                Err(damage) => return Some(Err(damage)),
            }
        }
    }
}

impl Reader for McapReader {
    fn channels(&self) -> &Channels {
        &self.topics.channels
    }

    fn time_base(&self) -> TimeBase {
        TimeBase::Utc
    }
}
