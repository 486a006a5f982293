//! MF4, the measurement data format 4 of ASAM, with the frames of a bus as "ASAM MDF bus logging" stores them: loggers,
//! CANoe, asammdf and python-can write such files. Little-endian.
//!
//! ```text
//! identification   "MDF     ", or "UnFinMF " if the recorder did not finish the file; version, program; 64 bytes
//! blocks           "##" and two letters, reserved (32 bits), length (64), number of links (64), links (64 each), data
//!
//! HD               the header: start of the measurement, link to the first DG
//! DG               a data group: its records, link to its first CG
//! CG               a channel group: all records with the same channels, link to the first CN
//! CN               a channel: the place of a value in the record
//! TX               the name of a channel
//! CC               the conversion of a channel
//! DT, DZ           records, plain or deflated
//! SD               values of variable length
//! DL, HL           the list of the blocks DT, DZ and SD of a group
//! ```
//!
//! A channel group holds frames if it has a channel `CAN_DataFrame`, `CAN_RemoteFrame` or `CAN_ErrorFrame`. Further channels,
//! such as `CAN_DataFrame.ID`, are the fields of the frame. The reader skips groups of other buses and of measured signals,
//! and reports a file that has only these. If a data group has several channel groups, each record begins with the number
//! of its channel group.
//!
//! A file that was not finished is read to its end. Links lead anywhere in the file, so that it is read as a whole, at
//! most [`LARGEST`](reader::LARGEST) bytes. The frames of all groups are put in the order of their times.

mod block;
mod channel;
mod conversion;
mod data;
mod group;
#[cfg(not(target_family = "wasm"))]
mod layout;
mod reader;
mod records;
#[cfg(test)]
mod tests;
#[cfg(not(target_family = "wasm"))]
mod writer;

pub(crate) use reader::{open, sniff};
#[cfg(not(target_family = "wasm"))]
pub(crate) use writer::create;
