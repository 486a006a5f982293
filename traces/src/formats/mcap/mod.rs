//! MCAP, the recording format of ROS 2 and Foxglove, with CAN frames as messages.
//!
//! A file is a row of records between two magic numbers: schemas, channels (a topic, its encoding and schema),
//! messages, and chunks, which hold such records compressed (zstd, lz4) or plain, with a checksum. Behind the
//! end-of-data record stands a summary, which is not needed, and the footer.
//!
//! There is no standard schema for CAN frames. A channel is recognised by its schema's *fields* (see
//! [`fields`]), whatever the message is called and in any of the encodings cdr, ros1, json and protobuf. The
//! bus is told by the topic: `/can0` and `/can0/fd` both are the channel `can0`.
//!
//! Easily got wrong: a file without footer (power cut, full disk) is still a good one as far as it goes; CDR aligns
//! from behind its 4-byte header; bytes beyond the length are left over from earlier frames.

mod cdr;
mod chunk;
mod fields;
mod json;
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
