//! The program, end to end.

mod decode;
mod running;
