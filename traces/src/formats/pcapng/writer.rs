//! Writes pcapng: one section, little-endian, one interface per channel with its name, times in nanoseconds.

use super::block::{
    BYTE_ORDER_MAGIC, ENHANCED_PACKET, EPB_FLAGS, FRAMING, IF_NAME, IF_TSRESOL, INTERFACE_DESCRIPTION, SECTION_HEADER,
    SHB_USERAPPL,
};
use crate::formats::socketcan;
use crate::{Channels, Direction, Loss, Losses, Record, TimeBase, WriteError, WriteOptions, Writer};
use std::io::Write;

struct PcapngWriter {
    sink: Box<dyn Write>,
    /// By channel: its interface, once it was described.
    interfaces: Vec<Option<u32>>,
    described: u32,
    /// The block under way.
    block: Vec<u8>,
    time_base: TimeBase,
    losses: Losses,
}

pub(crate) fn create(sink: Box<dyn Write>, options: &WriteOptions) -> Result<Box<dyn Writer>, WriteError> {
    let mut writer = PcapngWriter {
        sink,
        interfaces: Vec::new(),
        described: 0,
        block: Vec::new(),
        time_base: options.time_base,
        losses: Losses::default(),
    };
    writer.begin(SECTION_HEADER);
    writer.put(&BYTE_ORDER_MAGIC.to_le_bytes());
    writer.put(&[1, 0, 0, 0]);
    // The section's length is not known.
    writer.put(&(-1i64).to_le_bytes());
    writer.option(SHB_USERAPPL, b"canvass");
    writer.end()?;
    Ok(Box::new(writer))
}

impl PcapngWriter {
    fn begin(&mut self, kind: u32) {
        self.block.clear();
        self.put(&kind.to_le_bytes());
        self.put(&[0; 4]);
    }

    fn put(&mut self, bytes: &[u8]) {
        self.block.extend_from_slice(bytes);
    }

    fn pad(&mut self) {
        self.block.resize(self.block.len().next_multiple_of(4), 0);
    }

    /// An option. The end of a block's options is four zero bytes, which may be absent.
    fn option(&mut self, code: u16, value: &[u8]) {
        let value = &value[..value.len().min(usize::from(u16::MAX))];
        self.put(&code.to_le_bytes());
        self.put(&(value.len() as u16).to_le_bytes());
        self.put(value);
        self.pad();
    }

    fn end(&mut self) -> Result<(), WriteError> {
        // A block holds one frame, or one name of at most 64 KiB.
        let length = ((self.block.len() + 4) as u32).to_le_bytes();
        self.block[4..8].copy_from_slice(&length);
        self.put(&length);
        debug_assert!(self.block.len() >= FRAMING);
        Ok(self.sink.write_all(&self.block)?)
    }

    /// The interface of a record's channel, described when its first frame comes.
    fn interface(&mut self, record: &Record, channels: &Channels) -> Result<u32, WriteError> {
        let at = usize::from(record.channel.0);
        if let Some(Some(number)) = self.interfaces.get(at) {
            return Ok(*number);
        }
        self.begin(INTERFACE_DESCRIPTION);
        self.put(&socketcan::WRITTEN_LINK_TYPE.to_le_bytes());
        self.put(&[0; 6]);
        self.option(IF_NAME, channels.name(record.channel).as_bytes());
        self.option(IF_TSRESOL, &[9]);
        self.put(&[0; 4]);
        self.end()?;
        let number = self.described;
        self.described += 1;
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
        let interface = self.interface(record, channels)?;
        let nanos = record.timestamp.nanos();
        self.begin(ENHANCED_PACKET);
        self.put(&interface.to_le_bytes());
        self.put(&((nanos >> 32) as u32).to_le_bytes());
        self.put(&(nanos as u32).to_le_bytes());
        self.put(&[0; 8]);
        let start = self.block.len();
        socketcan::encode(record, &mut self.block);
        let length = ((self.block.len() - start) as u32).to_le_bytes();
        self.block[start - 8..start - 4].copy_from_slice(&length);
        self.block[start - 4..start].copy_from_slice(&length);
        self.pad();
        let flags: u32 = match record.direction {
            Direction::Unknown => 0,
            Direction::Rx => 1,
            Direction::Tx => 2,
        };
        if flags != 0 {
            self.option(EPB_FLAGS, &flags.to_le_bytes());
            self.put(&[0; 4]);
        }
        self.end()
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
