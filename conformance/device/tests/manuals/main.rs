//! Compares the simulated devices with their manuals: every printed frame, every table of objects, every quirk.

// All code here is test code; the attribute tells clippy that it may unwrap.
#![cfg(test)]

mod bench;
mod dictionary;
mod emergencies;
mod hostile;
mod lika;
mod lmt;
mod printed;
mod replay;
mod tr;
