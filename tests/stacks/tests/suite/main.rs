//! The whole suite, with all permissions, on devices with third-party stacks.
//!
//! Verdicts other than *pass*, *tolerated* and *not applicable* are listed in `canopen_rs.rs` and `zencan.rs` with
//! their reasons: a change of a case or of a stack shows at once.

#![cfg(test)]

mod canopen_rs;
mod description;
mod zencan;

use canvass_analyzer::NodeId;
use canvass_analyzer::dictionary::DeviceDescription;
use canvass_bus::Machine;
use canvass_bus::SimulatedBus;
use canvass_stacks::{Memorial, Stack, StackDevice};
use canvass_suite::bench::{Bench, Decoder, Options, Target};
use canvass_suite::catalogue;
use canvass_suite::runner::{CaseReport, Plan, RunEvent, Summary, run};
use canvass_suite::touch::Touch;
use canvass_suite::verdict::Kind;
use canvass_traces::Duration;
use std::fmt::Write;
use std::sync::atomic::AtomicBool;

const BIT_RATE: u32 = 500_000;

/// Time after which a stack that panicked is restarted, as most devices in the field are, so that the following cases
/// can be judged.
const WATCHDOG: Duration = Duration::from_millis(100);

/// A device on the simulated bus, and its description.
struct Peer {
    machine: Box<dyn Machine>,
    memorial: Memorial,
    eds: &'static str,
    node: NodeId,
}

impl Peer {
    fn new<S: Stack + 'static>(stack: S, eds: &'static str, node: u8) -> Self {
        let device = StackDevice::new(stack).with_watchdog(WATCHDOG);
        let memorial = device.memorial();
        Self { machine: Box::new(device), memorial, eds, node: NodeId::new(node).unwrap() }
    }

    fn target(&self) -> Target {
        let description = Some(DeviceDescription::read(self.eds.as_bytes()).unwrap());
        Target { description, ..Target::unknown(self.node) }
    }
}

/// The result of a run of the suite.
struct Outcome {
    reports: Vec<CaseReport>,
    notices: Vec<String>,
    summary: Summary,
    memorial: Memorial,
}

/// Runs the cases whose ids begin with this text.
fn judge(peer: Peer, described: bool, begin: &str) -> Outcome {
    let mut target = peer.target();
    if !described {
        target.description = None;
    }
    let mut bus = SimulatedBus::new(BIT_RATE);
    bus.attach(peer.machine);
    let options = Options { allow: Touch::ALL.into(), ..Options::default() };
    let (mut decoder, cancel) = (Decoder::new(&target), AtomicBool::new(false));
    let mut bench = Bench::new(&mut bus, &target, &options, &mut decoder, &cancel);
    let cases: Vec<_> = catalogue::cases().into_iter().filter(|case| case.id.starts_with(begin)).collect();
    let plan = Plan { cases: &cases, bus: "sim:stack", bit_rate: Some(BIT_RATE), seed: 0, shuffle: None };
    let (mut reports, mut notices) = (Vec::new(), Vec::new());
    let summary = run(&mut bench, &plan, &mut |event| match event {
        RunEvent::CaseFinished(report) => reports.push((*report).clone()),
        RunEvent::Noticed(notice) => notices.push((*notice).to_owned()),
        _ => {}
    });
    assert_eq!(reports.len(), cases.len(), "the run came to its end");
    Outcome { reports, notices, summary: summary.unwrap(), memorial: peer.memorial }
}

/// The cases that do not end well, each with its verdict and the reason.
type Expected = [(&'static str, Kind, &'static str)];

/// Cases that fail on a stack that stores PDO parameters without checks.
const PDO_PARAMETERS_UNCHECKED: [&str; 16] = [
    "301/cob-id/bits-beyond",
    "301/cob-id/each-bit-valid",
    "301/pdo/cob-id/every-valid",
    "301/pdo/cob-id/restricted",
    "301/pdo/cob-id/too-high",
    "301/pdo/cob-id/valid",
    "301/pdo/mapping/count",
    "301/pdo/mapping/every-valid",
    "301/pdo/mapping/too-long",
    "301/pdo/mapping/unmappable",
    "301/pdo/mapping/unmappable-in-rpdo",
    "301/pdo/mapping/valid",
    "301/pdo/transmission-type/reserved",
    "301/rpdo/cob-id/valid",
    "301/rpdo/mapping/valid",
    "301/rpdo/reserved-type",
];

/// Requires the expected verdicts and the failures in `failed`, and no others.
fn expect(outcome: &Outcome, expected: &Expected, failed: &[&'static str]) {
    let failed = failed.iter().map(|&id| (id, Kind::Fail, ""));
    let expected: Vec<_> = expected.iter().copied().chain(failed).collect();
    let is_good = |kind: Kind| matches!(kind, Kind::Pass | Kind::Tolerated | Kind::NotApplicable);
    let mut wrong = String::new();
    for report in &outcome.reports {
        let kind = report.verdict.kind();
        let known = expected.iter().find(|(id, ..)| *id == report.case.id).map(|(_, kind, _)| *kind);
        if known.unwrap_or(Kind::Pass) != kind && !(known.is_none() && is_good(kind)) {
            writeln!(wrong, "{}", describe(report)).unwrap();
        }
    }
    let ids: Vec<&str> = outcome.reports.iter().map(|report| report.case.id).collect();
    for (id, ..) in expected.iter().filter(|(id, ..)| !ids.contains(id)) {
        writeln!(wrong, "{id}: no such case").unwrap();
    }
    let counts: Vec<String> = Kind::ALL.map(|kind| format!("{kind} {}", outcome.summary.count(kind))).into();
    assert!(wrong.is_empty(), "differs from what is known of this stack ({}):\n{wrong}", counts.join(", "));
}

fn describe(report: &CaseReport) -> String {
    let reason = report.verdict.reason().map(|reason| reason.to_string()).unwrap_or_default();
    let frames: Vec<String> = report
        .evidence
        .frames()
        .map(|exhibit| format!("  ({}) {}  {}", exhibit.record.timestamp, exhibit.record.frame, exhibit.text))
        .collect();
    let tail = &frames[frames.len().saturating_sub(12)..];
    format!("{}: {}: {reason} {:?}\n{}", report.case.id, report.verdict.kind(), report.notes, tail.join("\n"))
}

/// Number of passed cases: a run to which hardly any case applies would prove nothing.
fn passed(outcome: &Outcome) -> usize {
    outcome.summary.count(Kind::Pass)
}

/// The part of a run that two runs must have in common, with all frames and times.
fn trace(outcome: &Outcome) -> Vec<String> {
    let of_case = |report: &CaseReport| {
        let frames =
            report.evidence.frames().map(|exhibit| format!("{} {}", exhibit.record.timestamp, exhibit.record.frame));
        format!("{}: {:?}: {}", report.case.id, report.verdict, frames.collect::<Vec<_>>().join(", "))
    };
    outcome.reports.iter().map(of_case).collect()
}
