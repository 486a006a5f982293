//! The fuzzer finds every fault that it claims to find.

use canvass_device::Fault;
use canvass_fuzzer::detection::{Limit, detect};
use canvass_suite::touch::Touch;
use std::time::Duration;

const SEED: u64 = 1;

/// The limit of the search for a fault in this test: few exchanges, and enough time for them on the slowest machine.
/// `canvass selftest --fuzz` gives each fault ten seconds of one core, which are millions of exchanges in an optimised
/// build.
const LIMIT: Limit = Limit { exchanges: 12_000, time: Duration::from_secs(120) };

/// Minimum percentage of the faults that must be found within [`LIMIT`].
const SOON: usize = 70;

/// Maximum number of frames of a shortened sequence.
const LONGEST: usize = 8;

/// Each fault is found without or with a permission, or has a reason why it is not found. The numbers are those of the
/// page.
#[test]
fn every_fault_is_claimed_or_has_a_reason() {
    for fault in Fault::ALL {
        let found = fault.is_fuzzed() || fault.fuzz_needs().is_some();
        assert_eq!(found, fault.unfuzzed().is_none(), "{fault}");
        if let Some(permission) = fault.fuzz_needs() {
            assert_eq!(
                permission.parse::<Touch>().map(|touch| touch.to_string()).as_deref(),
                Ok(permission),
                "{fault}"
            );
        }
    }
    let claimed = Fault::ALL.iter().filter(|fault| fault.unfuzzed().is_none()).count();
    let page = include_str!("../../../../docs/testing.md");
    assert!(page.contains(&format!("`--fuzz`: {claimed} of {claimed} faults")), "docs/testing.md: {claimed}");
}

/// Tests one share of the faults. Several tests run at the same time.
fn share(number: usize, of: usize) {
    let (mut lengths, mut late) = (Vec::new(), Vec::new());
    for (n, &fault) in Fault::ALL.iter().filter(|fault| fault.unfuzzed().is_none()).enumerate() {
        if n % of != number {
            continue;
        }
        let trial = detect(fault, SEED, LIMIT).unwrap();
        let Some(detected) = trial.found else {
            late.push(fault);
            continue;
        };
        let found = detected.found;
        assert!(detected.caused, "{fault}: {:?} shows without it", found.violation);
        assert!(found.confirmed, "{fault}: {:?} does not come back", found.violation);
        assert!(found.sequence.stimuli.len() <= LONGEST, "{fault}: {:?} by {:?}", found.violation, found.sequence);
        lengths.push(found.sequence.stimuli.len());
    }
    assert!(lengths.len() * 100 >= (lengths.len() + late.len()) * SOON, "not found soon: {late:?}");
    lengths.sort_unstable();
    assert!(lengths[lengths.len() / 2] <= 3, "{lengths:?}");
}

#[test]
fn claimed_faults_are_found_1() {
    share(0, 4);
}

#[test]
fn claimed_faults_are_found_2() {
    share(1, 4);
}

#[test]
fn claimed_faults_are_found_3() {
    share(2, 4);
}

#[test]
fn claimed_faults_are_found_4() {
    share(3, 4);
}
