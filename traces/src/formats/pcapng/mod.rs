//! pcapng, Wireshark's format, with CAN frames in its packets (see [`socketcan`](super::socketcan)).
//!
//! A file is a sequence of blocks, each with its type, its length, its body, and its length again. A section header
//! block begins a section; interface descriptions and packets follow in any order.
//!
//! Pitfalls: **the byte order and the list of interfaces begin anew in every section**; each interface has its own link
//! type, time resolution (`if_tsresol`, a power of ten or of two) and offset of whole seconds (`if_tsoffset`); simple
//! packet blocks have no time; a section's length may be -1. Packets (`epb_dropcount`) and interface statistics
//! (`isb_ifdrop`, `isb_osdrop`) tell the number of frames that the recorder lost.
//!
//! An interface without a name (`if_name`) becomes the channel `can` with the number of the interface, from 0.
//!
//! The crate pcap-file reads and writes the blocks. This module adds:
//!
//! - the frames in the packets;
//! - times: the crate refuses a resolution finer than a nanosecond and 2^-29 s, and a packet whose time it can't hold.
//!   This module tells it that every interface counts nanoseconds, so the crate returns the numbers of the file;
//! - options: if one option is invalid for the crate, it refuses the whole block, such as an interface with all its
//!   packets. So this module reads the options of interfaces, and reads a refused packet again without its options;
//! - damage: after a block with impossible lengths the next block is searched for by its type and its two equal
//!   lengths. A block of an unknown type is reported: it may be a packet whose type is damaged.

mod block;
mod interface;
mod packets;
mod reader;
mod usual;
mod writer;

pub(crate) use reader::{open, sniff};
pub(crate) use writer::create;
