//! Tens of thousands of random frames, more of which the device understands than pure chance would give.

// `cfg(test)` has no effect here, but clippy uses it to recognise where a test may unwrap.
#![cfg(test)]

use canvass_device::models::Model;
use canvass_fuzzer::storm::storm;

/// `cargo xtask storm` tests the same with ten million frames for each model.
#[test]
fn a_storm_breaks_no_model_and_reaches_every_state() {
    for (seed, model) in (0..).zip(Model::all()) {
        let done = storm(model, 60_000, seed).unwrap_or_else(|broken| panic!("{broken}"));
        assert!(done.frames >= 60_000 && done.by_state.iter().sum::<u64>() == done.frames);
        assert!(done.by_state.iter().all(|count| *count > 300), "{}: {:?}", model.id(), done.by_state);
        assert_eq!(storm(model, 2_000, seed), storm(model, 2_000, seed), "{}: repeatable", model.id());
    }
}
