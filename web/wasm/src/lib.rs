//! The libraries of canvass, for a page in a browser.
//!
//! All work is done in steps, so that the page's worker can answer between them; the worker uses only
//! [`Page`](api::Page). A function of the page reads the user's files, a piece at a time.

#![warn(clippy::disallowed_methods)]

pub mod api;
pub mod descriptions;
pub mod export;
pub mod file;
pub mod host;
pub mod input;
pub mod opening;
pub mod plots;
pub mod provenance;
pub mod results;
pub mod trace;
pub mod trial;
