//! The text formats, read and written through the public interface.

mod candump_console;
mod candump_log;
mod frames;
mod notation;
