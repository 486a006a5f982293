//! Writes pcapng: one section, little-endian, one interface per channel with its name, times in nanoseconds.

use crate::formats::socketcan;
use crate::{Channels, Direction, Format, Loss, Losses, Record, TimeBase, WriteError, WriteOptions, Writer};
use pcap_file::pcapng::RawBlock;
use pcap_file::pcapng::blocks::ENHANCED_PACKET_BLOCK;
use pcap_file::pcapng::blocks::enhanced_packet::{EnhancedPacketBlock, EnhancedPacketOption};
use pcap_file::pcapng::blocks::interface_description::{
    InterfaceDescriptionBlock, InterfaceDescriptionOption, InterfaceTsResolution,
};
use pcap_file::pcapng::blocks::opt_common::CommonOption;
use pcap_file::pcapng::blocks::section_header::{SectionHeaderBlock, SectionHeaderOption};
use pcap_file::pcapng::{PcapNgWriteError, PcapNgWriter};
use pcap_file::{DataLink, Endianness};
use std::io::Write;
use std::time::Duration;

/// Total length of a block's type and of its length before and after the body.
const FRAMING: usize = 12;

/// Maximum length of a name in an option, in bytes; longer channel names are cut.
const LONGEST_NAME: usize = u16::MAX as usize;

struct PcapngWriter {
    sink: Box<dyn Write>,
    /// Collects a block in memory; the complete block goes to the sink.
    blocks: PcapNgWriter<Vec<u8>>,
    /// The interface of each channel; `None` before it is described.
    interfaces: Vec<Option<u32>>,
    /// The packet being written.
    body: Vec<u8>,
    time_base: TimeBase,
    losses: Losses,
}

pub(crate) fn create(sink: Box<dyn Write>, options: &WriteOptions) -> Result<Box<dyn Writer>, WriteError> {
    let header = SectionHeaderBlock {
        endianness: Endianness::Little,
        options: vec![SectionHeaderOption::UserApplication("canvass".into())],
        ..SectionHeaderBlock::default()
    };
    let mut writer = PcapngWriter {
        sink,
        blocks: PcapNgWriter::with_section_header(Vec::new(), header).map_err(failed)?,
        interfaces: Vec::new(),
        body: Vec::new(),
        time_base: options.time_base,
        losses: Losses::default(),
    };
    writer.pass_on()?;
    Ok(Box::new(writer))
}

fn failed(error: PcapNgWriteError) -> WriteError {
    match error {
        PcapNgWriteError::Io(error) => error.into(),
        other => WriteError::Format { format: Format::Pcapng, reason: other.to_string() },
    }
}

impl PcapngWriter {
    fn pass_on(&mut self) -> Result<(), WriteError> {
        self.sink.write_all(self.blocks.get_ref())?;
        self.blocks.get_mut().clear();
        Ok(())
    }

    /// The interface of a record's channel. An interface is described before its first frame.
    fn interface(&mut self, record: &Record, channels: &Channels) -> Result<u32, WriteError> {
        let at = usize::from(record.channel.0);
        if let Some(Some(number)) = self.interfaces.get(at) {
            return Ok(*number);
        }
        let name = channels.name(record.channel);
        let name = &name[..name.floor_char_boundary(LONGEST_NAME)];
        let number = self.blocks.interfaces().len() as u32;
        let description = InterfaceDescriptionBlock {
            linktype: DataLink::CAN_SOCKETCAN,
            snaplen: 0,
            options: vec![
                InterfaceDescriptionOption::IfName(name.into()),
                InterfaceDescriptionOption::IfTsResol(InterfaceTsResolution::NANO),
            ],
        };
        self.blocks.write_pcapng_block(description).map_err(failed)?;
        if self.interfaces.len() <= at {
            self.interfaces.resize(at + 1, None);
        }
        self.interfaces[at] = Some(number);
        Ok(number)
    }
    /// Writes a packet with its options: direction and comment, if known.
    fn write_packet(&mut self, record: &Record, interface_id: u32) -> Result<(), WriteError> {
        let mut frame = Vec::new();
        socketcan::encode(record, &mut frame);
        let direction = flags(record.direction).map(EnhancedPacketOption::Flags);
        let comment = record.comment().map(|text| EnhancedPacketOption::Common(CommonOption::Comment(text.into())));
        let packet = EnhancedPacketBlock {
            interface_id,
            timestamp: Duration::from_nanos(record.timestamp.nanos()),
            // The length is at most that of a CAN XL frame.
            original_len: frame.len() as u32,
            data: frame.into(),
            options: direction.into_iter().chain(comment).collect(),
        };
        self.blocks.write_pcapng_block(packet).map_err(failed)?;
        Ok(())
    }

    /// Writes a packet without comment, at a quarter of the cost: the crate writes every packet twice, the first time
    /// only to learn its length.
    fn write_usual_packet(&mut self, record: &Record, interface_id: u32) -> Result<(), WriteError> {
        let nanos = record.timestamp.nanos();
        self.body.clear();
        self.body.extend_from_slice(&interface_id.to_le_bytes());
        self.body.extend_from_slice(&((nanos >> 32) as u32).to_le_bytes());
        self.body.extend_from_slice(&(nanos as u32).to_le_bytes());
        self.body.extend_from_slice(&[0; 8]);
        let start = self.body.len();
        socketcan::encode(record, &mut self.body);
        let length = ((self.body.len() - start) as u32).to_le_bytes();
        self.body[start - 8..start - 4].copy_from_slice(&length);
        self.body[start - 4..start].copy_from_slice(&length);
        self.body.resize(self.body.len().next_multiple_of(4), 0);
        if let Some(flags) = flags(record.direction) {
            self.body.extend_from_slice(&[2, 0, 4, 0]);
            self.body.extend_from_slice(&flags.to_le_bytes());
            self.body.extend_from_slice(&[0; 4]);
        }
        let length = (self.body.len() + FRAMING) as u32;
        let body = self.body.as_slice().into();
        let block = RawBlock { type_: ENHANCED_PACKET_BLOCK, initial_len: length, body, trailer_len: length };
        self.blocks.write_raw_block(&block).map_err(failed)?;
        Ok(())
    }
}

/// The direction, encoded as the option `epb_flags`.
const fn flags(direction: Direction) -> Option<u32> {
    match direction {
        Direction::Unknown => None,
        Direction::Rx => Some(1),
        Direction::Tx => Some(2),
    }
}

impl Writer for PcapngWriter {
    fn write(&mut self, record: &Record, channels: &Channels) -> Result<(), WriteError> {
        self.losses.count_any(Loss::of_utc(self.time_base));
        let interface = self.interface(record, channels)?;
        match record.comment() {
            None => self.write_usual_packet(record, interface)?,
            Some(_) => self.write_packet(record, interface)?,
        }
        self.pass_on()
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{CanId, ChannelId, Flags, Frame, Timestamp, XlHeader};
    use proptest::prelude::*;

    fn writer() -> PcapngWriter {
        let header = SectionHeaderBlock { endianness: Endianness::Little, ..SectionHeaderBlock::default() };
        let mut writer = PcapngWriter {
            sink: Box::new(std::io::sink()),
            blocks: PcapNgWriter::with_section_header(Vec::new(), header).unwrap(),
            interfaces: Vec::new(),
            body: Vec::new(),
            time_base: TimeBase::Utc,
            losses: Losses::default(),
        };
        let mut channels = Channels::new();
        let channel = channels.intern("can0");
        let frame = Frame::new(CanId::standard_masked(1), &[]).unwrap();
        writer.interface(&Record::new(Timestamp::ZERO, channel, frame), &channels).unwrap();
        writer.blocks.get_mut().clear();
        writer
    }

    fn record() -> impl Strategy<Value = Record> {
        let data = prop::collection::vec(any::<u8>(), 64);
        (0..4_u8, any::<u64>(), 0..0x800_u32, data, 0..=8_usize).prop_map(|(kind, nanos, id, data, length)| {
            let (time, channel, id) = (Timestamp(nanos), ChannelId(0), CanId::standard_masked(id));
            match kind {
                0 => Record::new(time, channel, Frame::remote(id, length as u8).unwrap()),
                1 => {
                    Record::fd(time, channel, id, Flags::from_bits(1), &data[..usize::from(Frame::FD_LENGTHS[length])])
                        .unwrap()
                }
                2 => Record::xl(time, channel, id, XlHeader::default(), &data[..=7 * length]).unwrap(),
                _ => Record::new(time, channel, Frame::new(id, &data[..length]).unwrap()),
            }
        })
    }

    proptest! {
        #[test]
        fn a_usual_packet_is_written_as_the_crate_writes_it(record in record(), direction in 0..3_u8) {
            let direction = [Direction::Unknown, Direction::Rx, Direction::Tx][usize::from(direction)];
            let record = record.with_direction(direction);
            let (mut usual, mut whole) = (writer(), writer());
            usual.write_usual_packet(&record, 0).unwrap();
            whole.write_packet(&record, 0).unwrap();
            prop_assert_eq!(usual.blocks.get_ref(), whole.blocks.get_ref());
        }
    }
}
