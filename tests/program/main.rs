//! The program, end to end.

mod decode;
mod hostile;
mod running;
