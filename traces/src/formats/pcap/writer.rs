//! Writes pcap: little-endian, nanoseconds, link type 227.

use super::{CHANNEL, LONGEST};
use crate::formats::socketcan;
use crate::{Channels, Direction, Format, Loss, Losses, Record, TimeBase, WriteError, WriteOptions, Writer};
use byteorder::LittleEndian;
use pcap_file::pcap::{PcapHeader, PcapTsResolution, PcapWriteError, RawPcapPacket};
use pcap_file::{DataLink, Endianness};
use std::io::Write;

struct PcapWriter {
    sink: Box<dyn Write>,
    /// The frame and the complete packet being written.
    frame: Vec<u8>,
    packet: Vec<u8>,
    time_base: TimeBase,
    losses: Losses,
}

pub(crate) fn create(mut sink: Box<dyn Write>, options: &WriteOptions) -> Result<Box<dyn Writer>, WriteError> {
    let header = PcapHeader {
        snaplen: LONGEST,
        datalink: DataLink::CAN_SOCKETCAN,
        ts_resolution: PcapTsResolution::NanoSecond,
        endianness: Endianness::Little,
        ..PcapHeader::default()
    };
    header.write_to(&mut sink).map_err(failed)?;
    let (frame, packet) = (Vec::new(), Vec::new());
    Ok(Box::new(PcapWriter { sink, frame, packet, time_base: options.time_base, losses: Losses::default() }))
}

fn failed(error: PcapWriteError) -> WriteError {
    match error {
        PcapWriteError::Io(error) | PcapWriteError::FieldWriteFailed(_, error) => error.into(),
        PcapWriteError::Validation(error) => WriteError::Format { format: Format::Pcap, reason: error.to_string() },
    }
}

impl Writer for PcapWriter {
    fn write(&mut self, record: &Record, channels: &Channels) -> Result<(), WriteError> {
        if channels.name(record.channel) != CHANNEL {
            self.losses.count(Loss::ChannelName);
        }
        if record.direction != Direction::Unknown {
            self.losses.count(Loss::Direction);
        }
        self.losses.count_any(record.comment().map(|_| Loss::Comment));
        self.losses.count_any(Loss::of_utc(self.time_base));
        let nanos = record.timestamp.nanos();
        // The 32 bits of seconds last until 2106.
        let ts_sec = u32::try_from(nanos / 1_000_000_000).unwrap_or_else(|_| {
            self.losses.count(Loss::Date);
            u32::MAX
        });
        let ts_frac = (nanos % 1_000_000_000) as u32;
        self.frame.clear();
        socketcan::encode(record, &mut self.frame);
        // The length is at most that of a CAN XL frame.
        let length = self.frame.len() as u32;
        let packet =
            RawPcapPacket { ts_sec, ts_frac, incl_len: length, orig_len: length, data: self.frame.as_slice().into() };
        self.packet.clear();
        packet.write_to::<_, LittleEndian>(&mut self.packet).map_err(failed)?;
        Ok(self.sink.write_all(&self.packet)?)
    }

    fn flush(&mut self) -> Result<(), WriteError> {
        Ok(self.sink.flush()?)
    }

    fn finish(&mut self) -> Result<(), WriteError> {
        self.flush()
    }

    fn losses(&self) -> &Losses {
        &self.losses
    }
}
