//! LSS slaves that are right but differ from ours, a slave that takes another node-ID, and the tester's commands to a
//! bus.

// `cfg(test)` has no effect here, but tells clippy where a test may unwrap.
#![cfg(test)]

use canvass_bus::SimulatedBus;
use canvass_bus::observation::Observation;
use canvass_bus::{Bus, BusError};
use canvass_device::Device;
use canvass_device::Faults;
use canvass_device::models::Model;
use canvass_suite::bench::{Bench, Options, Target};
use canvass_suite::catalogue;
use canvass_suite::runner::{CaseReport, run_case};
use canvass_suite::touch::Touch;
use canvass_suite::verdict::Kind;
use canvass_traces::{Duration, Frame, Record, Timestamp};
use std::collections::{BTreeMap, VecDeque};
use std::sync::atomic::AtomicBool;

const MASTER: u16 = 0x7E5;
const SLAVE: u16 = 0x7E4;

/// The request that the slave sees instead of the master's; `None` if it sees none, as if it did not support the
/// service.
type Request = fn([u8; 8]) -> Option<[u8; 8]>;

/// A bus that changes the master's requests to the slave, and delays the confirmation of storing.
struct Between {
    inner: SimulatedBus,
    request: Request,
    storing: Duration,
    held: VecDeque<Record>,
}

impl Bus for Between {
    fn now(&self) -> Timestamp {
        self.inner.now()
    }

    fn send(&mut self, frame: &Frame) -> Result<(), BusError> {
        if frame.cob_id() != Some(MASTER) {
            return self.inner.send(frame);
        }
        match (self.request)(frame.bytes()) {
            Some(bytes) => self.inner.send(&Frame::full(frame.id(), bytes)),
            None => Ok(()),
        }
    }

    fn receive(&mut self, deadline: Timestamp) -> Result<Option<Record>, BusError> {
        loop {
            let due = self.held.front().map(|record| record.timestamp).filter(|due| *due <= deadline);
            match self.inner.receive(due.unwrap_or(deadline))? {
                Some(mut record) if record.frame.cob_id() == Some(SLAVE) && record.data().first() == Some(&0x17) => {
                    record.timestamp += self.storing;
                    self.held.push_back(record);
                }
                Some(record) => return Ok(Some(record)),
                None => return Ok(due.and_then(|_| self.held.pop_front())),
            }
        }
    }

    fn bit_rate(&self) -> Option<u32> {
        self.inner.bit_rate()
    }

    fn set_bit_rate(&mut self, bit_rate: u32) -> Result<(), BusError> {
        self.inner.set_bit_rate(bit_rate)
    }
}

/// Runs these cases in order on the same device.
fn run(request: Request, storing: Duration, allow: &[Touch], ids: &[&str]) -> BTreeMap<&'static str, CaseReport> {
    let model = Model::by_id("reference-301").unwrap();
    let target = Target::of(model, model.default_node().unwrap());
    let mut inner = SimulatedBus::new(model.default_bit_rate());
    inner.attach(Box::new(Device::new(model, Some(target.node), Faults::NONE, 0)));
    let mut bus = Between { inner, request, storing, held: VecDeque::new() };
    let options = Options { allow: allow.iter().copied().collect(), ..Options::default() };
    let (cancel, mut annotate) = (AtomicBool::new(false), |_: &Record| String::new());
    let mut bench = Bench::new(&mut bus, &target, &options, &mut annotate, &cancel);
    let cases = catalogue::cases().into_iter().filter(|case| ids.iter().any(|id| case.id.starts_with(id)));
    cases.map(|case| (case.id, run_case(&mut bench, case))).collect()
}

const AT_ONCE: Duration = Duration::ZERO;

fn kinds(reports: &BTreeMap<&'static str, CaseReport>) -> BTreeMap<&'static str, Kind> {
    reports.iter().map(|(id, report)| (*id, report.verdict.kind())).collect()
}

/// Requires that no case is judged badly.
fn assert_spared(reports: &BTreeMap<&'static str, CaseReport>) {
    let wrong = reports.iter().filter(|(_, report)| {
        matches!(report.verdict.kind(), Kind::Fail | Kind::Inconclusive | Kind::Error | Kind::Tolerated)
    });
    let wrong: Vec<String> = wrong.map(|(id, report)| format!("{id}: {:?}", report.verdict)).collect();
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn a_slave_without_fastscan_is_right() {
    let reports = run(|bytes| (bytes[0] != 0x51).then_some(bytes), AT_ONCE, &Touch::ALL, &["305"]);
    assert_spared(&reports);
    for (id, kind) in kinds(&reports) {
        let needs_it = id.starts_with("305/fastscan/") && id != "305/fastscan/configured";
        // One case is about devices without LSS.
        assert_eq!(kind == Kind::NotApplicable, needs_it || id == "305/not-supported", "{id}: {kind}");
        if needs_it {
            let reason = reports[id].verdict.reason().unwrap();
            assert!(reason.actual.contains("51h") && reason.actual.contains("4Ch"), "how it was found out: {reason}");
        }
    }
}

#[test]
fn a_slave_without_inquiries_is_right() {
    let reports = run(|bytes| (!(0x5A..=0x5E).contains(&bytes[0])).then_some(bytes), AT_ONCE, &Touch::ALL, &["305"]);
    assert_spared(&reports);
    let kinds = kinds(&reports);
    for id in ["305/inquiry/address", "305/inquiry/node-id", "305/unconfigured/inquiry", "305/node-id/inquired-pending"]
    {
        assert_eq!(kinds[id], Kind::NotApplicable, "{id}");
    }
    for id in ["305/node-id/takes-effect", "305/switch-selective/right", "305/fastscan/find", "305/store/persists"] {
        assert_eq!(kinds[id], Kind::Pass, "{id}");
    }
}

#[test]
fn storing_may_take_seconds() {
    let reports = run(Some, Duration::from_secs(3), &Touch::ALL, &["305/store"]);
    assert_spared(&reports);
    assert_eq!(kinds(&reports)["305/store/answer"], Kind::Pass);
    let too_long = run(Some, Duration::from_secs(8), &Touch::ALL, &["305/store/answer"]);
    assert_eq!(kinds(&too_long)["305/store/answer"], Kind::Fail);
}

/// With only the node-ID allowed, the device is still alone for every case: its further node-IDs are not other nodes.
#[test]
fn a_node_id_that_the_tester_gave_is_no_other_node() {
    let reports =
        run(Some, AT_ONCE, &[Touch::NodeId], &["305/inquiry", "305/node-id", "305/switch", "305/unconfigured"]);
    for (id, report) in &reports {
        assert_eq!(report.verdict.kind(), Kind::Pass, "{id}: {:?}", report.verdict.reason());
    }
    assert!(reports.len() > 15);
}

/// A firmware that takes another node-ID than it was given fails the case in which it does so. The tester then brings
/// it back for the next cases.
#[test]
fn a_device_that_turns_up_elsewhere_is_a_breach_and_is_brought_back() {
    fn misread(mut bytes: [u8; 8]) -> Option<[u8; 8]> {
        // Node-ID 11 becomes 27; the node-IDs 10 (its own), 1, 127 and 255 stay.
        if bytes[0] == 0x11 && bytes[1] == 11 {
            bytes[1] = 27;
        }
        Some(bytes)
    }
    let model = Model::by_id("reference-301").unwrap();
    assert_eq!(model.default_node().unwrap().raw(), 10);
    let ids = ["305/node-id/takes-effect", "305/node-id/valid", "305/switch-global/both-ways"];
    let reports = run(misread, AT_ONCE, &[Touch::NodeId], &ids);
    let elsewhere = reports["305/node-id/takes-effect"].verdict.breaches();
    let actual: Vec<&Observation> = elsewhere.iter().map(|ruled| &ruled.breach.actual).collect();
    assert_eq!(actual, [&Observation::Number(27)]);
    for id in &ids[1..] {
        assert_eq!(reports[id].verdict.kind(), Kind::Pass, "{id}: {:?}", reports[id].verdict.reason());
    }
}
