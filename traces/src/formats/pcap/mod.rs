//! pcap, tcpdump's format, with CAN frames in its packets (see [`socketcan`](super::socketcan)).
//!
//! ```text
//! file header     magic, version 2.4, time zone (unused), accuracy (unused), snapshot length, link type
//! packet header   seconds, fraction, captured length, original length; then the captured bytes
//! ```
//!
//! The crate pcap-file reads and writes the headers; this module adds the frames in the packets and the handling of
//! damaged files. Pitfalls: the upper half of the link type field is not part of the link type (it may hold the length
//! of a frame check sequence); a snapshot length of 0 means no limit, but the crate refuses it in its checked packets,
//! so this module reads the raw ones; a packet whose captured length is below its original length was cut.
//!
//! Nothing in the file marks the beginning of a packet. So after a damaged packet, the next header must be plausible;
//! otherwise the next packet is searched for, byte by byte. A packet is accepted if its lengths fit each other and the
//! link type, its time is near the last one, its frame is readable, and another plausible header or the end of the file
//! follows.
//!
//! The format names no channel: all frames are on [`CHANNEL`], except with SLL2, where the index of the interface
//! distinguishes channels (`if5`).

mod reader;
mod writer;

pub(crate) use reader::{open, sniff};
pub(crate) use writer::create;

/// Limit of a packet in tcpdump and Wireshark. A longer one has a damaged length.
const LONGEST: u32 = 262_144;
/// The channel of all frames: SocketCAN's usual name of the only bus.
pub(crate) const CHANNEL: &str = "can0";
