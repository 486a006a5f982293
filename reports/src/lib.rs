//! Every rendering of decoded traffic and test results.
//!
//! - [`decode`]: frames, one line or one JSON object each.

pub mod decode;
