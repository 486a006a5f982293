#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| canvass_fuzz::pasted(bytes));
