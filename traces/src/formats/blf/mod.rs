//! BLF, Vector's binary logging format, which CANoe, CANalyzer, loggers and python-can write. Little-endian.
//!
//! ```text
//! file header   "LOGG", header size (32 bits), application and versions (8 x 8), file size (64), uncompressed size
//!               (64), objects (32), objects read (32), start and end of the measurement (8 x 16 each)
//! objects       "LOBJ", header size (16), header version (16), object size (32), type (32); then by the header's
//!               version its flags and time stamp; then the body
//! ```
//!
//! Most objects are in log containers (type 10), deflated (zlib) or plain. The containers' contents are one stream:
//! **an object may begin in one container and end in the next.** Some writers put up to three bytes of filling between
//! objects, others none; so the reader searches the next object by its signature.
//!
//! The reader decodes the types 1 and 86 (CAN message), 100 and 101 (CAN FD message, which may hold a classical frame),
//! 2, 73 and 104 (error frames) and 126 (events lost by the recorder). It skips other known types, which are no CAN
//! frames, and reports objects of unknown types. At the end of the file it reports if the header counts more objects
//! than the file has. (The header counts neither containers nor type 115.) One damage stays undetected: an object in a
//! plain container whose type became another known one.
//!
//! The writer makes objects of the types 1, 73 and 100, in deflated containers.
//!
//! The start of the measurement is in local time; the file does not give the time zone. Channels are numbered from 1;
//! their names are these numbers.

mod container;
mod object;
mod reader;
#[cfg(not(target_family = "wasm"))]
mod writer;

pub(in crate::formats) use object::{bus_error, classical, fd};
pub(crate) use reader::{open, sniff};
#[cfg(not(target_family = "wasm"))]
pub(crate) use writer::create;
