//! MF4, the measurement data format 4 of ASAM, with the frames of a bus as "ASAM MDF bus logging" stores them: loggers,
//! CANoe, asammdf and python-can write such files. Little-endian.
//!
//! ```text
//! identification   "MDF     " or, if the recorder did not finish the file, "UnFinMF "; version, program; 64 bytes
//! blocks           "##" and two letters, reserved (32 bits), length (64), number of links (64), links (64 each), data
//! HD               header: start of the measurement; links to
//! DG               data groups, each with its records and with links to
//! CG               channel groups: the records of one kind; with links to
//! CN               channels: the place of a value in the record; CC: its conversion, TX: its name
//! DT, DZ, DL, HL   records: plain, deflated, and lists of both; SD: values of variable length
//! ```
//!
//! Frames are the channel groups with a channel `CAN_DataFrame`, `CAN_RemoteFrame` or `CAN_ErrorFrame`, whose members
//! are channels such as `CAN_DataFrame.ID`. Groups of other buses and of measured signals are skipped; a file that has
//! only these is reported. Records of a data group with several channel groups begin with the number of their group.
//!
//! A file that was not finished is read to its end. Links lead anywhere in the file, so that it is read as a whole, at
//! most [`LARGEST`](reader::LARGEST) bytes. The frames of all groups are put in the order of their times.

mod block;
mod channel;
mod conversion;
mod data;
mod group;
mod reader;
#[cfg(test)]
mod tests;

pub(crate) use reader::{open, sniff};
