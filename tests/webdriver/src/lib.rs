//! Chromium, as the tests of the pages and `cargo xtask` use it: a window with one page, whose methods block until the
//! browser has answered, and panic with what was asked and what came instead.
//!
//! The protocol is that of `fantoccini`. What is of this crate: how chromedriver is started, what the browser is told not to
//! do, the commands that only Chromium has, and the check that a page was quiet. All but addresses stands behind the feature
//! `client`.

// Who calls this is a test, or a tool that can't go on without the browser.
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
