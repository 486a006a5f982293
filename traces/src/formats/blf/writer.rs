//! Writes BLF: one object for each frame, in containers deflated by zlib. Times count in nanoseconds from the start of
//! the measurement, which is that of the first record, in whole milliseconds.

use super::object::{
    BASE_HEADER, CAN_ERROR_EXT, CAN_FD_MESSAGE, CAN_MESSAGE, EDL, EXTENDED, LOG_CONTAINER, REMOTE, SIGNATURE, TX,
};
use super::reader::FILE_SIGNATURE;
use crate::channel_numbers::ChannelNumbers;
use crate::local_time::date_of;
use crate::{Channels, Direction, Flags, Loss, Losses, Record, TimeBase, WriteError, WriteOptions, Writer};
use flate2::Compression;
use flate2::write::ZlibEncoder;
use std::io::Write;

/// Length of the file header.
const FILE_HEADER: usize = 144;
/// Length of an object's header of version 1, with its flags and its time.
const OBJECT_HEADER: usize = 2 * BASE_HEADER;
/// Length of a container's header, with that of its object.
const CONTAINER_HEADER: usize = 2 * BASE_HEADER;
/// Maximum length of a container's content, as Vector's tools have it.
const CONTAINER: usize = 128 * 1024;
/// Flag of an object: its time stamp counts nanoseconds.
const NANOSECONDS: u32 = 2;
const DEFLATED: u16 = 2;

struct BlfWriter {
    sink: Box<dyn Write>,
    /// Whether the file header was written: it has the time of the first record, also if the file is never finished.
    is_begun: bool,
    time_base: TimeBase,
    /// Start of the measurement; `None` before the first record.
    start: Option<u64>,
    /// The latest time of a record.
    end: u64,
    /// The objects of the next container.
    objects: Vec<u8>,
    count: u32,
    /// Size of the file, and its size if its containers were plain.
    size: u64,
    plain_size: u64,
    numbers: ChannelNumbers,
    losses: Losses,
    /// The file header with all sizes, when the file is finished.
    header: Option<Vec<u8>>,
}

pub(crate) fn create(sink: Box<dyn Write>, options: &WriteOptions) -> Result<Box<dyn Writer>, WriteError> {
    Ok(Box::new(BlfWriter {
        sink,
        is_begun: false,
        time_base: options.time_base,
        start: None,
        end: 0,
        objects: Vec::with_capacity(CONTAINER),
        count: 0,
        size: FILE_HEADER as u64,
        plain_size: FILE_HEADER as u64,
        numbers: ChannelNumbers::default(),
        losses: Losses::default(),
        header: None,
    }))
}

/// The file header. The span is the start and the end of the measurement.
fn header(size: u64, plain_size: u64, objects: u32, span: [Option<u64>; 2]) -> Vec<u8> {
    let mut header = FILE_SIGNATURE.to_vec();
    header.extend((FILE_HEADER as u32).to_le_bytes());
    // The application and its version, then the version of the format.
    header.extend([0, 0, 0, 0, 2, 6, 8, 1]);
    header.extend(size.to_le_bytes());
    header.extend(plain_size.to_le_bytes());
    header.extend(objects.to_le_bytes());
    header.extend(objects.to_le_bytes());
    for time in span {
        header.extend(time.map_or([0; 8], date).into_iter().flat_map(u16::to_le_bytes));
    }
    header.resize(FILE_HEADER, 0);
    header
}

/// Year, month, weekday (0: Sunday), day, hour, minute, second, millisecond.
fn date(nanos: u64) -> [u16; 8] {
    let date = date_of(nanos);
    let millisecond = (nanos / 1_000_000 % 1_000) as u16;
    let weekday = date.weekday().to_sunday_zero_offset();
    let parts = [date.month(), weekday, date.day(), date.hour(), date.minute(), date.second()];
    let [month, weekday, day, hour, minute, second] = parts.map(|part| part.unsigned_abs().into());
    [date.year().unsigned_abs(), month, weekday, day, hour, minute, second, millisecond]
}

impl BlfWriter {
    /// Writes the file header. Until the file is finished, it says that nothing is in the file.
    fn begin(&mut self) -> Result<(), WriteError> {
        if !std::mem::replace(&mut self.is_begun, true) {
            let start = self.start.filter(|start| *start > 0);
            self.sink.write_all(&header(0, 0, 0, [start, None]))?;
        }
        Ok(())
    }

    /// Appends the record's object. All objects have a multiple of four bytes, so that no filling is needed.
    fn object(&mut self, record: &Record, channel: u16) {
        let frame = &record.frame;
        let kind = match () {
            () if frame.is_error() => CAN_ERROR_EXT,
            () if frame.is_fd() => CAN_FD_MESSAGE,
            () => CAN_MESSAGE,
        };
        let at = self.objects.len();
        self.objects.extend_from_slice(SIGNATURE);
        self.objects.extend((OBJECT_HEADER as u16).to_le_bytes());
        self.objects.extend(1_u16.to_le_bytes());
        // The size, which is known at the end.
        self.objects.extend([0; 4]);
        self.objects.extend(kind.to_le_bytes());
        self.objects.extend(NANOSECONDS.to_le_bytes());
        self.objects.extend([0; 4]);
        let time = record.timestamp.nanos().saturating_sub(self.start.unwrap_or_default());
        self.objects.extend(time.to_le_bytes());
        match kind {
            CAN_ERROR_EXT => self.error(record, channel),
            CAN_FD_MESSAGE => self.fd_message(record, channel),
            _ => self.message(record, channel),
        }
        let size = (self.objects.len() - at) as u32;
        debug_assert!(size.is_multiple_of(4), "the sizes of all bodies are multiples of four");
        self.objects[at + 8..at + 12].copy_from_slice(&size.to_le_bytes());
        self.count += 1;
    }

    /// Appends the body of a CAN message: channel, flags, DLC, identifier, eight bytes.
    fn message(&mut self, record: &Record, channel: u16) {
        let frame = &record.frame;
        let flags = sent(record) | if frame.is_remote() { REMOTE } else { 0 };
        self.objects.extend(channel.to_le_bytes());
        self.objects.extend([flags, frame.dlc()]);
        self.objects.extend(id(record).to_le_bytes());
        self.objects.extend(frame.bytes());
    }

    /// Appends the body of a CAN FD message: channel, flags, DLC, identifier, frame length, bit count, CAN FD flags, valid
    /// bytes, reserved (5), 64 bytes.
    fn fd_message(&mut self, record: &Record, channel: u16) {
        let frame = &record.frame;
        let flag = |flag, bit| if frame.flags().contains(flag) { bit } else { 0 };
        let fd_flags = EDL | flag(Flags::BRS, super::object::BRS) | flag(Flags::ESI, super::object::ESI);
        let data = record.data();
        self.objects.extend(channel.to_le_bytes());
        self.objects.extend([sent(record), frame.dlc()]);
        self.objects.extend(id(record).to_le_bytes());
        self.objects.extend([0; 5]);
        self.objects.extend([fd_flags, data.len() as u8, 0, 0, 0, 0, 0]);
        let end = self.objects.len() + 64;
        self.objects.extend_from_slice(data);
        self.objects.resize(end, 0);
    }

    /// Appends the body of an error frame: channel, length, flags, ECC, position, DLC, reserved, frame length, identifier,
    /// flags, reserved, data. As in python-can's files, the identifier is Linux's error class, and the data are its detail
    /// bytes.
    fn error(&mut self, record: &Record, channel: u16) {
        let frame = &record.frame;
        let class = frame.error_class().map_or(0, |class| class.0);
        self.objects.extend(channel.to_le_bytes());
        self.objects.extend([0; 8]);
        self.objects.extend([frame.len() as u8, 0]);
        self.objects.extend([0; 4]);
        self.objects.extend(class.to_le_bytes());
        self.objects.extend([0; 4]);
        self.objects.extend(frame.bytes());
    }

    fn count_losses(&mut self, record: &Record) {
        let losses = &mut self.losses;
        if self.time_base == TimeBase::Utc {
            losses.count(Loss::TimeZone);
        }
        if record.timestamp.nanos() < self.start.unwrap_or_default() {
            losses.count(Loss::TimeResolution);
        }
        if (record.direction == Direction::Unknown) != record.frame.is_error() {
            losses.count(Loss::Direction);
        }
        // Without a class an error frame says nothing, and is read as a bus error.
        if record.frame.error_class().is_some_and(|class| class.0 == 0) {
            losses.count(Loss::ErrorDetail);
        }
        if record.comment().is_some() {
            losses.count(Loss::Comment);
        }
    }

    /// Writes the objects as a container.
    fn container(&mut self) -> Result<(), WriteError> {
        if self.objects.is_empty() {
            return Ok(());
        }
        let mut packed = ZlibEncoder::new(Vec::with_capacity(self.objects.len() / 2), Compression::default());
        packed.write_all(&self.objects)?;
        let packed = packed.finish()?;
        let size = CONTAINER_HEADER + packed.len();
        let mut head = SIGNATURE.to_vec();
        head.extend((BASE_HEADER as u16).to_le_bytes());
        head.extend(1_u16.to_le_bytes());
        head.extend((size as u32).to_le_bytes());
        head.extend(LOG_CONTAINER.to_le_bytes());
        head.extend(DEFLATED.to_le_bytes());
        head.extend([0; 6]);
        head.extend((self.objects.len() as u32).to_le_bytes());
        head.extend([0; 4]);
        self.sink.write_all(&head)?;
        self.sink.write_all(&packed)?;
        // Vector's tools and python-can fill with as many bytes as the size exceeds a multiple of four.
        let filling = size % 4;
        self.sink.write_all(&[0; 3][..filling])?;
        self.size += (size + filling) as u64;
        self.plain_size += (CONTAINER_HEADER + self.objects.len()) as u64;
        self.objects.clear();
        Ok(())
    }
}

/// The flag of a sent frame.
fn sent(record: &Record) -> u8 {
    if record.direction == Direction::Tx { TX } else { 0 }
}

fn id(record: &Record) -> u32 {
    let id = record.frame.id();
    id.raw() | if id.is_extended() { EXTENDED } else { 0 }
}

impl Writer for BlfWriter {
    fn write(&mut self, record: &Record, channels: &Channels) -> Result<(), WriteError> {
        /// Length of the largest object, a CAN FD message.
        const LARGEST: usize = OBJECT_HEADER + 84;
        if record.frame.is_xl() {
            self.losses.count(Loss::Frame);
            return Ok(());
        }
        let nanos = record.timestamp.nanos();
        let has_date = matches!(self.time_base, TimeBase::Utc | TimeBase::Local);
        self.start.get_or_insert(if has_date { nanos / 1_000_000 * 1_000_000 } else { 0 });
        self.begin()?;
        self.end = self.end.max(nanos);
        self.count_losses(record);
        let channel = self.numbers.number(record.channel, channels.name(record.channel), &mut self.losses);
        self.object(record, channel);
        if self.objects.len() + LARGEST > CONTAINER { self.container() } else { Ok(()) }
    }

    fn flush(&mut self) -> Result<(), WriteError> {
        self.container()?;
        Ok(self.sink.flush()?)
    }

    fn finish(&mut self) -> Result<(), WriteError> {
        self.begin()?;
        self.flush()?;
        let span = match self.start {
            Some(start) if start > 0 => [Some(start), Some(self.end)],
            _ => [None, None],
        };
        self.header = Some(header(self.size, self.plain_size, self.count, span));
        Ok(())
    }

    fn losses(&self) -> &Losses {
        &self.losses
    }

    fn beginning(&self) -> Option<&[u8]> {
        self.header.as_deref()
    }
}
