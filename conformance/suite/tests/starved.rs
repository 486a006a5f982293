//! A device that now and then gets no processor time is late with everything, and none of its times fails a case. A
//! device with wrong timers fails all the same, late or not.

// `cfg(test)` has no effect here, but tells clippy where a test may unwrap.
#![cfg(test)]

use canvass_analyzer::NodeId;
use canvass_bus::{Bus, Machine, SimulatedBus};
use canvass_device::models::Model;
use canvass_device::{Device, Fault, Faults, Firmware};
use canvass_suite::bench::{Bench, Options, Target};
use canvass_suite::catalogue::{Selector, select};
use canvass_suite::runner::{CaseReport, Plan, RunEvent, run};
use canvass_suite::touch::Touch;
use canvass_suite::verdict::{Kind, Lack};
use canvass_traces::{Duration, Frame, Record, Timestamp};
use std::collections::VecDeque;
use std::sync::atomic::AtomicBool;

/// A machine that is suspended again and again: after each stall it serves the frames and timers of the stall.
struct Starved {
    machine: Device,
    frames: VecDeque<Frame>,
    /// The times between stalls, all different.
    stalls: Stalls,
    stall: (Timestamp, Timestamp),
}

/// The begins and lengths of stalls, from a fixed pseudo-random sequence.
struct Stalls {
    state: u64,
    longest: Duration,
    /// The longest time from one stall to the next, in milliseconds.
    apart: u64,
}

impl Stalls {
    fn next(&mut self, after: Timestamp) -> (Timestamp, Timestamp) {
        self.state = self.state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        let chance = self.state >> 40;
        let begins = after + Duration::from_millis(20 + chance % self.apart);
        (begins, begins + Duration(self.longest.0 * (chance % 8 + 1) / 8))
    }
}

impl Starved {
    fn new(machine: Device, longest_ms: u64) -> Self {
        Self::by(machine, Stalls { state: 1, longest: Duration::from_millis(longest_ms), apart: 180 })
    }

    fn by(machine: Device, mut stalls: Stalls) -> Self {
        let stall = stalls.next(Timestamp::ZERO);
        Self { machine, frames: VecDeque::new(), stalls, stall }
    }

    /// The end of the current stall; `None` if the machine is not suspended.
    fn suspended(&mut self, now: Timestamp) -> Option<Timestamp> {
        while self.stall.1 <= now {
            self.stall = self.stalls.next(self.stall.1);
        }
        (self.stall.0 <= now).then_some(self.stall.1)
    }

    fn go_on(&mut self, now: Timestamp) {
        for frame in std::mem::take(&mut self.frames) {
            self.machine.handle(now, &frame);
        }
    }
}

impl Machine for Starved {
    fn handle(&mut self, now: Timestamp, frame: &Frame) {
        self.frames.push_back(*frame);
        if self.suspended(now).is_none() {
            self.go_on(now);
        }
    }

    fn poll_transmit(&mut self, now: Timestamp) -> Option<Frame> {
        if self.suspended(now).is_some() { None } else { self.machine.poll_transmit(now) }
    }

    fn poll_timeout(&self) -> Option<Timestamp> {
        // Timers and frames of a stall are served at its end.
        let (begins, ends) = self.stall;
        let due = self.machine.poll_timeout().unwrap_or(Timestamp::MAX);
        Some(if due >= begins || !self.frames.is_empty() { ends } else { due })
    }

    fn handle_timeout(&mut self, now: Timestamp) {
        if self.suspended(now).is_none() {
            self.go_on(now);
            if self.machine.poll_timeout().is_some_and(|due| due <= now) {
                self.machine.handle_timeout(now);
            }
        }
    }

    fn bit_rate(&self) -> Option<u32> {
        self.machine.bit_rate()
    }

    fn withdraws(&self, pending: &Frame) -> bool {
        self.machine.withdraws(pending)
    }
}

/// A device that confirms a store at once and writes its memory afterwards: its SDO server is busy meanwhile, its
/// timers are not.
struct WritesAfterwards {
    machine: Device,
    requests: VecDeque<Frame>,
    busy: Option<(Timestamp, Timestamp)>,
}

impl WritesAfterwards {
    const CONFIRMS: Duration = Duration::from_millis(20);
    const WRITES: Duration = Duration::from_millis(200);

    fn is_busy(&self, now: Timestamp) -> bool {
        self.busy.is_some_and(|(begins, ends)| (begins..ends).contains(&now))
    }
}

impl Machine for WritesAfterwards {
    fn handle(&mut self, now: Timestamp, frame: &Frame) {
        let is_request = frame.cob_id() == Some(0x600 + u16::from(NODE));
        if is_request && self.is_busy(now) {
            self.requests.push_back(*frame);
            return;
        }
        if is_request && frame.data().starts_with(&[0x23, 0x10, 0x10]) {
            self.busy = Some((now + Self::CONFIRMS, now + Self::CONFIRMS + Self::WRITES));
        }
        self.machine.handle(now, frame);
    }

    fn poll_transmit(&mut self, now: Timestamp) -> Option<Frame> {
        self.machine.poll_transmit(now)
    }

    fn poll_timeout(&self) -> Option<Timestamp> {
        let written = self.busy.map(|(_, ends)| ends).filter(|_| !self.requests.is_empty());
        self.machine.poll_timeout().into_iter().chain(written).min()
    }

    fn handle_timeout(&mut self, now: Timestamp) {
        if !self.is_busy(now) {
            for frame in std::mem::take(&mut self.requests) {
                self.machine.handle(now, &frame);
            }
        }
        if self.machine.poll_timeout().is_some_and(|due| due <= now) {
            self.machine.handle_timeout(now);
        }
    }

    fn bit_rate(&self) -> Option<u32> {
        self.machine.bit_rate()
    }

    fn withdraws(&self, pending: &Frame) -> bool {
        self.machine.withdraws(pending)
    }
}

const NODE: u8 = 63;

fn device(firmware: Firmware) -> Device {
    Device::new(Model::by_id("reference-301").unwrap(), NodeId::new(NODE), firmware, 0)
}

fn tested(firmware: impl Into<Firmware>, longest_ms: u64, selectors: &[&str]) -> Vec<CaseReport> {
    let firmware = firmware.into();
    tested_as(Box::new(Starved::new(device(firmware), longest_ms)), firmware, selectors)
}

fn tested_as(machine: Box<dyn Machine>, firmware: Firmware, selectors: &[&str]) -> Vec<CaseReport> {
    let model = Model::by_id("reference-301").unwrap();
    let node = NodeId::new(NODE).unwrap();
    let mut bus = SimulatedBus::new(model.default_bit_rate());
    bus.attach(machine);
    let booted = Timestamp::ZERO + Duration::from_secs(6);
    while bus.receive(booted).unwrap().is_some() {}
    let options = Options { allow: Touch::ALL.into_iter().collect(), ..Options::default() };
    let selectors: Vec<Selector> = selectors.iter().map(|text| text.parse().unwrap()).collect();
    let (target, cases) = (Target::with_firmware(model, node, firmware), select(&selectors).unwrap());
    let (cancel, mut annotate) = (AtomicBool::new(false), |_: &Record| String::new());
    let plan = Plan { cases: &cases, bus: "sim:test", bit_rate: None, seed: 0, shuffle: None };
    let mut reports = Vec::new();
    let mut bench = Bench::new(&mut bus, &target, &options, &mut annotate, &cancel);
    // If a single case could not be judged, its verdict says so; the result of the run adds nothing.
    let _ = run(&mut bench, &plan, &mut |event| {
        if let RunEvent::CaseFinished(report) = event {
            reports.push((*report).clone());
        }
    });
    reports
}

fn ending(reports: &[CaseReport], kind: Kind) -> Vec<String> {
    let ending = reports.iter().filter(|report| report.verdict.kind() == kind);
    ending.map(|report| format!("{}: {}", report.case.id, report.verdict.reason().unwrap_or_default())).collect()
}

#[test]
fn a_starved_device_fails_nothing() {
    for longest in [8, 40, 120, 250] {
        let reports = tested(Faults::NONE, longest, &[]);
        assert_eq!(ending(&reports, Kind::Fail), Vec::<String>::new(), "stalls of up to {longest} ms");
        let undecided = ending(&reports, Kind::Inconclusive);
        assert!(undecided.len() * 50 <= reports.len(), "stalls of up to {longest} ms: {undecided:#?}");
    }
}

/// A device with rare stalls: a stall may meet a case, and none of the reads beside it.
fn seldom_late(firmware: impl Into<Firmware>, state: u64, apart: u64, selectors: &[&str]) -> Vec<CaseReport> {
    let firmware = firmware.into();
    let stalls = Stalls { state, longest: Duration::from_millis(400), apart };
    tested_as(Box::new(Starved::by(device(firmware), stalls)), firmware, selectors)
}

/// A case that failed once and not again is inconclusive, and its report shows the frames of the failure.
#[test]
fn a_device_that_is_seldom_late_fails_nothing() {
    let mut doubted = 0;
    for (state, apart) in [(11, 1_000), (23, 1_000), (4, 3_000), (14, 3_000)] {
        let reports = seldom_late(Faults::NONE, state, apart, &[]);
        assert_eq!(ending(&reports, Kind::Fail), Vec::<String>::new(), "stalls up to {apart} ms apart, by {state}");
        let undecided = ending(&reports, Kind::Inconclusive);
        assert!(undecided.len() * 50 <= reports.len(), "stalls up to {apart} ms apart: {undecided:#?}");
        let is_doubted = |report: &&CaseReport| {
            report.verdict.reason().is_some_and(|reason| reason.actual.starts_with("another try did not find it"))
        };
        for report in reports.iter().filter(is_doubted) {
            let told = report.notes.iter().any(|note| note.starts_with("try 2 ended with"));
            assert!(told && report.evidence.frames().next().is_some(), "{}: {:?}", report.case.id, report.notes);
            doubted += 1;
        }
    }
    assert!(doubted > 0, "a stall made a case fail");
}

/// A device that always does the wrong thing fails, whether a stall comes or not.
#[test]
fn what_is_always_wrong_is_found_on_a_device_that_is_seldom_late() {
    for (fault, case) in [
        (Fault::EventTimerDoubled, "301/tpdo/event-timer"),
        (Fault::HeartbeatPeriodDoubled, "301/heartbeat/period"),
        (Fault::SyncPeriodDoubled, "301/sync/period"),
        (Fault::HeartbeatWrongState, "301/heartbeat/state"),
        (Fault::NmtStopWhenOperationalIgnored, "301/nmt/operational/stop"),
        (Fault::BootUpMissing, "301/boot-up/reset-node"),
    ] {
        for (state, apart) in [(3, 9_000), (8, 9_000), (4, 30_000), (6, 30_000)] {
            // The whole family runs: the cases before this one show that the device is late.
            let reports = seldom_late(fault, state, apart, &[case.rsplit_once('/').unwrap().0]);
            let failed = ending(&reports, Kind::Fail);
            let is_found = failed.iter().any(|told| told.starts_with(case));
            assert!(is_found, "{fault:?}, {apart} ms, by {state}: {:#?}", ending(&reports, Kind::Inconclusive));
        }
    }
}

/// Wrong timers are found on a device that answers promptly, and on a device whose lateness is less than the error.
#[test]
fn wrong_timers_are_found() {
    for (fault, case) in [
        (Fault::EventTimerDoubled, "301/tpdo/event-timer"),
        (Fault::EventTimerOffByOne, "301/tpdo/event-timer-mean"),
        (Fault::HeartbeatPeriodDoubled, "301/heartbeat/period"),
        (Fault::SyncPeriodDoubled, "301/sync/period"),
        (Fault::HeartbeatTimerRounded, "301/heartbeat/extremes"),
        (Fault::HeartbeatWrongState, "301/heartbeat/state"),
        (Fault::RpdoDeadlineNotRestarted, "301/rpdo/deadline-kept"),
    ] {
        // One tick too many is less than the delay of 50 periods by a stall of 25 ms.
        let stalls: &[u64] = if fault == Fault::EventTimerOffByOne { &[0, 8] } else { &[0, 8, 25] };
        for &longest in stalls {
            let reports = tested(fault, longest, &[case]);
            assert_eq!(ending(&reports, Kind::Fail).len(), 1, "{fault:?}, {longest} ms: {:?}", reports[0].verdict);
        }
    }
}

/// The time in which a device stores parameters does not excuse a late heartbeat.
#[test]
fn a_device_that_writes_its_memory_is_not_late() {
    for (fault, case) in [
        (Fault::HeartbeatLateAfterBootUp, "301/heartbeat/after-boot-up"),
        (Fault::StoredConfigurationIdle, "301/heartbeat/after-boot-up"),
    ] {
        let firmware: Firmware = Faults::from_iter([fault]).into();
        let machine = WritesAfterwards { machine: device(firmware), requests: VecDeque::new(), busy: None };
        let reports = tested_as(Box::new(machine), firmware, &[case]);
        assert_eq!(ending(&reports, Kind::Fail).len(), 1, "{fault:?}: {:?}", reports[0].verdict);
    }
}

/// The verdict on a starved device names the excuse, and the lateness that was measured.
#[test]
fn lateness_is_told() {
    let reports = tested(Faults::NONE, 250, &["301"]);
    let reasons = reports.iter().filter_map(|report| report.verdict.reason());
    let late: Vec<_> = reasons.filter(|reason| reason.lack == Lack::Promptness).collect();
    assert!(late.iter().all(|reason| reason.duty == "the device keeps up"), "{late:#?}");
    assert!(late.iter().all(|reason| reason.actual.contains("the device was late as a whole")), "{late:#?}");
    // If a failure did not come again, the reason says so; otherwise a read outside the case has shown the lateness.
    let measured = "the device was late as a whole: a read outside the case";
    assert!(late.iter().any(|reason| reason.actual.starts_with(measured)), "{late:#?}");
    let tried = reports.iter().flat_map(|report| &report.notes).filter(|note| note.contains("late as a whole"));
    assert!(tried.count() > 0, "tried again");
}
