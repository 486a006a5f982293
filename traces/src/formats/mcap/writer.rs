//! Writes MCAP: `can_msgs/msg/Frame` and, for CAN FD, `ros2_socketcan_msgs/msg/FdFrame`, as ROS 2 records them.

use super::topic;
use crate::packed;
use crate::{
    ChannelId, Channels, Direction, Flags, Format, Loss, Losses, Record, TimeBase, WriteError, WriteOptions, Writer,
};
use mcap::records::{MessageHeader, Metadata};
use mcap::write::NoSeek;
use std::collections::{BTreeMap, HashMap};
use std::io::Write;

const HEADER: &str = "================================================================================\n\
    MSG: std_msgs/Header\nbuiltin_interfaces/Time stamp\nstring frame_id\n\
    ================================================================================\n\
    MSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n";
const FRAME: &str =
    "std_msgs/Header header\nuint32 id\nbool is_rtr\nbool is_extended\nbool is_error\nuint8 dlc\nuint8[8] data\n";
const FD_FRAME: &str =
    "std_msgs/Header header\nuint32 id\nbool is_extended\nbool is_error\nuint8 len\nuint8[<=64] data\n";

/// The name of the metadata record with the comment of the following message, and of the value in it.
pub(crate) const COMMENT: &str = "comment";

struct McapWriter {
    mcap: mcap::Writer<NoSeek<Box<dyn Write>>>,
    frame_schema: u16,
    fd_schema: u16,
    /// The number of each channel in the file, by channel and whether its frames are CAN FD.
    channels: HashMap<(ChannelId, bool), u16>,
    sequence: u32,
    /// The message being encoded.
    message: Vec<u8>,
    finished: bool,
    time_base: TimeBase,
    losses: Losses,
}

fn failed(error: mcap::McapError) -> WriteError {
    match error {
        mcap::McapError::Io(error) => WriteError::Io(error),
        other => WriteError::Format { format: Format::Mcap, reason: other.to_string() },
    }
}

pub(crate) fn create(sink: Box<dyn Write>, options: &WriteOptions) -> Result<Box<dyn Writer>, WriteError> {
    let time_base = options.time_base;
    // The sink may be a pipe, which can't seek.
    let mcap_options = packed::mcap_options(options.chunk_compression)
        .profile("ros2")
        .library(concat!("canvass ", env!("CARGO_PKG_VERSION")))
        .use_chunks(!options.live)
        .disable_seeking(true);
    let mut mcap = mcap_options.create(NoSeek::new(sink)).map_err(failed)?;
    let mut schema =
        |name, text: &str| mcap.add_schema(name, "ros2msg", format!("{text}{HEADER}").as_bytes()).map_err(failed);
    let frame_schema = schema("can_msgs/msg/Frame", FRAME)?;
    let fd_schema = schema("ros2_socketcan_msgs/msg/FdFrame", FD_FRAME)?;
    let (channels, losses) = (HashMap::new(), Losses::default());
    let message = Vec::new();
    Ok(Box::new(McapWriter {
        mcap,
        frame_schema,
        fd_schema,
        channels,
        sequence: 0,
        message,
        finished: false,
        time_base,
        losses,
    }))
}

impl McapWriter {
    /// The file's channel for a record's channel. A channel is declared before its first frame.
    fn channel(&mut self, record: &Record, channels: &Channels) -> Result<u16, WriteError> {
        let key = (record.channel, record.frame.is_fd());
        if let Some(&channel) = self.channels.get(&key) {
            return Ok(channel);
        }
        let schema = if key.1 { self.fd_schema } else { self.frame_schema };
        let topic = topic::topic(channels.name(record.channel), key.1);
        let channel = self.mcap.add_channel(schema, &topic, "cdr", &BTreeMap::new()).map_err(failed)?;
        self.channels.insert(key, channel);
        Ok(channel)
    }

    /// Encodes the record in CDR, little-endian. Every SocketCAN bridge writes "can" as frame_id.
    fn encode(&mut self, record: &Record) {
        let frame = &record.frame;
        let nanos = record.timestamp.nanos();
        // A time that does not fit is left out; the reader then uses the log time.
        let (seconds, nanoseconds) = match i32::try_from(nanos / 1_000_000_000) {
            Ok(seconds) => (seconds, (nanos % 1_000_000_000) as u32),
            Err(_) => (0, 0),
        };
        let message = &mut self.message;
        message.clear();
        message.extend_from_slice(&[0, 1, 0, 0]);
        message.extend_from_slice(&seconds.to_le_bytes());
        message.extend_from_slice(&nanoseconds.to_le_bytes());
        message.extend_from_slice(b"\x04\0\0\0can\0");
        message.extend_from_slice(&frame.id().raw().to_le_bytes());
        let extended = u8::from(frame.id().is_extended() && !frame.is_error());
        let error = u8::from(frame.is_error());
        // The message types hold at most 64 bytes.
        let length = frame.len() as u8;
        if frame.is_fd() {
            // One byte of padding aligns the length of the sequence.
            message.extend_from_slice(&[extended, error, length, 0]);
            message.extend_from_slice(&u32::from(length).to_le_bytes());
            message.extend_from_slice(record.data());
        } else {
            message.extend_from_slice(&[u8::from(frame.is_remote()), extended, error, length]);
            message.extend_from_slice(&frame.bytes());
        }
    }

    fn count_losses(&mut self, record: &Record) {
        let frame = &record.frame;
        let flags = frame.flags();
        if record.direction != Direction::Unknown {
            self.losses.count(Loss::Direction);
        }
        if frame.is_fd() && (flags.contains(Flags::BRS) || flags.contains(Flags::ESI)) {
            self.losses.count(Loss::FdFlags);
        }
        if !frame.is_fd() && frame.dlc() > 8 {
            self.losses.count(Loss::RawDlc);
        }
        self.losses.count_any(Loss::of_utc(self.time_base));
    }
}

impl Writer for McapWriter {
    fn write(&mut self, record: &Record, channels: &Channels) -> Result<(), WriteError> {
        if self.finished {
            let reason = "write after finish".to_owned();
            return Err(WriteError::Format { format: Format::Mcap, reason });
        }
        if record.frame.is_xl() {
            self.losses.count(Loss::Frame);
            return Ok(());
        }
        self.count_losses(record);
        if let Some(comment) = record.comment() {
            let metadata = BTreeMap::from([(COMMENT.to_owned(), comment.to_owned())]);
            self.mcap.write_metadata(&Metadata { name: COMMENT.to_owned(), metadata }).map_err(failed)?;
        }
        let channel_id = self.channel(record, channels)?;
        self.encode(record);
        let time = record.timestamp.nanos();
        let header = MessageHeader { channel_id, sequence: self.sequence, log_time: time, publish_time: time };
        self.sequence = self.sequence.wrapping_add(1);
        self.mcap.write_to_known_channel(&header, &self.message).map_err(failed)
    }

    fn flush(&mut self) -> Result<(), WriteError> {
        if self.finished { Ok(()) } else { self.mcap.flush().map_err(failed) }
    }

    fn finish(&mut self) -> Result<(), WriteError> {
        self.finished = true;
        self.mcap.finish().map(|_| ()).map_err(failed)
    }

    fn losses(&self) -> &Losses {
        &self.losses
    }
}
