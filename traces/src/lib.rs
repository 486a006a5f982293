//! CAN frames and capture files, in and out.
//!
//! A capture file, whatever its format, becomes a stream of [`Record`]s: a [`Frame`], when it was seen, on
//! which channel, in which direction, and where in the file it stands. What can't be read becomes a located
//! [`Damage`], and reading goes on.
//!
//! One file per format; each describes its grammar and what is easily got wrong in its module's docs.

mod bit_length;
mod capture;
mod channel;
mod channel_numbers;
mod compression;
mod damage;
mod digits;
mod formats;
mod frame;
mod grammar;
mod id;
mod limited;
mod lines;
mod local_time;
mod merge;
mod notation;
pub mod quality;
mod reader;
mod record;
mod recording;
mod source;
mod text_writer;
mod time;
mod writer;

pub use bit_length::{INTERMISSION, bit_length};
pub use capture::{Capture, OpenError, ReadOptions};
pub use channel::{ChannelId, Channels};
pub use damage::{Damage, DamageKind};
pub use formats::Format;
pub use formats::socketcan::{from_socket, to_socket};
pub use frame::{ErrorClass, Flags, Frame, FrameKind};
pub use id::CanId;
pub use merge::{Merge, Naming};
pub use notation::{FrameSyntax, Notation, parse_frame};
pub use quality::Quality;
pub use reader::{Reader, TimeBase};
pub use record::{Direction, Long, Place, Record, XlHeader};
pub use recording::{Compression, Recording};
pub use source::{Source, SourceError};
pub use time::{Duration, Timestamp};
pub use writer::{ChunkCompression, Loss, Losses, WriteError, WriteOptions, Writer};
