//! Reads BLF.

use super::container;
use super::object::{self, BASE_HEADER, BaseHeader, Content, LOG_CONTAINER, SIGNATURE};
use crate::limited::Unpacked;
use crate::local_time;
use crate::{ChannelId, Channels, Damage, DamageKind, Place, ReadOptions, Reader, Record, Source, TimeBase, Timestamp};
use memchr::memmem;
use nom::bytes::complete::{tag, take};
use nom::multi::count;
use nom::number::complete::{le_u16, le_u32, le_u64};
use nom::{IResult, Parser};

const FILE_SIGNATURE: &[u8] = b"LOGG";
/// The part of the file header that is read.
const FILE_HEADER: usize = 56;
/// The largest file header; Vector's has 144 bytes.
const LARGEST_FILE_HEADER: u32 = 64 * 1024;
/// The filling between two objects is shorter than this.
const FILLING: usize = 8;

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
        last: None,
        done: false,
    })
}

struct BlfReader {
    source: Source,
    /// `None` until the file header was read.
    file: Option<File>,
    /// The stream of objects out of the containers, as far as it is at hand, and how far it is read.
    objects: Vec<u8>,
    at: usize,
    /// How many bytes of that stream, not at hand yet, belong to an object that is passed over.
    skip: u64,
    container_offset: u64,
    channels: Channels,
    /// The number of the last frame's channel, and what it is here.
    latest_channel: Option<(u16, ChannelId)>,
    number: u64,
    /// The last damage, after the end of the file.
    last: Option<Damage>,
    done: bool,
}

/// What the file header says.
#[derive(Clone, Copy)]
struct File {
    size: u64,
    header: u32,
    /// Start of the measurement in nanoseconds since 1970, local time; `None` if it does not say.
    start: Option<u64>,
}

/// Header size, file size, start of the measurement (year, month, weekday, day, hour, minute, second, millisecond).
fn file_header(i: &[u8]) -> IResult<&[u8], File> {
    let (i, (_, header, _, size, _, _, _)) =
        (tag(FILE_SIGNATURE), le_u32, take(8usize), le_u64, le_u64, le_u32, le_u32).parse(i)?;
    let (i, date) = count(le_u16, 8).parse(i)?;
    Ok((i, File { size, header, start: start(&date) }))
}

fn start(date: &[u16]) -> Option<u64> {
    let &[year, month, _, day, hour, minute, second, millisecond] = date else { return None };
    let [month, day, hour, minute, second] = [month, day, hour, minute, second].map(|n| i8::try_from(n).unwrap_or(-1));
    let fraction = i32::from(millisecond).checked_mul(1_000_000)?;
    let date =
        jiff::civil::DateTime::new(i16::try_from(year).ok()?, month, day, hour, minute, second, fraction).ok()?;
    local_time::nanos(date).filter(|&nanos| nanos > 0)
}

/// Where the next object begins.
enum Next {
    /// Behind so many bytes of filling.
    At(usize),
    /// Too few bytes to tell.
    More,
    /// Not here: what stands here is no object.
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

    /// The next object of the containers' stream, as far as it is at hand: `None` where more is needed.
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
                // The signature may begin at the very end.
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
            self.number += 1;
            return Some(Ok(None));
        }
        let object = object.get(..size)?;
        let content = object::content(header, object).map_err(|flaw| flaw.damage(place));
        self.at += filling + size;
        self.number += 1;
        Some(content.and_then(|content| self.take(content, place)))
    }

    /// A frame with its time and channel, or the damage that an object stands for.
    fn take(&mut self, content: Content, place: Place) -> Result<Option<Record>, Damage> {
        match content {
            Content::Lost(0) => Ok(None),
            Content::Lost(n) => Err(Damage::dropped(n, place)),
            Content::Frame { mut record, channel } => {
                let start = self.file.and_then(|file| file.start).unwrap_or_default();
                record.timestamp = Timestamp(start.saturating_add(record.timestamp.nanos()));
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
        self.number += 1;
        if let Some(damage) = unlikely(header, place) {
            self.source.consume(SIGNATURE.len());
            return Err(damage);
        }
        if !object::is_read(header.kind) {
            let skipped = self.source.skip(header.size.into()).unwrap_or_default();
            return if skipped < header.size.into() { Err(self.cut(place)) } else { Ok(None) };
        }
        if !self.has(header.size as usize)? {
            return Err(self.cut(place));
        }
        let object = self.source.window().get(..header.size as usize).unwrap_or_default();
        let content = object::content(header, object).map_err(|flaw| flaw.damage(place));
        self.source.consume(header.size as usize);
        content.and_then(|content| self.take(content, place))
    }

    /// Unpacks a container behind what is left of the one before.
    fn container(&mut self, header: BaseHeader) -> Result<Option<Record>, Damage> {
        let place = self.place();
        if header.size < (BASE_HEADER + container::HEADER) as u32 {
            self.source.consume(SIGNATURE.len());
            return Err(Damage::new(DamageKind::Malformed, place, "a container of at least 32 bytes", b""));
        }
        self.source.consume(BASE_HEADER);
        self.objects.drain(..self.at);
        self.at = 0;
        self.container_offset = place.offset;
        let length = u64::from(header.size) - BASE_HEADER as u64;
        match container::unpack(&mut self.source, length, &mut self.objects) {
            Unpacked::Whole => Ok(None),
            Unpacked::Cut => {
                let found = b"the end of the file";
                let expected = format!("a container of {} bytes", header.size);
                self.last = Some(Damage::new(DamageKind::Truncated, place, expected, found));
                Ok(None)
            }
            Unpacked::Damaged { expected, found } => {
                // What began in the container before would be continued by bytes that are not its own.
                self.objects.clear();
                self.skip = 0;
                Err(Damage::new(DamageKind::Malformed, place, expected, found.as_bytes()))
            }
        }
    }

    /// Passes over bytes that are no object, up to the next signature.
    fn resynchronise(&mut self) {
        loop {
            let window = self.source.window();
            if let Some(at) = memmem::find(window.get(1..).unwrap_or_default(), SIGNATURE) {
                self.source.consume(at + 1);
                return;
            }
            // The signature may begin at the very end.
            self.source.consume(window.len().saturating_sub(SIGNATURE.len() - 1).max(1));
            if !matches!(self.source.fill(), Ok(true)) {
                return;
            }
        }
    }

    fn cut(&mut self, place: Place) -> Damage {
        self.done = true;
        Damage::new(DamageKind::Truncated, place, "a whole object", b"the end of the file")
    }

    /// The file ends: whether it is all there.
    fn end(&mut self) -> Result<Option<Record>, Damage> {
        self.done = true;
        let place = self.place();
        let left = self.objects.get(self.at..).unwrap_or_default().iter().chain(self.source.window());
        let cut_object = left.clone().any(|&byte| byte != 0) || self.skip > 0;
        let offset = self.source.offset() + self.source.window().len() as u64;
        let file = self.file.filter(|file| file.size > offset || file.size <= file.header.into() && self.number > 0);
        let unfinished = file.map(|file| {
            let expected = format!("a file of {} bytes, as its header says", file.size);
            Damage::new(DamageKind::Unfinished, place, expected, offset.to_string().as_bytes())
        });
        let truncated = self.last.take().or_else(|| cut_object.then(|| self.cut(place)));
        match (truncated, unfinished) {
            (Some(truncated), unfinished) => {
                self.last = unfinished;
                Err(truncated)
            }
            (None, Some(unfinished)) => Err(unfinished),
            (None, None) => Ok(None),
        }
    }
}

fn no_object(place: Place, found: &[u8]) -> Damage {
    Damage::new(DamageKind::Malformed, place, "an object with the signature LOBJ", &found[..found.len().min(16)])
}

/// A header that no object has: behind its signature the next one is looked for.
fn unlikely(header: BaseHeader, place: Place) -> Option<Damage> {
    let least = if object::is_read(header.kind) { 2 * BASE_HEADER } else { BASE_HEADER };
    let fits = usize::from(header.header_size) >= least && header.size >= header.header_size.into();
    let small = !object::is_read(header.kind) || header.size as usize <= object::LARGEST;
    if fits && small {
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
