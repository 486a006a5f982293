//! A busy bus is not the device's fault: other devices and a babbling node leave it a fifth of a slow bus, and no case
//! fails a device without fault.

// `cfg(test)` has no effect here, but tells clippy where a test may unwrap.
#![cfg(test)]

use canvass_analyzer::NodeId;
use canvass_bus::Machine;
use canvass_bus::SimulatedBus;
use canvass_device::Faults;
use canvass_device::models::Model;
use canvass_device::{Device, Motion};
use canvass_suite::bench::{Bench, Options, Target};
use canvass_suite::catalogue;
use canvass_suite::runner::{CaseReport, run_case};
use canvass_suite::touch::Touch;
use canvass_suite::verdict::Kind;
use canvass_traces::{CanId, Duration, Frame, Timestamp, bit_length};
use std::sync::atomic::AtomicBool;

const BIT_RATE: u32 = 125_000;

/// A node that sends without a pause, at a given bus load in percent, with a high and a low priority in turn.
struct Babbler {
    every: Duration,
    due: Timestamp,
    sent: u32,
    ids: [u16; 3],
}

impl Babbler {
    fn new(percent: u64) -> Self {
        let bits = u64::from(bit_length(&Frame::full(CanId::standard(0x0C7).unwrap(), [0x55; 8])).unwrap());
        let every = Duration(bits * 1_000_000_000 / u64::from(BIT_RATE) * 100 / percent);
        // The identifiers are those of an EMCY, a TPDO and an RPDO of nodes that no test uses.
        Self { every, due: Timestamp::ZERO, sent: 0, ids: [0x0C7, 0x1C7, 0x4C7] }
    }
}

impl Machine for Babbler {
    fn handle(&mut self, _: Timestamp, _: &Frame) {}

    fn poll_transmit(&mut self, now: Timestamp) -> Option<Frame> {
        if now < self.due {
            return None;
        }
        // A frame for which the bus had no room is not repeated later.
        self.due = now.max(self.due) + self.every;
        self.sent = self.sent.wrapping_add(1);
        let id = self.ids[self.sent as usize % self.ids.len()];
        // The data are those of an EMCY, and of a position that advances.
        let [low, high, ..] = self.sent.to_le_bytes();
        Some(Frame::full(CanId::standard(id.into()).unwrap(), [0x00, 0x81, 0x11, low, high, 0x55, 0x55, 0x55]))
    }

    fn poll_timeout(&self) -> Option<Timestamp> {
        Some(self.due)
    }

    fn handle_timeout(&mut self, _: Timestamp) {}
}

/// Runs every case on a new bus with the device, the devices of `crowd`, and a babbler with this load.
fn judged(model: &'static Model, load: u64, crowd: &[(&str, u8)], allow: &[Touch]) -> Vec<CaseReport> {
    let node = model.default_node().or_else(|| NodeId::new(63)).unwrap();
    let target = Target::of(model, node);
    let options = Options { allow: allow.iter().copied().collect(), ..Options::default() };
    let cancel = AtomicBool::new(false);
    let judge = |case: &'static canvass_suite::case::Case| {
        let mut bus = SimulatedBus::new(BIT_RATE);
        let motion = Motion::constant(0x4CBA, if case.needs_motion() { 30_000 } else { 0 });
        bus.attach(Box::new(Device::with_motion(model, Some(node), Faults::NONE, 0, &motion)));
        for (other, node) in crowd {
            let other = Model::by_id(other).unwrap();
            bus.attach(Box::new(Device::new(other, NodeId::new(*node), Faults::NONE, u64::from(*node))));
        }
        bus.attach(Box::new(Babbler::new(load)));
        let mut annotate = |_: &canvass_traces::Record| String::new();
        run_case(&mut Bench::new(&mut bus, &target, &options, &mut annotate, &cancel), case)
    };
    // Unoptimised code takes minutes for all cases: every model gets a share of them, and all models together get every
    // case.
    let share = if cfg!(debug_assertions) { Model::all().len() } else { 1 };
    let own = Model::all().iter().position(|other| other.id() == model.id()).unwrap();
    let cases = catalogue::cases().into_iter().enumerate().filter(|(n, _)| n % share == own % share);
    cases.map(|(_, case)| judge(case)).collect()
}

/// Requires that no case fails, and that at least `judged_percent` of the applicable cases are judged.
fn check(id: &str, load: u64, crowd: &[(&str, u8)], allow: &[Touch], judged_percent: usize) {
    let reports = judged(Model::by_id(id).unwrap(), load, crowd, allow);
    let wrong: Vec<String> = reports
        .iter()
        .filter(|report| matches!(report.verdict.kind(), Kind::Fail | Kind::Error))
        .map(|report| format!("{}: {:?}", report.case.id, report.verdict))
        .collect();
    assert!(wrong.is_empty(), "{id}: {}:\n{}", wrong.len(), wrong.join("\n"));
    let count = |wanted: &dyn Fn(Kind) -> bool| reports.iter().filter(|report| wanted(report.verdict.kind())).count();
    let (executed, open) = (count(&Kind::is_executed), count(&|kind| kind == Kind::Inconclusive));
    let unclear: Vec<String> = reports
        .iter()
        .filter(|report| report.verdict.kind() == Kind::Inconclusive)
        .map(|report| format!("{}: {}", report.case.id, report.verdict.reason().unwrap()))
        .collect();
    assert!(
        executed * 100 >= (executed + open) * judged_percent,
        "{id}: {executed} judged, {open} not:\n{}",
        unclear.join("\n")
    );
}

const QUIET: [Touch; 4] = [Touch::Nvm, Touch::NodeId, Touch::BitRate, Touch::FactoryDefaults];

macro_rules! busy {
    ($($name:ident = $id:literal,)*) => {
        $(
            #[test]
            fn $name() {
                check($id, 80, &[], &Touch::ALL, 80);
            }
        )*
    };
}

/// Other devices with their own heartbeats and PDOs, besides the babbling node.
#[test]
fn among_other_devices() {
    check("reference-301", 60, &[("kuebler-sendix-58x8", 71), ("lika-ax58", 72)], &QUIET, 80);
}

canvass_device::each_model!(busy);
