//! The pages in a real browser: headless Chromium, driven by chromedriver.
//!
//! `cargo xtask ci` installs both and runs these tests, which are behind the feature `browser`.

#[cfg(test)]
mod captures;
#[cfg(test)]
mod conformance;
#[cfg(test)]
mod description;
#[cfg(test)]
mod diagnosis;
#[cfg(test)]
mod history;
#[cfg(test)]
mod large;
