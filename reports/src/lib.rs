//! Every rendering of decoded traffic and test results.
//!
//! - [`answers`]: the table of allowed answers;
//! - [`catalogue_page`]: all cases, as a page;
//! - [`codes`]: the meaning of error codes and abort codes;
//! - [`comparison`]: the changes between two results of a conformance run;
//! - [`conformance`]: the reports of a conformance run;
//! - [`decode`]: frames, one line or one JSON object each;
//! - [`descriptions`]: the findings in device descriptions;
//! - [`diagnosis`]: the findings in a capture;
//! - [`document`]: the content of a report, and its forms: text, Markdown, HTML, JUnit;
//! - [`events`]: events that frames caused, one line or one JSON object each;
//! - [`escape`]: escaping of hostile texts from a bus or a file, for every rendering;
//! - [`fleet`]: the results of a lake of captures and test results;
//! - [`fuzz`]: the reports of a run of the fuzzer;
//! - [`history`]: the verdicts of cases over the releases;
//! - [`plot`]: values of PDOs as curves over time, in the terminal or as a picture;
//! - [`provenance`]: the origin of a result;
//! - [`quality`]: the quality of captures;
//! - [`results`]: the types of the commands' JSON output;
//! - [`selftest`]: the faults that the cases detect;
//! - [`signals`]: the values of PDOs as columns over time.

#![warn(clippy::disallowed_methods)]
#![allow(missing_docs, reason = "an internal crate: where the name says it all, there is no comment")]

pub mod answers;
pub mod ascii;
pub mod catalogue_page;
pub mod codes;
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
pub mod plot;
pub mod provenance;
mod push;
pub mod quality;
pub mod results;
pub mod selftest;
pub mod signals;
mod table;
pub mod time;
pub mod waivers;
