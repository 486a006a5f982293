//! Every rendering of decoded traffic and test results.
//!
//! - [`conformance`]: the reports of a conformance run;
//! - [`decode`]: frames, one line or one JSON object each;
//! - [`diagnosis`]: what was wrong in a capture;
//! - [`events`]: what the frames brought about, one line or one JSON object each;
//! - [`escape`]: what comes off a bus or out of a file is hostile; every rendering goes through here.
//! - [`quality`]: what captures hold and lack;
//! - [`signals`]: the values of PDOs as columns over time.

pub mod conformance;
pub mod decode;
pub mod diagnosis;
pub mod escape;
pub mod events;
mod page;
mod push;
pub mod quality;
pub mod signals;
pub mod time;
