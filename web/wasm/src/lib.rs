//! The libraries of canvass, as a page in a browser calls them.
//!
//! All work is done in steps, so that the page's worker can answer between them: [`Page`](api::Page) is what it sees.
//! Files are read where they lie, a piece at a time, by a function of the page.

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
