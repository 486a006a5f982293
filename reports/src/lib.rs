//! Every rendering of decoded traffic and test results.
//!
//! - [`decode`]: frames, one line or one JSON object each.
//! - [`quality`]: what captures hold and lack.

pub mod decode;
pub mod quality;
