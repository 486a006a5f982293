//! Chromium for the tests of the pages and for `cargo xtask`: a window with one page. Its methods block until the
//! browser has answered, and panic with the command and the unexpected answer.
//!
//! `fantoccini` speaks the protocol. This crate adds the start of chromedriver, the options of the browser, the
//! commands that only Chromium has, and the check that a page was quiet. Everything except addresses is behind the
//! feature `client`.

// The callers are tests, or tools that can't go on without the browser.
#![cfg_attr(feature = "client", expect(clippy::expect_used, clippy::panic))]

mod address;
#[cfg(feature = "client")]
mod browser;
#[cfg(feature = "client")]
mod chromium;
#[cfg(feature = "client")]
mod driver;
#[cfg(feature = "client")]
mod input;
#[cfg(feature = "client")]
mod memory;
#[cfg(feature = "client")]
mod quiet;
#[cfg(feature = "client")]
mod screen;
#[cfg(feature = "client")]
mod script;

pub use address::url;
#[cfg(feature = "client")]
pub use browser::Browser;
#[cfg(feature = "client")]
pub use screen::Screen;
