//! CAN frames and capture files, in and out.
//!
//! A capture file of any format becomes a stream of [`Record`]s: a [`Frame`] with its time, channel, direction and
//! place in the file. An unreadable part becomes a located [`Damage`], and reading goes on.
//!
//! ```
//! use canvass_traces::{Capture, ReadOptions, Reader, Source};
//!
//! let log = "(1700000000.000000) can0 701#05\n(1700000000.100000) can0 70\n";
//! let mut capture = Capture::from_source("a.log", Source::from_bytes(log), &ReadOptions::default())?;
//! let (mut frames, mut damages) = (Vec::new(), Vec::new());
//! while let Some(next) = capture.next() {
//!     match next {
//!         Ok(record) => frames.push(format!("{} {}", capture.channels().name(record.channel), record.frame)),
//!         Err(damage) => damages.push(damage.place.number),
//!     }
//! }
//! assert_eq!(frames, ["can0 701#05"]);
//! assert_eq!(damages, [2], "the second line is damaged");
//! # Ok::<(), canvass_traces::OpenError>(())
//! ```
//!
//! A [`Writer`] writes records in another format, and counts the properties that the format can't hold:
//!
//! ```
//! use canvass_traces::{Channels, Format, WriteOptions, parse_frame};
//!
//! let mut channels = Channels::new();
//! let mut record = parse_frame("123##5112233")?;
//! record.channel = channels.intern("can0");
//! let mut writer = Format::Pcapng.create(Box::new(std::io::sink()), &WriteOptions::default())?;
//! writer.write(&record, &channels)?;
//! writer.finish()?;
//! assert!(writer.losses().is_empty());
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! Each format has its own file, whose module docs describe the grammar and the pitfalls of the format.

#![warn(clippy::disallowed_methods)]

mod bit_length;
mod capture;
mod channel;
mod channel_numbers;
mod columns;
mod compression;
mod damage;
mod digits;
mod encoding;
mod format;
mod formats;
mod frame;
mod grammar;
pub mod hex;
mod id;
mod limited;
mod lines;
mod local_time;
mod merge;
mod notation;
mod packed;
pub mod quality;
mod reader;
mod record;
mod recording;
mod skip_set;
pub mod small_file;
mod source;
mod text_writer;
mod time;
mod writer;

pub use bit_length::{INTERMISSION, bit_length};
pub use capture::{Capture, OpenError};
pub use channel::{ChannelId, Channels};
pub use columns::{Columns, ColumnsError};
pub use damage::{Damage, DamageKind};
pub use format::Format;
pub use formats::pasted::{Question, Unread};
pub use formats::socketcan::{from_socket, to_socket};
pub use frame::{ErrorClass, Flags, Frame, FrameKind};
pub use id::CanId;
pub use merge::{Merge, Naming};
pub use notation::{FrameSyntax, Notation, parse_frame};
pub use quality::Quality;
pub use reader::{ReadOptions, Reader, TimeBase};
pub use record::{Direction, Long, Place, Record, XlHeader};
pub use recording::{Compression, Recording};
pub use skip_set::SkipSet;
pub use source::{Source, SourceError};
pub use time::{Duration, Timestamp};
pub use writer::{ChunkCompression, Loss, Losses, WriteError, WriteOptions, Writer};
