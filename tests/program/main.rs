//! The program, end to end.

mod decode;
mod diagnose;
mod running;
