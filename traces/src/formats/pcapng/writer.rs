//! Writes pcapng: one section, little-endian, one interface per channel with its name, times in nanoseconds.

use crate::formats::socketcan;
use crate::{Channels, Direction, Format, Loss, Losses, Record, TimeBase, WriteError, WriteOptions, Writer};
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

/// The longest name that an option can hold, in bytes; a channel's has no more.
const LONGEST_NAME: usize = u16::MAX as usize;

struct PcapngWriter {
    sink: Box<dyn Write>,
    /// Writes into memory, from where each block goes to the sink as a whole.
    blocks: PcapNgWriter<Vec<u8>>,
    /// By channel: its interface, once it was described.
    interfaces: Vec<Option<u32>>,
    /// The frame under way.
    frame: Vec<u8>,
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
        frame: Vec::new(),
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

    /// The interface of a record's channel, described when its first frame comes.
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
}

impl Writer for PcapngWriter {
    fn write(&mut self, record: &Record, channels: &Channels) -> Result<(), WriteError> {
        self.losses.count_any(Loss::of_utc(self.time_base));
        let interface_id = self.interface(record, channels)?;
        self.frame.clear();
        socketcan::encode(record, &mut self.frame);
        let mut options = match record.direction {
            Direction::Unknown => Vec::new(),
            Direction::Rx => vec![EnhancedPacketOption::Flags(1)],
            Direction::Tx => vec![EnhancedPacketOption::Flags(2)],
        };
        options.extend(
            record.comment().map(|comment| EnhancedPacketOption::Common(CommonOption::Comment(comment.into()))),
        );
        let packet = EnhancedPacketBlock {
            interface_id,
            timestamp: Duration::from_nanos(record.timestamp.nanos()),
            // At most a CAN XL frame.
            original_len: self.frame.len() as u32,
            data: self.frame.as_slice().into(),
            options,
        };
        self.blocks.write_pcapng_block(packet).map_err(failed)?;
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
