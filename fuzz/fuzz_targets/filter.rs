//! Filter expressions.
#![no_main]

use canvass_analyzer::filter::Filter;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|text: &str| {
    if let Err(error) = text.parse::<Filter>() {
        assert!(error.column <= text.chars().count() + 1);
        assert!(!error.to_string().is_empty());
    }
});
