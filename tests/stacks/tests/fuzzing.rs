//! The fuzzer on devices with third-party stacks: the properties that they break, each by its smallest sequence.
//!
//! Every violation was judged by hand, in `docs/peers.md`. A violation that is missing here shows a change of the
//! oracle, of the generator or of a stack.

#![cfg(test)]

use canvass_analyzer::NodeId;
use canvass_analyzer::dictionary::DeviceDescription;
use canvass_fuzzer::campaign::{self, Found, Outcome, Plan};
use canvass_fuzzer::stand::{MakeDevice, Simulated};
use canvass_fuzzer::{Knowledge, Patience, Property, Start, Target};
use canvass_stacks::{Memorial, StackDevice, canopen_rs, zencan};
use canvass_suite::touch::Touch;
use canvass_traces::Duration;
use std::collections::BTreeSet;
use std::fmt::Write;

const BIT_RATE: u32 = 500_000;
const BOOT: Duration = Duration::from_millis(100);

/// A stack for the fuzzer, made anew for each sequence.
struct Peer {
    make: MakeDevice,
    eds: &'static str,
    node: u8,
    memorial: Memorial,
}

fn canopen_rs() -> Peer {
    let memorial = Memorial::default();
    let kept = memorial.clone();
    let make = move |start| {
        let stack = match start {
            Start::Configured => canopen_rs::CanopenRs::new(),
            Start::Unconfigured => canopen_rs::CanopenRs::unconfigured(),
        };
        Box::new(StackDevice::new(stack).remembered_in(&kept)) as Box<_>
    };
    Peer { make: Box::new(make), eds: canopen_rs::EDS, node: canopen_rs::NODE, memorial }
}

fn zencan() -> Peer {
    let memorial = Memorial::default();
    let kept = memorial.clone();
    let make = move |start| {
        let stack = match start {
            Start::Configured => zencan::Zencan::new(),
            Start::Unconfigured => zencan::Zencan::unconfigured(),
        };
        Box::new(StackDevice::new(stack).remembered_in(&kept)) as Box<_>
    };
    Peer { make: Box::new(make), eds: zencan::EDS, node: zencan::NODE, memorial }
}

fn fuzz(peer: Peer, target: Target, sequences: u64) -> Outcome {
    let node = NodeId::new(peer.node).unwrap();
    let description = DeviceDescription::read(peer.eds.as_bytes()).unwrap();
    let mut knowledge = Knowledge::new(node, Some(&description), None);
    // The stacks answer at once; their tasks run every millisecond.
    knowledge.patience = Patience {
        answer: Duration::from_millis(50),
        quiet: Duration::from_millis(5),
        boot: BOOT,
        jitter: Duration::from_millis(2),
    };
    let mut stand = Simulated::new(peer.make, node, BIT_RATE, BOOT, true);
    let plan = Plan {
        targets: target.into(),
        seed: 1,
        allow: [Touch::NodeId, Touch::Nvm].into(),
        shrink_budget: 500,
        time: canvass_fuzzer::time_limit::TimeLimit::default(),
        stop_at_first: false,
        regressions: Vec::new(),
        only_regressions: false,
        corpus: Vec::new(),
    };
    campaign::run(&mut stand, knowledge, &plan, &mut |progress| progress.sequences < sequences).unwrap()
}

/// Requires that each violation has one of these properties and rules, and that most of them are found. Which of them a
/// run of this length finds depends on the random choices of the generator.
fn expect(found: &[Found], expected: &[(Property, &'static str)]) {
    let broken: BTreeSet<_> = found.iter().map(|found| (found.violation.property, found.violation.rule)).collect();
    let mut wrong = String::new();
    for found in found.iter().filter(|found| !expected.contains(&(found.violation.property, found.violation.rule))) {
        let violation = &found.violation;
        writeln!(wrong, "{:?}, {:?}: new", violation.property, violation.rule).unwrap();
        writeln!(wrong, "  expected {}, actual {}", violation.expected, violation.actual).unwrap();
        for record in &found.evidence {
            writeln!(wrong, "  ({}) {} {}", record.timestamp, record.frame, record.direction).unwrap();
        }
    }
    assert!(wrong.is_empty(), "{wrong}");
    let missing: Vec<_> = expected.iter().filter(|expected| !broken.contains(*expected)).collect();
    assert!(missing.len() * 4 <= expected.len(), "not found any more: {missing:?}");
    assert!(found.iter().all(|found| found.confirmed), "on the simulated bus everything comes again");
}

/// Fuzzes each service separately, so that a violation of one service does not hide violations of another.
fn judge(peer: fn() -> Peer, sequences: u64, expected: &[(Property, &'static str)], panics: &[&str]) {
    let (mut found, mut deaths) = (Vec::new(), BTreeSet::new());
    for target in [Target::Sdo, Target::Lss, Target::Nmt, Target::Pdo, Target::SyncEmcy] {
        let peer = peer();
        let memorial = peer.memorial.clone();
        found.extend(fuzz(peer, target, sequences).violations);
        deaths.extend(memorial.deaths().into_iter().map(|death| death.reason));
    }
    expect(&found, expected);
    assert_eq!(deaths.iter().map(String::as_str).collect::<Vec<_>>(), panics);
}

#[test]
fn canopen_rs_breaks_what_is_documented() {
    judge(canopen_rs, 600, CANOPEN_RS, &[]);
}

#[test]
fn zencan_breaks_what_is_documented() {
    judge(zencan, 2_000, ZENCAN, &["attempt to shift left with overflow", "attempt to subtract with overflow"]);
}

const CANOPEN_RS: &[(Property, &str)] = &[
    (Property::Consistent, "initiate upload"),
    (Property::Fastscan, "Fastscan"),
    (Property::LegalLss, "identify non-configured remote slave"),
    (Property::LegalLss, "identify remote slave"),
    (Property::LegalSdo, "a download segment without its transfer"),
    (Property::LegalSdo, "a segment is asked for without its transfer"),
    (Property::LegalSdo, "download segment"),
    (Property::LegalSdo, "expedited download"),
    (Property::LegalSdo, "initiate download"),
    (Property::Pdo, "download segment"),
    (Property::Pdo, "expedited download"),
    (Property::Pdo, "synchronous TPDO"),
];

const ZENCAN: &[(Property, &str)] = &[
    (Property::Consistent, "initiate block upload"),
    (Property::Consistent, "initiate upload"),
    (Property::Fastscan, "Fastscan"),
    (Property::LegalLss, "configure node-ID"),
    (Property::LegalLss, "identify non-configured remote slave"),
    (Property::LegalLss, "identify remote slave"),
    (Property::LegalLss, "inquire"),
    (Property::LegalLss, "inquire node-ID"),
    (Property::LegalLss, "switch state selective"),
    (Property::LegalSdo, "a block size outside 1 to 127"),
    (Property::LegalSdo, "a command specifier that does not exist"),
    (Property::LegalSdo, "a segment is confirmed that was never sent"),
    (Property::LegalSdo, "download of a block"),
    (Property::LegalSdo, "download segment"),
    (Property::LegalSdo, "end of a block download"),
    (Property::LegalSdo, "end of a block upload"),
    (Property::LegalSdo, "expedited download"),
    (Property::LegalSdo, "initiate block download"),
    (Property::LegalSdo, "initiate block upload"),
    (Property::LegalSdo, "initiate download"),
    (Property::LegalSdo, "initiate upload"),
    (Property::LegalSdo, "upload of a block"),
    (Property::NmtState, "boot-up after reset"),
    (Property::NmtState, "boot-up message"),
    (Property::NmtState, "state in error control"),
    (Property::OneAnswer, "unsolicited response"),
    (Property::Pdo, "download segment"),
    (Property::Pdo, "end of a block download"),
    (Property::Pdo, "expedited download"),
    (Property::Pdo, "identifier"),
    (Property::Pdo, "synchronous TPDO"),
    (Property::Responsive, "canonical read"),
    (Property::ReadBack, "initiate upload"),
    (Property::Silent, "SDO in a state without SDO"),
    (Property::Silent, "frame before the boot-up message"),
];
