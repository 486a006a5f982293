//! A controller that uses the device during the test: a breach that the controller may have caused is no failure of the
//! device, and every report can name the controller.

// `cfg(test)` has no effect here, but tells clippy where a test may unwrap.
#![cfg(test)]

use canvass_analyzer::NodeId;
use canvass_bus::{Bus, Machine, SimulatedBus};
use canvass_device::models::Model;
use canvass_device::{Device, Firmware};
use canvass_suite::bench::{Bench, Options, Target};
use canvass_suite::catalogue::{Selector, select};
use canvass_suite::foreign::{ForeignKind, ForeignMessages};
use canvass_suite::runner::{CaseReport, Plan, RunError, RunEvent, Summary, run};
use canvass_suite::touch::Touch;
use canvass_suite::verdict::Kind;
use canvass_traces::{CanId, Direction, Duration, Frame, Record, Timestamp, parse_frame};
use std::collections::{BTreeSet, VecDeque};
use std::sync::atomic::AtomicBool;

/// Sends frames in turn, one in each period.
struct Controller {
    frames: Vec<Frame>,
    period: Duration,
    next: Timestamp,
    sent: usize,
    outgoing: VecDeque<Frame>,
}

impl Controller {
    fn new(period_ms: u64, frames: &[&str]) -> Self {
        let frames = frames.iter().map(|text| parse_frame(text).unwrap().frame).collect();
        let period = Duration::from_millis(period_ms);
        Self { frames, period, next: Timestamp::ZERO + period, sent: 0, outgoing: VecDeque::new() }
    }
}

impl Machine for Controller {
    fn handle(&mut self, _: Timestamp, _: &Frame) {}

    fn poll_transmit(&mut self, _: Timestamp) -> Option<Frame> {
        self.outgoing.pop_front()
    }

    fn poll_timeout(&self) -> Option<Timestamp> {
        Some(self.next)
    }

    fn handle_timeout(&mut self, now: Timestamp) {
        if now >= self.next {
            self.outgoing.push_back(self.frames[self.sent % self.frames.len()]);
            (self.next, self.sent) = (self.next + self.period, self.sent + 1);
        }
    }
}

struct Outcomes {
    summary: Result<Summary, RunError>,
    reports: Vec<CaseReport>,
    others: Vec<ForeignMessages>,
    notices: Vec<String>,
    /// The frames that the tester sent.
    sent: Vec<Frame>,
}

impl Outcomes {
    fn of(&self, kind: Kind) -> Vec<String> {
        let of_it = self.reports.iter().filter(|report| report.verdict.kind() == kind);
        of_it.map(|report| format!("{}: {}", report.case.id, report.verdict.reason().unwrap_or_default())).collect()
    }
}

fn tested(model: &str, controller: Option<Controller>, selectors: &[&str], allow: &BTreeSet<Touch>) -> Outcomes {
    let model = Model::by_id(model).unwrap();
    let node = NodeId::new(63).unwrap();
    let mut bus = SimulatedBus::new(model.default_bit_rate());
    bus.attach(Box::new(Device::new(model, Some(node), Firmware::PLAIN, 0)));
    if let Some(controller) = controller {
        bus.attach(Box::new(controller));
    }
    let booted = Timestamp::ZERO + Duration::from_secs(6);
    while bus.receive(booted).unwrap().is_some() {}
    let (target, options) = (Target::of(model, node), Options { allow: allow.clone(), ..Options::default() });
    let selectors: Vec<Selector> = selectors.iter().map(|text| text.parse().unwrap()).collect();
    let (cases, cancel) = (select(&selectors).unwrap(), AtomicBool::new(false));
    let mut sent = Vec::new();
    let mut annotate = |record: &Record| {
        sent.extend((record.direction == Direction::Tx).then_some(record.frame));
        String::new()
    };
    let (mut reports, mut others, mut notices) = (Vec::new(), Vec::new(), Vec::new());
    let plan = Plan { cases: &cases, bus: "sim:test", bit_rate: None, seed: 0, shuffle: None };
    let mut bench = Bench::new(&mut bus, &target, &options, &mut annotate, &cancel);
    let summary = run(&mut bench, &plan, &mut |event| match event {
        RunEvent::CaseFinished(report) => reports.push((*report).clone()),
        RunEvent::OtherClients(messages) => others = messages.to_vec(),
        RunEvent::Noticed(text) => notices.push((*text).to_owned()),
        _ => {}
    });
    Outcomes { summary, reports, others, notices, sent }
}

fn everything() -> BTreeSet<Touch> {
    Touch::ALL.into_iter().collect()
}

/// Reads of the device type, the error register and the vendor-ID.
fn polled(period_ms: u64) -> Controller {
    let reads = ["4000100000000000", "4001100000000000", "4018100100000000"];
    let frames = reads.map(|read| format!("63F#{read}"));
    Controller::new(period_ms, &frames.each_ref().map(String::as_str))
}

#[test]
fn a_device_that_is_polled_fails_nothing() {
    for model in ["reference-301", "kuebler-sendix-58x8"] {
        let outcomes = tested(model, Some(polled(20)), &[], &everything());
        assert_eq!((outcomes.of(Kind::Fail), outcomes.of(Kind::Error)), (Vec::new(), Vec::new()), "{model}");
        let alone = tested(model, None, &[], &everything());
        let (passed, usually) = (outcomes.of(Kind::Pass).len(), alone.of(Kind::Pass).len());
        assert!(passed * 100 >= usually * 90, "{model}: {passed} of {usually}: {:#?}", outcomes.of(Kind::Inconclusive));
        let request = ForeignKind::SdoRead;
        let [ForeignMessages { kind, can_id, count }] = outcomes.others[..] else { panic!("{:?}", outcomes.others) };
        assert_eq!((kind, can_id), (request, 0x63F));
        assert!(count > 1_000, "{count}");
        let notice = format!("another SDO client reads its objects ({count} frames with CAN-ID {can_id:03X})");
        assert!(outcomes.notices.iter().any(|text| text.contains(&notice)), "{:?}", outcomes.notices);
        let disturbed = outcomes.reports.iter().filter(|report| !report.foreign.is_empty());
        assert!(disturbed.clone().count() > 300);
        let is_noted = |report: &CaseReport| report.notes.iter().any(|note| note.contains("another SDO client reads"));
        assert!(disturbed.into_iter().all(is_noted));
    }
}

/// A device under a running controller is not reset: the tester sends at most reads.
#[test]
fn a_device_that_others_use_is_left_alone() {
    for frame in ["63F#4000100000000000", "63F#2300100001000000", "000#0100", "73F#R", "080#", "23F#0000000000000000"] {
        let mut allow = everything();
        allow.remove(&Touch::OtherClients);
        let outcomes = tested("reference-301", Some(Controller::new(1_000, &[frame])), &["301/nmt"], &allow);
        let Err(RunError::OtherClients { node, messages }) = &outcomes.summary else {
            panic!("{frame}: {:?}", outcomes.summary)
        };
        assert_eq!((node.raw(), messages.len(), outcomes.reports.len()), (63, 1, 0), "{frame}");
        let is_read =
            |frame: &Frame| frame.id() == CanId::standard_masked(0x63F) && matches!(frame.data()[0] >> 5, 2 | 3);
        assert!(outcomes.sent.iter().all(is_read), "{frame}: {:?}", outcomes.sent);
        let allowed = tested("reference-301", Some(Controller::new(1_000, &[frame])), &["301/nmt"], &everything());
        assert!(allowed.summary.is_ok() && allowed.of(Kind::Fail).is_empty(), "{frame}: {:?}", allowed.of(Kind::Fail));
    }
}

/// Each kind of message that others may send, with the cases of its service.
#[test]
fn what_others_send_is_told_by_its_kind_and_fails_nothing() {
    let rows = [
        (ForeignKind::SdoWrite, 70, "63F#2F11200055000000", "301/sdo"),
        (ForeignKind::Nmt, 300, "000#0100", "301"),
        (ForeignKind::Nmt, 700, "000#813F", "301"),
        (ForeignKind::Sync, 10, "080#", "301"),
        (ForeignKind::Rpdo, 10, "23F#0102030405060708", "301"),
        (ForeignKind::LayerSetting, 50, "7E5#5E00000000000000", "305"),
        (ForeignKind::LayerSetting, 50, "7E5#0401000000000000", "305"),
        (ForeignKind::Guarding, 100, "73F#R", "301"),
    ];
    for (kind, period, frame, cases) in rows {
        let controller = Controller::new(period, &[frame]);
        let outcomes = tested("reference-301", Some(controller), &[cases], &everything());
        assert_eq!(outcomes.of(Kind::Fail), Vec::<String>::new(), "{frame}");
        assert!(outcomes.others.iter().any(|sent| sent.kind == kind), "{frame}: {:?}", outcomes.others);
    }
}

/// Frames that do not concern the device do not count as a use of the device.
#[test]
fn what_does_not_concern_the_device_is_no_use_of_it() {
    for frame in ["605#4000100000000000", "000#0105", "705#05", "185#0000", "101#", "705#R", "123#"] {
        let outcomes = tested("reference-301", Some(Controller::new(50, &[frame])), &["301/nmt"], &BTreeSet::new());
        assert_eq!((outcomes.summary.is_ok(), outcomes.others.len()), (true, 0), "{frame}: {:?}", outcomes.summary);
    }
}

/// A device that is alone on its bus has no other clients, whatever the cases make it send.
#[test]
fn a_device_alone_has_no_other_clients() {
    for model in Model::all() {
        let outcomes = tested(model.id(), None, &[], &everything());
        assert_eq!(outcomes.others, [], "{}", model.id());
        assert!(outcomes.reports.iter().all(|report| report.foreign.is_empty()), "{}", model.id());
    }
}
