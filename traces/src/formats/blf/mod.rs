//! BLF, Vector's binary logging format, as CANoe, CANalyzer, loggers and python-can write it. Little-endian.
//!
//! ```text
//! file header   "LOGG", header size (32 bits), application and versions (8 x 8), file size (64), uncompressed size
//!               (64), objects (32), objects read (32), start and end of the measurement (8 x 16 each)
//! objects       "LOBJ", header size (16), header version (16), object size (32), type (32); then by the header's
//!               version its flags and time stamp; then the body
//! ```
//!
//! Most objects stand in log containers (type 10), deflated (zlib) or plain. The containers' contents are one stream:
//! **an object may begin in one container and end in the next.** Between objects are up to three bytes of filling, or
//! not, as the writer liked; so the next object is looked for by its signature.
//!
//! Read are the types 1 and 86 (CAN message), 100 and 101 (CAN FD message, which may hold a classical frame), 2, 73 and
//! 104 (error frames) and 126 (events lost by the recorder). Others that are known are passed over: they are no CAN
//! frames. An object of an unknown type is reported, and so is the end of a file in which there are fewer objects than
//! its header says. (It does not count the containers, nor type 115.) What can't be seen is an object in a plain
//! container whose type became another known one.
//!
//! The start of the measurement is in local time whose zone the file does not tell. Channels are numbered from 1; their
//! names are these numbers.

mod container;
mod object;
mod reader;

pub(crate) use reader::{open, sniff};
