//! Device descriptions: EDS, DCF, XDD and XDC.
#![no_main]

use canvass_analyzer::dictionary::DeviceDescription;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    if let Ok(description) = DeviceDescription::read(bytes) {
        for problem in &description.problems {
            assert!(!problem.to_string().is_empty());
        }
    }
});
