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
//! The crate mcap writes the files, and its parser (`parse_record`) reads the records that describe a file. Its readers
//! (`LinearReader`, `MessageStream`, the sans-io ones alike) can't serve here, for they are for files that are whole:
//!
//! - an error is their last event: after a damaged chunk, or one whose checksum is wrong, they don't go on;
//! - with the checksum before the messages (`prevalidate_chunk_crcs`) they give nothing of a chunk that the end of the
//!   file cuts, without it they give messages of a chunk whose checksum then proves wrong;
//! - a record longer than their limit is an error too, and not passed over as an attachment should be;
//! - they don't tell where a record stands.
//!
//! So the framing of records and chunks is read here. A record of another kind is passed over where such a record may
//! stand and its lengths fit; anything else is reported, and so are fewer messages than the file's statistics tell.
//! Behind a record whose length is damaged nothing tells where the next one begins: the rest is reported as cut.
//!
//! Easily got wrong: a file without footer (power cut, full disk) is still a good one as far as it goes; CDR aligns
//! from after its 4-byte header; bytes beyond the length are left over from earlier frames.

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
