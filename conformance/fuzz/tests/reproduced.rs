//! PROP-02: every SDO response is legal in its state (a toggle bit that does not alternate).
//!
//! Expected: a toggle bit that does not alternate: no answer, or abort with 0503 0000h
//! Found: 10 41 20 70 72 6F 67 72
//! By canvass 0.1.0 with seed 7.

use canvass_fuzzer::reproducer::replay;

const LOG: &str = "\
(0000000000.000000) can0 60A#4010200000000000
# the device: (0000000000.000821) can0 58A#411020005A000000
(0000000000.100000) can0 60A#7000000000000000
# the device: (0000000000.100773) can0 58A#10412070726F6772
";

#[test]
fn prop_02_a_toggle_bit_that_does_not_alternate() {
    let bus = std::env::var("CANVASS_BUS").unwrap_or_else(|_| "sim:reference-301".to_owned());
    let node = canvass_analyzer::NodeId::new(10);
    let violation = replay(&bus, node, None, LOG.as_bytes()).unwrap();
    assert!(violation.is_none(), "{violation:#?}");
}
