//! pcap, tcpdump's format, with CAN frames in its packets (see [`socketcan`](super::socketcan)).
//!
//! ```text
//! file header     magic, version 2.4, time zone (unused), accuracy (unused), snapshot length, link type
//! packet header   seconds, fraction, captured length, original length; then the captured bytes
//! ```
//!
//! The headers are read and written by the crate pcap-file; here is what it does not know: the frames in the packets,
//! and what becomes of a damaged file. Easily got wrong: the upper half of the link type is not part of it (it may
//! tell the length of a frame check sequence); a snapshot length of 0 means none, which the crate refuses in its checked
//! packets, so that the raw ones are read; a packet whose captured length is below its original length was cut.
//!
//! Nothing in the file tells where a packet begins. So after a packet that is damaged the next header must look like
//! one, else the next packet is searched for, byte by byte: lengths that fit each other and the link type, a time near
//! the last one, a readable frame, and again such a header after it, or the end of the file.
//!
//! The format names no channel: all frames are on [`CHANNEL`], but with SLL2 the interface's index tells them
//! apart (`if5`).

mod reader;
mod writer;

pub(crate) use reader::{open, sniff};
pub(crate) use writer::create;

/// Limit of a packet in tcpdump and Wireshark. A longer one has a damaged length.
const LONGEST: u32 = 262_144;
/// The channel of all frames: SocketCAN's usual name of the only bus.
pub(crate) const CHANNEL: &str = "can0";
