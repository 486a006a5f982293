//! pcapng, Wireshark's format, with CAN frames in its packets (see [`socketcan`](super::socketcan)).
//!
//! A file is a row of blocks, each with its type, its length, its body, and its length again. A section header
//! block begins a section; then come, in any order, interface descriptions and packets.
//!
//! Easily got wrong: **the byte order and the list of interfaces begin anew in every section**; each interface has
//! its own link type, time resolution (`if_tsresol`, a power of ten or of two) and offset of whole seconds
//! (`if_tsoffset`); simple packet blocks have no time; a section's length may be -1; unknown blocks are passed over.
//! What the recorder lost stands in the packets (`epb_dropcount`) and in interface statistics (`isb_ifdrop`,
//! `isb_osdrop`).
//!
//! An interface without a name (`if_name`) is the channel `can` with its number, from 0.

mod block;
mod interface;
mod reader;
mod usual;
mod writer;

pub(crate) use reader::{open, sniff};
pub(crate) use writer::create;
