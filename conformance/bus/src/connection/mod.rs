//! Connections to adapters and other programs: a serial port, TCP or UDP.

pub mod arrival;
pub mod link;
pub mod way;

/// Interval between two attempts to open a lost connection again.
pub const RETRY: std::time::Duration = std::time::Duration::from_millis(200);
