//! Every rendering of decoded traffic and test results.
//!
//! - [`answers`]: the table of allowed answers;
//! - [`catalogue_page`]: all cases, as a page;
//! - [`comparison`]: what changed between two results of a conformance run;
//! - [`conformance`]: the reports of a conformance run;
//! - [`decode`]: frames, one line or one JSON object each;
//! - [`descriptions`]: what was wrong in device descriptions;
//! - [`diagnosis`]: what was wrong in a capture;
//! - [`document`]: what a report says, and its forms: text, Markdown, HTML, JUnit;
//! - [`events`]: what the frames brought about, one line or one JSON object each;
//! - [`escape`]: what comes off a bus or out of a file is hostile; every rendering goes through here.
//! - [`fleet`]: what a lake of captures and results tells;
//! - [`fuzz`]: the reports of a run of the fuzzer;
//! - [`history`]: which case was how in which release;
//! - [`provenance`]: where a result comes from;
//! - [`quality`]: what captures hold and lack;
//! - [`results`]: what the commands print as JSON, as types;
//! - [`selftest`]: which faults the cases detect;
//! - [`signals`]: the values of PDOs as columns over time.

#![warn(clippy::disallowed_methods)]
#![allow(missing_docs, reason = "an internal crate: where the name says it all, there is no comment")]

pub mod answers;
pub mod ascii;
pub mod catalogue_page;
mod color;
pub mod comparison;
pub mod conformance;
pub mod decode;
pub mod descriptions;
pub mod diagnosis;
pub mod document;
pub mod escape;
pub mod events;
pub mod fleet;
pub mod fuzz;
pub mod history;
mod page;
mod page_text;
pub mod provenance;
mod push;
pub mod quality;
pub mod results;
pub mod selftest;
pub mod signals;
mod table;
pub mod time;
