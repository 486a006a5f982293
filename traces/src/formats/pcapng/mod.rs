//! pcapng, Wireshark's format, with CAN frames in its packets (see [`socketcan`](super::socketcan)).
//!
//! A file is a row of blocks, each with its type, its length, its body, and its length again. A section header
//! block begins a section; then come, in any order, interface descriptions and packets.
//!
//! Easily got wrong: **the byte order and the list of interfaces begin anew in every section**; each interface has
//! its own link type, time resolution (`if_tsresol`, a power of ten or of two) and offset of whole seconds
//! (`if_tsoffset`); simple packet blocks have no time; a section's length may be -1. What the recorder lost stands in
//! the packets (`epb_dropcount`) and in interface statistics (`isb_ifdrop`, `isb_osdrop`).
//!
//! An interface without a name (`if_name`) is the channel `can` with its number, from 0.
//!
//! The blocks are read and written by the crate pcap-file. What it does not know is here:
//!
//! - the frames in the packets;
//! - times: it refuses a resolution finer than a nanosecond and 2^-29 s, and a packet whose time it can't hold. It is told that
//!   every interface counts nanoseconds, so that the times that it gives are the numbers of the file;
//! - options: one that it does not like makes it refuse the whole block, an interface with all its packets. The options
//!   of interfaces are read here, and a packet is read again without them;
//! - damage: after a block whose lengths can't be right the next one is searched for, by its type and its two equal
//!   lengths. A block of a type that is not known is reported: it may be a packet whose type is damaged.

mod block;
mod interface;
mod packets;
mod reader;
mod usual;
mod writer;

pub(crate) use reader::{open, sniff};
pub(crate) use writer::create;
