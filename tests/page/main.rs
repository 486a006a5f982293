//! The page with the decoder as WebAssembly, in headless Chromium, as one file from the disk.
//!
//! `cargo xtask web-test` makes the page and runs these tests, which are behind the feature `page`.

#[cfg(test)]
mod access;
#[cfg(test)]
#[path = "../browser/captures.rs"]
#[allow(dead_code)]
mod captures;
#[cfg(test)]
mod diagnosis;
#[cfg(test)]
mod equal;
#[cfg(test)]
mod hostile;
#[cfg(test)]
mod links;
#[cfg(test)]
mod network;
#[cfg(test)]
mod opened;
#[cfg(test)]
mod reading;
#[cfg(test)]
mod trace;
#[cfg(test)]
mod views;
