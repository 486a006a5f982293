//! Reads BLF.

use super::container;
use super::object::{self, BASE_HEADER, BaseHeader, Content, LOG_CONTAINER, SIGNATURE};
use crate::formats::asc::LATEST;
use crate::limited::Unpacked;
use crate::local_time;
use crate::{ChannelId, Channels, Damage, DamageKind, Place, ReadOptions, Reader, Record, Source, TimeBase, Timestamp};
use memchr::memmem;
use nom::bytes::complete::{tag, take};
use nom::multi::count;
use nom::number::complete::{le_u16, le_u32, le_u64};
use nom::{IResult, Parser};

pub(super) const FILE_SIGNATURE: &[u8] = b"LOGG";
/// Length of the parsed part of the file header.
const FILE_HEADER: usize = 56;
/// Limit of the file header's size; Vector's header has 144 bytes.
const LARGEST_FILE_HEADER: u32 = 64 * 1024;
/// Limit of the gap between two objects: a gap is shorter.
pub(crate) const FILLING: usize = 8;

pub(crate) fn sniff(head: &[u8]) -> bool {
    head.starts_with(FILE_SIGNATURE)
}

pub(crate) fn open(source: Source, _options: &ReadOptions) -> Box<dyn Reader> {
    Box::new(BlfReader {
        source,
        file: None,
        objects: Vec::new(),
        at: 0,
        skip: 0,
        container_offset: 0,
        channels: Channels::new(),
        latest_channel: None,
        number: 0,
        counted: 0,
        last: None,
        done: false,
    })
}

struct BlfReader {
    source: Source,
    /// The file header; `None` until it was read.
    file: Option<File>,
    /// The unpacked part of the containers' stream, and the offset of the next object in it.
    objects: Vec<u8>,
    at: usize,
    /// Number of bytes of the stream, not unpacked yet, that belong to a skipped object.
    skip: u64,
    container_offset: u64,
    channels: Channels,
    /// The number of the last frame's channel in the file, and the id of the channel in this reader.
    latest_channel: Option<(u16, ChannelId)>,
    number: u64,
    /// Number of objects read that the file header also counts.
    counted: u64,
    /// The last damage, which is reported after the end of the file.
    last: Option<Damage>,
    done: bool,
}

/// The content of the file header.
#[derive(Clone, Copy)]
struct File {
    size: u64,
    header: u32,
    /// Number of objects; 0 if the file was not finished.
    objects: u32,
    /// Start of the measurement in nanoseconds since 1970, local time; `None` if the header has none.
    start: Option<u64>,
}

/// Parses header size, file size, start of the measurement (year, month, weekday, day, hour, minute, second,
/// millisecond).
fn file_header(i: &[u8]) -> IResult<&[u8], File> {
    let (i, (_, header, _, size, _, objects, _)) =
        (tag(FILE_SIGNATURE), le_u32, take(8usize), le_u64, le_u64, le_u32, le_u32).parse(i)?;
    let (i, date) = count(le_u16, 8).parse(i)?;
    Ok((i, File { size, header, objects, start: start(&date) }))
}

fn start(date: &[u16]) -> Option<u64> {
    let &[year, month, _, day, hour, minute, second, millisecond] = date else { return None };
    let [month, day, hour, minute, second] = [month, day, hour, minute, second].map(|n| i8::try_from(n).unwrap_or(-1));
    let fraction = i32::from(millisecond).checked_mul(1_000_000)?;
    let date =
        jiff::civil::DateTime::new(i16::try_from(year).ok()?, month, day, hour, minute, second, fraction).ok()?;
    local_time::nanos(date).filter(|&nanos| nanos > 0)
}

/// The place of the next object.
enum Next {
    /// The next object begins after this number of filling bytes.
    At(usize),
    /// The place is unknown yet: too few bytes are unpacked.
    More,
    /// The bytes at this place are no object.
    Lost,
}

fn next_object(bytes: &[u8]) -> Next {
    if bytes.starts_with(SIGNATURE) {
        return if bytes.len() < BASE_HEADER { Next::More } else { Next::At(0) };
    }
    match memmem::find(&bytes[..bytes.len().min(FILLING + SIGNATURE.len() - 1)], SIGNATURE) {
        Some(at) if bytes.len() >= at + BASE_HEADER => Next::At(at),
        Some(_) => Next::More,
        None if bytes.len() < FILLING + SIGNATURE.len() => Next::More,
        None => Next::Lost,
    }
}

impl BlfReader {
    fn place(&self) -> Place {
        Place { number: self.number, offset: self.source.offset() }
    }

    fn has(&mut self, n: usize) -> Result<bool, Damage> {
        self.source.fill_to(n).map_err(|error| {
            self.done = true;
            Damage::source(&error, self.place())
        })
    }

    fn open_file(&mut self) -> Result<(), Damage> {
        let fatal = |place, expected: &'static str| Damage::new(DamageKind::Fatal, place, expected, b"");
        let whole = self.has(FILE_HEADER)?;
        let parsed = file_header(self.source.window());
        let Some((_, file)) = parsed.ok().filter(|_| whole) else {
            return Err(fatal(self.place(), "a BLF file header"));
        };
        if !(FILE_HEADER as u32..=LARGEST_FILE_HEADER).contains(&file.header) || !self.has(file.header as usize)? {
            return Err(fatal(self.place(), "a whole BLF file header"));
        }
        self.source.consume(file.header as usize);
        self.file = Some(file);
        Ok(())
    }

    /// The next object of the containers' stream; `None` if more of it must be unpacked.
    fn stream_object(&mut self) -> Option<Result<Option<Record>, Damage>> {
        let skipped = usize::try_from(self.skip).unwrap_or(usize::MAX).min(self.objects.len() - self.at);
        self.at += skipped;
        self.skip -= skipped as u64;
        let place = Place { number: self.number + 1, offset: self.container_offset };
        let rest = self.objects.get(self.at..).unwrap_or_default();
        let filling = match next_object(rest) {
            Next::At(filling) => filling,
            Next::More => return None,
            Next::Lost => {
                let damage = no_object(place, rest);
                // The signature may begin in the last bytes.
                let to = memmem::find(rest, SIGNATURE).unwrap_or(rest.len() - SIGNATURE.len() + 1);
                self.at += to.max(1);
                return Some(Err(damage));
            }
        };
        let object = rest.get(filling..).unwrap_or_default();
        let Ok((_, header)) = object::base_header(object) else { return None };
        let size = header.size as usize;
        if let Some(damage) = unlikely(header, place) {
            self.at += filling + SIGNATURE.len();
            self.number += 1;
            return Some(Err(damage));
        }
        if !object::is_read(header.kind) {
            self.skip = (filling + size) as u64;
            return Some(self.pass_over(header, place));
        }
        let object = object.get(..size)?;
        self.number += 1;
        if let Some(inner) = object::hidden_object(header, object) {
            self.at += filling + inner;
            return Some(Err(hides_another(header, place)));
        }
        let content = object::content(header, object).map_err(|flaw| flaw.damage(place));
        self.at += filling + size;
        self.counted += 1;
        Some(content.and_then(|content| self.take(content, place)))
    }

    /// Skips an object of a type that has no frame; reports an object of an unknown type.
    fn pass_over(&mut self, header: BaseHeader, place: Place) -> Result<Option<Record>, Damage> {
        self.number += 1;
        self.counted += u64::from(header.kind != object::RESTORE_POINTS);
        if object::is_known(header.kind) {
            return Ok(None);
        }
        let found = format!("type {}", header.kind);
        Err(Damage::new(DamageKind::Unsupported, place, "an object of a known type", found.as_bytes()))
    }

    /// The record of a frame with its time and channel, or the damage that an object reports.
    fn take(&mut self, content: Content, place: Place) -> Result<Option<Record>, Damage> {
        match content {
            Content::Lost(0) => Ok(None),
            Content::Lost(n) => Err(Damage::dropped(n, place)),
            Content::Frame { mut record, channel } => {
                let start = Timestamp(self.file.and_then(|file| file.start).unwrap_or_default());
                let Some(timestamp) = start.after(record.timestamp.nanos()) else {
                    let found = format!("{} after the start", record.timestamp);
                    return Err(Damage::new(DamageKind::Malformed, place, LATEST, found.as_bytes()));
                };
                record.timestamp = timestamp;
                record.channel = match self.latest_channel {
                    Some((number, id)) if number == channel => id,
                    _ => self.channels.intern(&channel.to_string()),
                };
                self.latest_channel = Some((channel, record.channel));
                record.place = place;
                Ok(Some(record))
            }
        }
    }

    /// The next object of the file itself, mostly a container.
    fn file_object(&mut self) -> Result<Option<Record>, Damage> {
        self.has(FILLING + BASE_HEADER)?;
        let place = Place { number: self.number + 1, offset: self.source.offset() };
        let window = self.source.window();
        let filling = match next_object(window) {
            Next::At(filling) => filling,
            Next::More => return self.end(),
            Next::Lost => {
                let damage = no_object(place, window);
                self.resynchronise();
                return Err(damage);
            }
        };
        let Ok((_, header)) = object::base_header(window.get(filling..).unwrap_or_default()) else { return self.end() };
        self.source.consume(filling);
        if header.kind == LOG_CONTAINER {
            return self.container(header);
        }
        if let Some(damage) = unlikely(header, place) {
            self.number += 1;
            self.source.consume(SIGNATURE.len());
            return Err(damage);
        }
        if !object::is_read(header.kind) {
            let skipped = self.source.skip(header.size.into()).unwrap_or_default();
            if skipped < header.size.into() {
                return Err(self.cut(place));
            }
            return self.pass_over(header, place);
        }
        if !self.has(header.size as usize)? {
            return Err(self.cut(place));
        }
        self.number += 1;
        let object = self.source.window().get(..header.size as usize).unwrap_or_default();
        if let Some(inner) = object::hidden_object(header, object) {
            self.source.consume(inner);
            return Err(hides_another(header, place));
        }
        let content = object::content(header, object).map_err(|flaw| flaw.damage(place));
        self.source.consume(header.size as usize);
        self.counted += 1;
        content.and_then(|content| self.take(content, place))
    }

    /// Unpacks a container, and appends its content to the rest of the container before.
    fn container(&mut self, header: BaseHeader) -> Result<Option<Record>, Damage> {
        let place = self.place();
        if header.size < (BASE_HEADER + container::HEADER) as u32 {
            self.source.consume(SIGNATURE.len());
            self.resynchronise();
            return Err(Damage::new(DamageKind::Malformed, place, "a container of at least 32 bytes", b""));
        }
        self.source.consume(BASE_HEADER);
        self.objects.drain(..self.at);
        self.at = 0;
        self.container_offset = place.offset;
        let length = u64::from(header.size) - BASE_HEADER as u64;
        match container::unpack(&mut self.source, length, &mut self.objects) {
            Unpacked::Whole => Ok(None),
            Unpacked::Overlong(more) => {
                let found = format!("{more} bytes after its content");
                Err(Damage::new(DamageKind::Malformed, place, "a container that its content fills", found.as_bytes()))
            }
            Unpacked::Cut => {
                let found = b"the end of the file";
                let expected = format!("a container of {} bytes", header.size);
                self.last = Some(Damage::new(DamageKind::Truncated, place, expected, found));
                Ok(None)
            }
            Unpacked::Damaged { expected, found } => {
                // An object that began in the container before would continue with bytes of another object.
                self.objects.clear();
                self.skip = 0;
                self.resynchronise();
                Err(Damage::new(DamageKind::Malformed, place, expected, found.as_bytes()))
            }
        }
    }

    /// Skips bytes that are no object, up to the next signature.
    fn resynchronise(&mut self) {
        loop {
            let window = self.source.window();
            if let Some(at) = memmem::find(window, SIGNATURE) {
                self.source.consume(at);
                return;
            }
            // The signature may begin in the last bytes.
            self.source.consume(window.len().saturating_sub(SIGNATURE.len() - 1));
            if !matches!(self.source.fill(), Ok(true)) {
                return;
            }
        }
    }

    fn cut(&mut self, place: Place) -> Damage {
        self.done = true;
        Damage::new(DamageKind::Truncated, place, "a whole object", b"the end of the file")
    }

    /// Checks whether the file is complete, at its end.
    fn end(&mut self) -> Result<Option<Record>, Damage> {
        let place = self.place();
        let rest = self.objects.get(self.at..).unwrap_or_default();
        if let Ok((_, header)) = object::base_header(rest)
            && let Some(inner) = object::hidden_object(header, rest)
        {
            self.at += inner;
            self.number += 1;
            return Err(hides_another(header, place));
        }
        self.done = true;
        let left = self.objects.get(self.at..).unwrap_or_default().iter().chain(self.source.window());
        let cut_object = left.clone().any(|&byte| byte != 0) || self.skip > 0;
        let truncated = self.last.take().or_else(|| cut_object.then(|| self.cut(place)));
        let summary = self.unfinished(place).or_else(|| self.missing(place));
        match (truncated, summary) {
            (Some(truncated), summary) => {
                self.last = summary;
                Err(truncated)
            }
            (None, Some(summary)) => Err(summary),
            (None, None) => Ok(None),
        }
    }

    /// The damage if the file has fewer bytes than its header states, or its header was never finished.
    fn unfinished(&self, place: Place) -> Option<Damage> {
        let offset = self.source.offset() + self.source.window().len() as u64;
        let file = self.file.filter(|file| file.size > offset || file.size <= file.header.into() && self.number > 0)?;
        let expected = format!("a file of {} bytes, as its header says", file.size);
        Some(Damage::new(DamageKind::Unfinished, place, expected, offset.to_string().as_bytes()))
    }

    /// The damage if the file has fewer objects than its header states. More objects are no loss.
    fn missing(&self, place: Place) -> Option<Damage> {
        let objects = self.file?.objects;
        (u64::from(objects) > self.counted).then(|| {
            let expected = format!("{objects} objects, as the file's header says");
            Damage::new(DamageKind::Malformed, place, expected, self.counted.to_string().as_bytes())
        })
    }
}

fn hides_another(header: BaseHeader, place: Place) -> Damage {
    let found = format!("{} bytes with another object in them", header.size);
    Damage::new(DamageKind::Malformed, place, format!("an object of type {}", header.kind), found.as_bytes())
}

fn no_object(place: Place, found: &[u8]) -> Damage {
    Damage::new(DamageKind::Malformed, place, "an object with the signature LOBJ", &found[..found.len().min(16)])
}

/// The damage for an impossible header; the search for the next object begins after the signature of this one.
fn unlikely(header: BaseHeader, place: Place) -> Option<Damage> {
    if header.fits() {
        return None;
    }
    let found = format!("header {} of version {}, object {}", header.header_size, header.version, header.size);
    Some(Damage::new(DamageKind::Malformed, place, "an object header with its sizes", found.as_bytes()))
}

impl Iterator for BlfReader {
    type Item = Result<Record, Damage>;

    fn next(&mut self) -> Option<Self::Item> {
        if self.file.is_none()
            && !self.done
            && let Err(damage) = self.open_file()
        {
            self.done = true;
            return Some(Err(damage));
        }
        while !self.done {
            let next = match self.stream_object() {
                Some(next) => next,
                None => self.file_object(),
            };
            match next {
                Ok(None) => {}
                Ok(Some(record)) => return Some(Ok(record)),
                Err(damage) => return Some(Err(damage)),
            }
        }
        self.last.take().map(Err)
    }
}

impl Reader for BlfReader {
    fn channels(&self) -> &Channels {
        &self.channels
    }

    fn time_base(&self) -> TimeBase {
        match self.file {
            Some(File { start: None, .. }) => TimeBase::Start,
            _ => TimeBase::Local,
        }
    }
}
