//! The simulated devices against their manuals: every printed frame, every table of objects, every quirk.

// `cfg(test)` says nothing new here, but clippy tells by it where a test may unwrap.
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
