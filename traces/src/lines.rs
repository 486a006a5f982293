//! Lines of a text capture, each with its number and offset.
//!
//! A line is returned as soon as it is complete in the source's window. A line longer than [`Lines::LONGEST`] is
//! skipped as one damage, in bounded memory. A UTF-8 byte order mark is not part of the first line.

use crate::grammar::Expected;
use crate::{Channels, Damage, DamageKind, Place, Reader, Record, SkipSet, Source, SourceError, TimeBase, Timestamp};
use memchr::memchr;
use std::borrow::Cow;

/// The UTF-8 byte order mark, which Windows editors write.
const BOM: &[u8] = b"\xEF\xBB\xBF";

/// The lines of a source.
pub(crate) struct Lines {
    source: Source,
    /// Length of the last returned line, including its line end; the next call consumes it.
    given: usize,
    number: u64,
    done: bool,
    /// The error that occurred when the head was read.
    failed: Option<SourceError>,
}

/// One line.
#[derive(Clone, Copy)]
pub(crate) struct Line<'a> {
    /// The bytes of the line without the line end.
    pub(crate) bytes: &'a [u8],
    /// Number and offset of the line.
    pub(crate) place: Place,
    /// Whether the line has a line end; if not, the source ended here, perhaps inside the line.
    pub(crate) ended: bool,
}

/// The end of the line at the window's start.
enum End {
    /// The line ends in a line feed after this number of bytes.
    Feed(usize),
    /// The source ends after this number of bytes.
    Source(usize),
    TooLong,
}

impl Lines {
    /// Maximum length of a parsed line in bytes: a CAN XL frame of 2048 bytes as bits on candump's console has 18
    /// KiB.
    pub(crate) const LONGEST: usize = 64 * 1024;

    pub(crate) fn new(source: Source) -> Self {
        Self { source, given: 0, number: 0, done: false, failed: None }
    }

    /// The buffered bytes before the first line; at least one unless the source is empty.
    fn head(&mut self) -> &[u8] {
        if self.source.window().is_empty() {
            self.failed = self.source.fill().err();
        }
        self.source.window()
    }

    /// The next line, if `usual` recognises it in the buffered bytes. `usual` returns the content of the line, and its
    /// length including the line end.
    #[inline]
    pub(crate) fn next_usual<T>(&mut self, usual: impl FnOnce(&[u8], Place) -> Option<(T, usize)>) -> Option<T> {
        self.source.consume(std::mem::take(&mut self.given));
        let place = Place { number: self.number + 1, offset: self.source.offset() };
        let (content, len) = usual(self.source.window(), place)?;
        debug_assert!((1..=self.source.window().len()).contains(&len), "a usual line lies in the window");
        (self.number, self.given) = (place.number, len);
        Some(content)
    }

    /// Skips lines, up to a limited number, until `pass` keeps a line or does not recognise it.
    #[inline]
    fn pass<F>(
        &mut self,
        format: &mut F,
        pass: impl Fn(&mut F, &[u8], Place) -> Option<Passed>,
        time: impl FnOnce(&F, &[u8]) -> Option<Timestamp>,
    ) -> PassedLines {
        self.source.consume(std::mem::take(&mut self.given));
        let begin = Place { number: self.number + 1, offset: self.source.offset() };
        let (window, mut at, mut last, mut skipped) = (self.source.window(), 0, 0, 0);
        let mut kept = None;
        while skipped < SkipSet::IN_A_ROW {
            let place = Place { number: begin.number + skipped as u64, offset: begin.offset + at as u64 };
            match pass(format, window.get(at..).unwrap_or_default(), place) {
                Some(Passed::Skipped(len)) => (at, last, skipped) = (at + len, at, skipped + 1),
                Some(Passed::Kept(record, len)) => {
                    (self.given, kept) = (len, Some(record));
                    break;
                }
                None => break,
            }
        }
        debug_assert!(at + self.given <= window.len(), "skipped lines lie in the window");
        let is_last = skipped > 0 && kept.is_none();
        let time = if is_last { window.get(last..).and_then(|line| time(format, line)) } else { None };
        self.number += skipped as u64 + u64::from(kept.is_some());
        self.source.consume(at);
        PassedLines { skipped, last: time, kept }
    }

    /// The next line; `None` at the end.
    pub(crate) fn next(&mut self) -> Option<Result<Line<'_>, Damage>> {
        self.source.consume(std::mem::take(&mut self.given));
        if self.done {
            return None;
        }
        self.number += 1;
        let place = Place { number: self.number, offset: self.source.offset() };
        match self.end() {
            Ok(End::Feed(len)) => {
                self.given = len + 1;
                Some(Ok(Line::new(self.source.window().get(..len).unwrap_or_default(), place, true)))
            }
            Ok(End::Source(0)) => {
                self.done = true;
                None
            }
            Ok(End::Source(len)) => {
                (self.given, self.done) = (len, true);
                Some(Ok(Line::new(self.source.window(), place, false)))
            }
            Ok(End::TooLong) => Some(Err(self.skip(place))),
            Err(error) => {
                self.done = true;
                Some(Err(Damage::source(&error, place)))
            }
        }
    }

    #[inline]
    fn end(&mut self) -> Result<End, SourceError> {
        if let Some(error) = self.failed.take() {
            return Err(error);
        }
        let mut searched = 0;
        loop {
            let window = self.source.window();
            match memchr(b'\n', window.get(searched..).unwrap_or_default()) {
                Some(at) if searched + at <= Self::LONGEST => return Ok(End::Feed(searched + at)),
                Some(_) => return Ok(End::TooLong),
                None if window.len() > Self::LONGEST => return Ok(End::TooLong),
                None => searched = window.len(),
            }
            if !self.source.fill()? {
                return Ok(End::Source(searched));
            }
        }
    }

    /// Skips a line that is too long.
    fn skip(&mut self, place: Place) -> Damage {
        let damage = Damage::new(
            DamageKind::Malformed,
            place,
            format!("a line of at most {} bytes", Self::LONGEST),
            self.source.window(),
        );
        loop {
            let window = self.source.window();
            if let Some(at) = memchr(b'\n', window) {
                self.source.consume(at + 1);
                return damage;
            }
            self.source.consume(window.len());
            match self.source.fill() {
                Ok(true) => {}
                Ok(false) => return damage,
                Err(error) => {
                    self.done = true;
                    return Damage::source(&error, place);
                }
            }
        }
    }
}

impl<'a> Line<'a> {
    /// The first byte of a two-byte line end is enough to know that the line is complete.
    fn new(bytes: &'a [u8], place: Place, ended: bool) -> Self {
        let bytes = if place.number == 1 { bytes.strip_prefix(BOM).unwrap_or(bytes) } else { bytes };
        match bytes.strip_suffix(b"\r") {
            Some(bytes) => Self { bytes, place, ended: true },
            None => Self { bytes, place, ended },
        }
    }

    /// The damage for missing text in this line: truncated if the source ended in the line, else malformed.
    pub(crate) fn damage(&self, missing: Expected<'_>) -> Damage {
        // The position points into this line, so the difference of the addresses is the column.
        let start = self.bytes.as_ptr() as usize;
        let column = (missing.at.as_ptr() as usize).saturating_sub(start).min(self.bytes.len());
        let found = self.bytes.get(column..).unwrap_or_default();
        let damage = match found {
            [] if !self.ended => self.cut(missing.what),
            [] => {
                let what = format!("{} before the line ends", missing.what);
                Damage::new(DamageKind::Malformed, self.place, what, b"")
            }
            _ => Damage::new(DamageKind::Malformed, self.place, missing.what, found),
        };
        damage.at_column(column + 1)
    }

    /// The damage for a line that the end of the source cuts.
    pub(crate) fn cut(&self, what: &'static str) -> Damage {
        let what = format!("{what} before the file ends");
        Damage::new(DamageKind::Truncated, self.place, what, self.bytes).at_column(self.bytes.len() + 1)
    }

    /// The damage for a line that contradicts the lines before it, or itself.
    pub(crate) fn malformed(&self, expected: impl Into<Cow<'static, str>>) -> Damage {
        Damage::new(DamageKind::Malformed, self.place, expected, self.bytes)
    }

    /// A damage of another kind, covering the whole line.
    pub(crate) fn as_damage(&self, kind: DamageKind, expected: &'static str) -> Damage {
        Damage::new(kind, self.place, expected, self.bytes)
    }
}

/// The lines at a source's head, for detection; the flag says whether the end of the line is visible.
pub(crate) fn head_lines(head: &[u8]) -> impl Iterator<Item = (&[u8], bool)> {
    let head = head.strip_prefix(BOM).unwrap_or(head);
    head.split_inclusive(|&b| b == b'\n').map(|line| match line.strip_suffix(b"\n") {
        Some(line) => (line.strip_suffix(b"\r").unwrap_or(line), true),
        None => (line, false),
    })
}

/// The beginning of comments that canvass writes, and that the reader attaches to the next frame. Other comments are a
/// person's or the format's own.
pub(crate) const NOTE: &str = "canvass: ";

/// The text of a comment of canvass.
fn note(line: &[u8]) -> Option<&str> {
    let line = line.trim_ascii();
    let text = line.strip_prefix(b"#").or_else(|| line.strip_prefix(b";")).or_else(|| line.strip_prefix(b"//"))?;
    std::str::from_utf8(text.trim_ascii_start().strip_prefix(NOTE.as_bytes())?).ok()
}

/// The result for a usual line, while some frames are skipped.
#[derive(PartialEq, Debug)]
pub(crate) enum Passed {
    /// The frame is skipped; the length of its line includes the line end.
    Skipped(usize),
    /// The record of the line, and the length of the line including the line end.
    Kept(Record, usize),
}

/// The result of skipping lines: the last skipped line, and the line after it.
struct PassedLines {
    skipped: usize,
    /// The time of the last skipped line, if no line is kept.
    last: Option<Timestamp>,
    /// The record of a kept line; `None` if the next line must be parsed in full.
    kept: Option<Record>,
}

/// The parser of one text format's lines.
pub(crate) trait LineFormat: Send {
    /// Examines the buffered bytes, perhaps only a part of the file, before the first line is read.
    fn begin(&mut self, _head: &[u8]) {}

    /// The record of the line at the window's start, and its length including the line end, if the line has the usual
    /// form. This saves the search for the line end and the full parser. The result must agree with
    /// [`LineFormat::line`], which is called after `None`.
    #[inline]
    fn usual_line(&mut self, _window: &[u8], _place: Place) -> Option<(Record, usize)> {
        None
    }

    /// Like [`LineFormat::usual_line`], while some frames are skipped. A format with this method never owes damages.
    #[inline]
    fn pass_line(&mut self, _window: &[u8], _skip: &SkipSet, _place: Place) -> Option<Passed> {
        None
    }

    /// The time of a skipped line.
    fn skipped_time(&self, _window: &[u8]) -> Option<Timestamp> {
        None
    }

    /// The content of a line; `None` for a known line without frame. Any other line is a damage.
    fn line(&mut self, line: &Line<'_>, channels: &mut Channels) -> Option<Result<Record, Damage>>;

    /// A damage that the lines so far have revealed in addition to their own damages; called after each line.
    fn owed(&mut self) -> Option<Damage> {
        None
    }

    /// Like [`LineFormat::owed`], at the end of the source.
    fn end(&mut self) -> Option<Damage> {
        None
    }

    /// See [`Reader::time_base`].
    fn time_base(&self) -> TimeBase;

    /// See [`Reader::bit_rate`].
    fn bit_rate(&self) -> Option<u32> {
        None
    }

    /// See [`Reader::interpretation`].
    fn interpretation(&self) -> Option<String> {
        None
    }
}

/// Reads a capture of a text format.
pub(crate) struct TextReader<F> {
    lines: Lines,
    channels: Channels,
    format: F,
    begun: bool,
    ended: bool,
    /// The comments before the next frame.
    notes: String,
}

impl<F: LineFormat> TextReader<F> {
    pub(crate) fn new(source: Source, format: F) -> Self {
        Self {
            lines: Lines::new(source),
            channels: Channels::new(),
            format,
            begun: false,
            ended: false,
            notes: String::new(),
        }
    }
}

impl<F> TextReader<F> {
    #[cold]
    fn noted(&mut self, record: Record) -> Record {
        let mut notes = std::mem::take(&mut self.notes);
        notes.push_str(record.comment().unwrap_or_default());
        record.with_comment(notes.trim_end())
    }

    #[inline]
    fn with_notes(&mut self, record: Record) -> Record {
        if self.notes.is_empty() { record } else { self.noted(record) }
    }
}

impl<F: LineFormat> Iterator for TextReader<F> {
    type Item = Result<Record, Damage>;

    fn next(&mut self) -> Option<Self::Item> {
        if !self.begun {
            self.begun = true;
            self.format.begin(self.lines.head());
        }
        let format = &mut self.format;
        if let Some(damage) = format.owed() {
            return Some(Err(damage));
        }
        if let Some(record) = self.lines.next_usual(|window, place| format.usual_line(window, place)) {
            if !self.notes.is_empty() {
                return Some(Ok(self.noted(record)));
            }
            return Some(Ok(record));
        }
        loop {
            match self.lines.next() {
                Some(Ok(line)) => match self.format.line(&line, &mut self.channels) {
                    Some(item) => return Some(item.map(|record| self.with_notes(record))),
                    None => {
                        let room = self.notes.len() < Record::LONGEST_COMMENT;
                        let text = note(line.bytes).filter(|_| room);
                        self.notes.extend(text.into_iter().flat_map(|text| [text, "\n"]));
                    }
                },
                Some(Err(damage)) => {
                    self.ended |= damage.kind.is_fatal();
                    return Some(Err(damage));
                }
                None if std::mem::replace(&mut self.ended, true) => return None,
                None => return self.format.end().map(Err),
            }
        }
    }
}

impl<F: LineFormat> Reader for TextReader<F> {
    fn channels(&self) -> &Channels {
        &self.channels
    }

    fn time_base(&self) -> TimeBase {
        self.format.time_base()
    }

    fn bit_rate(&self) -> Option<u32> {
        self.format.bit_rate()
    }

    fn interpretation(&self) -> Option<String> {
        self.format.interpretation()
    }

    fn next_kept(&mut self, skip: &mut SkipSet, record: &mut Record) -> Option<Result<(), Damage>> {
        let mut skipped = 0;
        while skipped < SkipSet::IN_A_ROW {
            // A line with a comment before it is parsed in full, so that the comment is attached to its frame.
            if self.begun && self.notes.is_empty() && !skip.is_empty() {
                let passed = self.lines.pass(
                    &mut self.format,
                    |format, window, place| format.pass_line(window, skip, place),
                    |format, window| format.skipped_time(window),
                );
                if passed.skipped > 0 {
                    skip.skipped_at(passed.last, passed.skipped);
                    skipped += passed.skipped;
                }
                if let Some(kept) = passed.kept {
                    *record = kept;
                    return Some(Ok(()));
                }
            }
            match self.next()? {
                Ok(next) if skipped < SkipSet::IN_A_ROW && skip.skips(&next) => skipped += 1,
                item => return Some(item.map(|next| *record = next)),
            }
        }
        Some(self.next()?.map(|next| *record = next))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::{self, Read};

    fn lines_of(source: Source) -> Vec<Result<(String, u64, u64, bool), DamageKind>> {
        let mut lines = Lines::new(source);
        let mut seen = Vec::new();
        while let Some(line) = lines.next() {
            seen.push(match line {
                Ok(line) => {
                    Ok((String::from_utf8_lossy(line.bytes).into(), line.place.number, line.place.offset, line.ended))
                }
                Err(damage) => Err(damage.kind),
            });
        }
        seen
    }

    fn line(text: &str, number: u64, offset: u64, ended: bool) -> Result<(String, u64, u64, bool), DamageKind> {
        Ok((text.into(), number, offset, ended))
    }

    #[test]
    fn numbered_with_their_offsets() {
        let source = Source::from_bytes(*b"\xEF\xBB\xBFone\r\n\ntwo");
        assert_eq!(
            lines_of(source),
            [line("one", 1, 0, true), line("", 2, 8, true), line("two", 3, 9, false)],
            "the mark is skipped, the last line has no end"
        );
        assert_eq!(lines_of(Source::from_bytes(*b"one\r")), [line("one", 1, 0, true)]);
        assert_eq!(lines_of(Source::from_bytes(*b"")), []);
    }

    #[test]
    fn long_lines_are_passed_over_in_bounded_memory() {
        let long = io::repeat(b'x').take(50_000_000).chain(&b"\nnext\n"[..]);
        assert_eq!(lines_of(Source::new(long)), [Err(DamageKind::Malformed), line("next", 2, 50_000_001, true)]);
        let mut longest = vec![b'x'; Lines::LONGEST + 1];
        assert_eq!(lines_of(Source::from_bytes(longest.clone())), [Err(DamageKind::Malformed)]);
        longest.pop();
        assert_eq!(lines_of(Source::from_bytes(longest)).iter().filter(|l| l.is_ok()).count(), 1);
    }

    #[test]
    fn a_failing_source_is_reported_once() {
        struct Fails;
        impl Read for Fails {
            fn read(&mut self, _: &mut [u8]) -> io::Result<usize> {
                Err(io::Error::other("gone"))
            }
        }
        let source = Source::new((&b"one\ntw"[..]).chain(Fails));
        assert_eq!(lines_of(source), [line("one", 1, 0, true), Err(DamageKind::Fatal)]);
    }
}
