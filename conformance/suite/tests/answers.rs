//! The breaches of a case use only the rows of the table of allowed answers that the case names.

// `cfg(test)` has no effect here, but tells clippy where a test may unwrap.
#![cfg(test)]

use canvass_device::Faults;
use canvass_device::models::Model;
use canvass_suite::catalogue;
use canvass_suite::clause::Confidence;
use canvass_suite::selftest;
use canvass_suite::situation::Situation;
use canvass_suite::verdict::When;
use std::collections::BTreeSet;

/// The rows that every case may use: a correct request is confirmed, and a message that asks for no answer gets none.
const GENERAL: [Situation; 2] = [Situation::Confirmed, Situation::Unanswered];

/// On every fault that a case names, its breaches use situations that the case lists.
#[test]
fn a_case_lists_the_situations_of_its_breaches() {
    let mut unlisted = BTreeSet::new();
    let mut seen = BTreeSet::new();
    for case in catalogue::cases() {
        for fault in case.catches {
            let model = Model::by_id(fault.model()).unwrap();
            for ruled in selftest::judge(case, model, Faults::from(*fault)).verdict.breaches() {
                if let When::Listed { situation, .. } = &ruled.breach.situation
                    && !GENERAL.contains(situation)
                {
                    seen.insert(*situation);
                    if !case.answers.contains(situation) {
                        unlisted.insert((case.id, *situation, fault.id()));
                    }
                }
            }
        }
    }
    assert!(unlisted.is_empty(), "{unlisted:#?}");
    assert!(seen.len() > 30, "{}", seen.len());
}

/// Every row is used by a case, so that it is kept correct. Only the fuzzer uses two rows, and a need uses one.
#[test]
fn every_situation_is_asked_for() {
    let asked: BTreeSet<Situation> = catalogue::cases().iter().flat_map(|case| case.answers).copied().collect();
    let unasked = Situation::ALL.iter().filter(|row| !asked.contains(row) && !GENERAL.contains(row));
    let unasked: Vec<&str> = unasked.map(|row| row.id()).collect();
    assert_eq!(unasked, ["wrong-checksum-and-too-short", "wrong-checksum-and-too-long", "sync-not-produced"]);
}

/// The clauses of CiA 301 were read. If a case cites none, no clause contains its requirement.
#[test]
fn the_cases_of_cia_301_cite_what_was_read() {
    let cases = catalogue::cases();
    let uncited =
        cases.iter().filter(|case| case.id.starts_with("301/") && case.clause.confidence != Confidence::Cited);
    let uncited: Vec<&str> = uncited.map(|case| case.id).collect();
    assert_eq!(
        uncited,
        [
            "301/boot-up/self-start",
            "301/dictionary/node-id",
            "301/dictionary/number-of-pdos",
            "301/guarding/cob-id",
            "301/sdo/frame/remote",
            "301/sdo/frame/short",
        ]
    );
}
