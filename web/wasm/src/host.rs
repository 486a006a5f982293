//! Functions of the page for the libraries.

use std::io;

#[cfg(target_family = "wasm")]
mod page {
    use wasm_bindgen::prelude::*;

    #[wasm_bindgen]
    extern "C" {
        /// Reads bytes of a file into `buffer`, from the offset `at` on; returns their number.
        #[wasm_bindgen(js_namespace = canvassHost, catch)]
        pub(super) fn read(file: u32, at: f64, buffer: &mut [u8]) -> Result<u32, JsValue>;

        /// Reports progress to the page: `done` of `all`, and the next step in words.
        #[wasm_bindgen(js_namespace = canvassHost)]
        pub(super) fn progress(done: f64, all: f64, what: &str);

        /// The milliseconds since a fixed time.
        #[wasm_bindgen(js_namespace = canvassHost)]
        pub(super) fn now() -> f64;

        /// Reports to the page why the program stopped.
        #[wasm_bindgen(js_namespace = canvassHost)]
        pub(super) fn stopped(why: &str);
    }
}

/// Reads from a file of the page.
///
/// # Errors
/// If the file is gone, or has changed since it was opened.
#[cfg(target_family = "wasm")]
pub fn read(file: u32, at: u64, buffer: &mut [u8]) -> io::Result<usize> {
    // No file has 2^53 bytes.
    let read = page::read(file, at as f64, buffer);
    let failed = |_| io::Error::other("the browser can't read it any more: was it moved or changed?");
    read.map(|read| (read as usize).min(buffer.len())).map_err(failed)
}

/// Without a page there is no file to read.
///
/// # Errors
/// Always.
#[cfg(not(target_family = "wasm"))]
pub fn read(_: u32, _: u64, _: &mut [u8]) -> io::Result<usize> {
    Err(io::ErrorKind::Unsupported.into())
}

/// Reports the progress to the page.
pub fn progress(done: usize, all: usize, what: &str) {
    #[cfg(target_family = "wasm")]
    page::progress(done as f64, all as f64, what);
    #[cfg(not(target_family = "wasm"))]
    let _ = (done, all, what);
}

/// The milliseconds since a fixed time; always 0 without a page.
pub fn now() -> f64 {
    #[cfg(target_family = "wasm")]
    return page::now();
    #[cfg(not(target_family = "wasm"))]
    0.0
}

/// Reports a panic to the page from now on.
pub fn tell_why_it_stops() {
    #[cfg(target_family = "wasm")]
    std::panic::set_hook(Box::new(|why| page::stopped(&why.to_string())));
}
