//! The Rust test of a violation works: `conformance/fuzz/tests/reproduced.rs` is written by the fuzzer and passes on
//! the device without the fault.

use canvass_analyzer::NodeId;
use canvass_device::Fault;
use canvass_fuzzer::detection::{Limit, detect};
use canvass_fuzzer::reproducer::{candump, replay, rust_test};
use std::time::Duration;

const FILE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/reproduced.rs");
const FAULT: Fault = Fault::SdoToggleUnchecked;
const SEED: u64 = 7;

/// With `CANVASS_UPDATE=1` the test writes the file.
#[test]
fn the_generated_test_is_current_and_shows_the_fault() {
    let limit = Limit { exchanges: 100_000, time: Duration::from_secs(60) };
    let found = detect(FAULT, SEED, limit).unwrap().found.unwrap().found;
    // The bus has no fault any more, as if the user had fixed the firmware.
    let text = rust_test(&found, "sim:reference-301", NodeId::new(10).unwrap(), SEED);
    if std::env::var_os("CANVASS_UPDATE").is_some() {
        std::fs::write(FILE, &text).unwrap();
    }
    assert_eq!(std::fs::read_to_string(FILE).unwrap(), text, "CANVASS_UPDATE=1 writes it anew");
    let log = candump(&found.sequence);
    let again = replay(&format!("sim:reference-301+{FAULT}"), None, None, log.as_bytes()).unwrap().unwrap();
    assert_eq!((again.property, again.rule), (found.violation.property, found.violation.rule));
    assert_eq!(replay("sim:reference-301", None, None, log.as_bytes()).unwrap(), None);
}
