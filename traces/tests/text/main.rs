//! The text formats, read and written through the public interface.

mod asc;
mod candump_console;
mod candump_log;
mod csv;
mod frames;
mod notation;
mod samples;
mod trc;
