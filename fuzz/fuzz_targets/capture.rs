//! Captures of every format, recognised by their content.
#![no_main]

use canvass_traces::{Capture, ReadOptions, Source};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    if let Ok(capture) = Capture::from_source("fuzz", Source::from_bytes(bytes), &ReadOptions::default()) {
        for item in capture {
            if let Err(damage) = item {
                assert!(!damage.to_string().is_empty());
            }
        }
    }
});
