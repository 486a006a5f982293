//! Writing Vector ASC.

use crate::channel_numbers::ChannelNumbers;
use crate::formats::asc_row::{BUS_ERROR, FLAG_BRS, FLAG_ESI, FLAG_FDF};
use crate::hex::write_hex;
use crate::local_time::date_of;
use crate::text_writer::{LineWriter, TextWriter};
use crate::{Direction, Flags, Loss, Losses, Record, TimeBase, WriteError, WriteOptions, Writer};
use std::fmt::{self, Write as _};
use std::io::Write;

pub(crate) fn create(sink: Box<dyn Write>, options: &WriteOptions) -> Result<Box<dyn Writer>, WriteError> {
    let rows = AscRows { time_base: options.time_base, start: 0, numbers: ChannelNumbers::default() };
    Ok(Box::new(TextWriter::new(sink, rows)))
}

/// The writer of rows: times are absolute, with 6 decimals, or 9 if needed.
struct AscRows {
    time_base: TimeBase,
    /// The origin of the rows' times: the first record's time in whole milliseconds, which is the resolution of the
    /// date.
    start: u64,
    numbers: ChannelNumbers,
}

impl LineWriter for AscRows {
    const COMMENT: Option<(&'static str, &'static str)> = Some(("// ", "\n"));

    fn header(&mut self, first: Option<&Record>, out: &mut String) {
        let has_date = matches!(self.time_base, TimeBase::Utc | TimeBase::Local);
        // Writing into a String does not fail.
        let _ = match first {
            Some(first) if has_date => {
                let millis = first.timestamp.nanos() / 1_000_000;
                self.start = millis * 1_000_000;
                let date = header_date(self.start);
                write!(out, "date {date}\n{HEADER}Begin Triggerblock {date}\n   0.000000 Start of measurement\n")
            }
            _ => write!(out, "{HEADER}Begin Triggerblock\n   0.000000 Start of measurement\n"),
        };
    }

    fn record(&mut self, record: &Record, channel: &str, out: &mut String, losses: &mut Losses) {
        if record.frame.is_xl() {
            losses.count(Loss::Frame);
            return;
        }
        self.count_losses(record, losses);
        let number = self.numbers.number(record.channel, channel, losses);
        let nanos = record.timestamp.nanos().saturating_sub(self.start);
        let _ = write_time(out, nanos).and_then(|()| write_row(out, record, number));
    }

    fn footer(&mut self, out: &mut String) {
        out.push_str("End TriggerBlock\n");
    }
}

const HEADER: &str = "base hex  timestamps absolute\ninternal events logged\n";

impl AscRows {
    fn count_losses(&self, record: &Record, losses: &mut Losses) {
        if self.time_base == TimeBase::Utc {
            losses.count(Loss::TimeZone);
        }
        if record.timestamp.nanos() < self.start {
            losses.count(Loss::TimeResolution);
        }
        let frame = &record.frame;
        let holds_direction = frame.is_error() == (record.direction == Direction::Unknown);
        if !holds_direction {
            losses.count(Loss::Direction);
        }
        if let Some(class) = frame.error_class()
            && (class != BUS_ERROR || !frame.is_empty())
        {
            losses.count(Loss::ErrorDetail);
        }
    }
}

/// The date in the form of the English versions of CANalyzer, which all readers know.
fn header_date(nanos: u64) -> String {
    let date = date_of(nanos);
    let half = if date.hour() < 12 { "am" } else { "pm" };
    let millis = nanos / 1_000_000 % 1_000;
    format!("{}.{millis:03} {half} {}", date.strftime("%a %b %d %I:%M:%S"), date.year())
}

fn write_time(out: &mut String, nanos: u64) -> fmt::Result {
    let (secs, fraction) = (nanos / 1_000_000_000, nanos % 1_000_000_000);
    if fraction.is_multiple_of(1_000) {
        write!(out, "{secs:4}.{:06} ", fraction / 1_000)
    } else {
        write!(out, "{secs:4}.{fraction:09} ")
    }
}

fn write_row(out: &mut String, record: &Record, channel: u16) -> fmt::Result {
    let frame = &record.frame;
    if frame.is_error() {
        return writeln!(out, "{channel}  ErrorFrame");
    }
    let mark = if frame.id().is_extended() { "x" } else { "" };
    let id = format!("{:X}{mark}", frame.id().raw());
    // A frame of unknown direction is written as received.
    let direction = if record.direction == Direction::Tx { "Tx" } else { "Rx" };
    if frame.is_fd() {
        return write_fd_row(out, record, channel, &id, direction);
    }
    let kind = if frame.is_remote() { 'r' } else { 'd' };
    write!(out, "{channel}  {id:<15} {direction:<4} {kind} {:x}", frame.dlc())?;
    write_bytes(out, record.data())?;
    out.write_char('\n')
}

fn write_fd_row(out: &mut String, record: &Record, channel: u16, id: &str, direction: &str) -> fmt::Result {
    let (brs, esi) = (record.frame.flags().contains(Flags::BRS), record.frame.flags().contains(Flags::ESI));
    let flags = FLAG_FDF | if brs { FLAG_BRS } else { 0 } | if esi { FLAG_ESI } else { 0 };
    let (dlc, len) = (record.frame.dlc(), record.frame.len());
    write!(out, "CANFD {channel:>3} {direction:<4} {id:>8}  {:>32} ", "")?;
    write!(out, "{} {} {dlc:x} {len:>2}", u8::from(brs), u8::from(esi))?;
    write_bytes(out, record.data())?;
    // The columns are duration, bit count, flags, CRC and bit timings; only the flags are known.
    writeln!(out, " {:>8} {:>4} {flags:>8X} {:>8} {:>8} {:>8} {:>8} {:>8}", 0, 0, 0, 0, 0, 0, 0)
}

fn write_bytes(out: &mut String, data: &[u8]) -> fmt::Result {
    data.iter().try_for_each(|&byte| {
        out.write_char(' ')?;
        write_hex(out, byte)
    })
}
