//! Captures with known faults: every rule finds its own, with the right node and time, and nothing else is found; and
//! nothing at all is found in healthy traffic.

mod bus;
mod capture;
mod emcy_lss;
mod encoder;
mod healthy;
mod nodes;
mod pdo;
mod sdo;
mod statistics;
mod traffic;
