//! Writing PEAK TRC 2.1.

use crate::channel_numbers::ChannelNumbers;
use crate::formats::asc_row::BUS_ERROR;
use crate::formats::trc::{DAY, DAYS_TO_1970};
use crate::hex::write_hex;
use crate::local_time::date_of;
use crate::text_writer::{LineWriter, TextWriter};
use crate::{Direction, Flags, Loss, Losses, Record, TimeBase, WriteError, WriteOptions, Writer};
use std::fmt::{self, Write as _};
use std::io::Write;

pub(crate) fn create(sink: Box<dyn Write>, options: &WriteOptions) -> Result<Box<dyn Writer>, WriteError> {
    let numbers = ChannelNumbers::default();
    Ok(Box::new(TextWriter::new(sink, TrcRows { time_base: options.time_base, start: 0, written: 0, numbers })))
}

struct TrcRows {
    time_base: TimeBase,
    /// The origin of the offsets: the first record's time, in whole milliseconds.
    start: u64,
    written: u64,
    numbers: ChannelNumbers,
}

impl LineWriter for TrcRows {
    const COMMENT: Option<(&'static str, &'static str)> = Some(("; ", "\r\n"));

    fn header(&mut self, first: Option<&Record>, out: &mut String) {
        out.push_str(";$FILEVERSION=2.1\r\n");
        if let Some(first) = first
            && matches!(self.time_base, TimeBase::Utc | TimeBase::Local)
        {
            self.start = first.timestamp.nanos() / 1_000_000 * 1_000_000;
            // Writing into a String does not fail.
            let _ = write_start(out, self.start);
        } else {
            out.push_str(";$COLUMNS=N,O,T,B,I,d,R,L,D\r\n;\r\n");
        }
        out.push_str(HEADER);
    }

    fn record(&mut self, record: &Record, channel: &str, out: &mut String, losses: &mut Losses) {
        if record.frame.is_xl() {
            losses.count(Loss::Frame);
            return;
        }
        self.count_losses(record, losses);
        self.written += 1;
        let number = self.numbers.number(record.channel, channel, losses);
        let _ = self.write_row(out, record, number);
    }
}

/// Writes the start in days, with enough digits to read back the exact millisecond.
fn write_start(out: &mut String, start: u64) -> fmt::Result {
    const SCALE: u128 = 1_000_000_000_000_000;
    let days = start / DAY + DAYS_TO_1970;
    let fraction = u128::from(start % DAY) * SCALE / u128::from(DAY);
    let date = date_of(start).strftime("%d.%m.%Y %H:%M:%S");
    let millis = start / 1_000_000 % 1_000;
    write!(out, ";$STARTTIME={days}.{fraction:015}\r\n;$COLUMNS=N,O,T,B,I,d,R,L,D\r\n;\r\n")?;
    write!(out, ";   Start time: {date}.{millis:03}.0\r\n")
}

const HEADER: &str = ";-------------------------------------------------------------------------------\r
;   Bus   Name            Connection               Protocol\r
;   N/A   N/A             N/A                      N/A\r
;-------------------------------------------------------------------------------\r
;   Message   Time    Type    ID     Rx/Tx\r
;   Number    Offset  |  Bus  [hex]  |  Reserved\r
;   |         [ms]    |  |    |      |  |  Data Length Code\r
;   |         |       |  |    |      |  |  |    Data [hex] ...\r
;   |         |       |  |    |      |  |  |    |\r
;---+-- ------+------ +- +- --+----- +- +- +--- +- -- -- -- -- -- -- --\r
";

impl TrcRows {
    fn count_losses(&self, record: &Record, losses: &mut Losses) {
        if self.time_base == TimeBase::Utc {
            losses.count(Loss::TimeZone);
        }
        if record.timestamp.nanos() < self.start || !record.timestamp.nanos().is_multiple_of(1_000) {
            losses.count(Loss::TimeResolution);
        }
        if record.direction == Direction::Unknown {
            losses.count(Loss::Direction);
        }
        if let Some(class) = record.frame.error_class()
            && (class != BUS_ERROR || !record.frame.is_empty())
        {
            losses.count(Loss::ErrorDetail);
        }
    }

    fn write_row(&self, out: &mut String, record: &Record, bus: u16) -> fmt::Result {
        let frame = &record.frame;
        let micros = record.timestamp.nanos().saturating_sub(self.start) / 1_000;
        write!(out, "{:>7} {:>9}.{:03} {} {bus:<2} ", self.written, micros / 1_000, micros % 1_000, kind(record))?;
        match () {
            () if frame.is_error() => write!(out, "{:>8}", "-")?,
            () if frame.id().is_extended() => write!(out, "{:08X}", frame.id().raw())?,
            () => write!(out, "    {:04X}", frame.id().raw())?,
        }
        let direction = if record.direction == Direction::Tx { "Tx" } else { "Rx" };
        if frame.is_error() {
            return write!(out, " {direction} -  0   \r\n");
        }
        write!(out, " {direction} -  {:<4}", frame.dlc())?;
        for &byte in record.data() {
            out.write_char(' ')?;
            write_hex(out, byte)?;
        }
        out.write_str("\r\n")
    }
}

fn kind(record: &Record) -> &'static str {
    let flags = record.frame.flags();
    match (flags.contains(Flags::BRS), flags.contains(Flags::ESI)) {
        _ if record.frame.is_error() => "ER",
        _ if record.frame.is_remote() => "RR",
        _ if !record.frame.is_fd() => "DT",
        (false, false) => "FD",
        (true, false) => "FB",
        (false, true) => "FE",
        (true, true) => "BI",
    }
}
