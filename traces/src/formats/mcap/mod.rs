//! MCAP, the recording format of ROS 2 and Foxglove, with CAN frames as messages.
//!
//! A file is a sequence of records between two magic numbers: schemas, channels (a topic, its encoding and schema),
//! messages, and chunks, which hold such records compressed (zstd, lz4) or plain, with a checksum. After the
//! end-of-data record come a summary, which this reader does not need, and the footer.
//!
//! There is no standard schema for CAN frames. The reader recognises a channel by the *fields* of its schema (see
//! [`fields`]), whatever the name of the message, in each of the encodings cdr, ros1, json and protobuf. The topic
//! determines the bus: `/can0` and `/can0/fd` are both the channel `can0`.
//!
//! The crate mcap writes the files, and its parser (`parse_record`) reads the records that describe a file. Its readers
//! (`LinearReader`, `MessageStream` and the sans-io ones) are unsuitable, because they expect complete files:
//!
//! - an error is their last event: they stop after a damaged chunk, or one whose checksum is wrong;
//! - with the checksum before the messages (`prevalidate_chunk_crcs`) they return nothing of a chunk that the end of
//!   the file cuts; without it they return messages of a chunk whose checksum then proves wrong;
//! - a record longer than their limit is an error too, although a long attachment could be skipped;
//! - they do not give the position of a record.
//!
//! So this module reads the framing of records and chunks. A record of another kind is skipped if it is allowed at its
//! place and its lengths fit; anything else is reported, and so are fewer messages than the file's statistics state.
//! After a record with a damaged length the beginning of the next one is unknown: the rest is reported as cut.
//!
//! Pitfalls: a file without footer (power cut, full disk) is good as far as it goes; CDR aligns from the end of its
//! 4-byte header; bytes beyond the length are remains of earlier frames.

mod cdr;
mod chunk;
mod fields;
mod json;
mod lengths;
mod plan;
mod protobuf;
mod reader;
mod ros1;
mod ros_definition;
mod run;
mod topic;
mod topics;
mod writer;

pub(crate) use reader::{open, sniff};
pub(crate) use writer::create;
