//! Live devices whose fault shows only once, that die, or that panic.

use crate::perishable::Perishable;
use canvass_analyzer::NodeId;
use canvass_bus::Machine;
use canvass_bus::SimulatedBus;
use canvass_device::Device;
use canvass_device::Fault;
use canvass_device::Faults;
use canvass_device::models::Model;
use canvass_fuzzer::campaign::{Outcome, Plan, campaign, run};
use canvass_fuzzer::stand::Simulated;
use canvass_fuzzer::{Knowledge, Property, Target};
use canvass_traces::{Duration, Frame, Timestamp};
use std::collections::BTreeSet;

const NODE: NodeId = NodeId::MIN;

/// The failure of a device at the n-th request to read 1000h after power-on.
#[derive(Clone, Copy, PartialEq)]
enum Failing {
    /// The device does not answer this request, and answers all later ones.
    Once,
    /// The device stops working.
    Dies,
    /// The device's program panics.
    Panics,
}

struct Odd {
    machine: Perishable,
    failing: Failing,
    /// Number of reads of 1000h until the failure.
    left: u32,
}

impl Odd {
    fn new(failing: Failing, left: u32) -> Self {
        let model = Model::by_id("reference-301").unwrap();
        let machine = Perishable::new(Device::new(model, Some(NODE), Faults::NONE, 0));
        Self { machine, failing, left }
    }
}

impl Machine for Odd {
    fn handle(&mut self, now: Timestamp, frame: &Frame) {
        if frame.cob_id() == Some(0x601) && frame.data().starts_with(&[0x40, 0x00, 0x10, 0x00]) && !self.machine.dead {
            self.left = self.left.wrapping_sub(1);
            if self.left == 0 {
                match self.failing {
                    Failing::Once => return,
                    Failing::Dies => self.machine.dead = true,
                    Failing::Panics => std::panic::panic_any("divided by zero"),
                }
            }
        }
        self.machine.handle(now, frame);
    }

    fn poll_transmit(&mut self, now: Timestamp) -> Option<Frame> {
        self.machine.poll_transmit(now)
    }

    fn poll_timeout(&self) -> Option<Timestamp> {
        self.machine.poll_timeout()
    }

    fn handle_timeout(&mut self, now: Timestamp) {
        self.machine.handle_timeout(now);
    }
}

fn plan() -> Plan {
    Plan {
        targets: Target::Sdo.into(),
        seed: 2,
        allow: BTreeSet::new(),
        shrink_budget: 50,
        time: canvass_fuzzer::time_limit::TimeLimit::default(),
        stop_at_first: false,
        regressions: Vec::new(),
        only_regressions: false,
        corpus: Vec::new(),
    }
}

fn knowledge() -> Knowledge {
    let model = Model::by_id("reference-301").unwrap();
    Knowledge::new(NODE, Some(model.description()), Some(model.sheet()))
}

/// Fuzzes a live device with a reset before each sequence.
fn on_a_bus(failing: Failing, left: u32) -> Outcome {
    let mut bus = SimulatedBus::new(250_000);
    bus.attach(Box::new(Odd::new(failing, left)));
    campaign(&mut bus, knowledge(), &plan(), &mut |progress| progress.sequences < 40).unwrap()
}

#[test]
fn what_shows_once_only_is_told_so_with_its_trace() {
    let outcome = on_a_bus(Failing::Once, 16);
    let [found] = &outcome.violations[..] else { panic!("{:?}", outcome.violations) };
    assert!(!found.confirmed && !outcome.dead);
    assert_eq!(found.violation.property, Property::Responsive);
    let requests = found.evidence.iter().filter(|record| record.frame.cob_id() == Some(0x601)).count();
    assert!(requests >= found.sequence.stimuli.iter().filter(|s| s.frame.cob_id() == Some(0x601)).count());
    assert_eq!(outcome.sequences, 40, "the run goes on");
}

#[test]
fn a_device_that_does_not_come_back_is_dead() {
    let outcome = on_a_bus(Failing::Dies, 12);
    assert!(outcome.dead && outcome.sequences < 40);
    let last = outcome.violations.last().unwrap();
    assert_eq!(last.violation.property, Property::Alive);
    assert!(!last.evidence.is_empty(), "its last frames are known");
}

#[test]
fn a_panic_is_the_death_of_the_device() {
    let outcome = on_a_bus(Failing::Panics, 12);
    let last = outcome.violations.last().unwrap();
    assert!(last.violation.actual.contains("divided by zero"), "{:?}", last.violation);
    assert!(!last.evidence.is_empty());
}

/// A device that is made anew for each sequence panics each time, so that its sequence can be shrunk.
#[test]
fn a_panic_of_a_device_made_anew_is_shrunk() {
    let make = Box::new(|_| Box::new(Odd::new(Failing::Panics, 1_000)) as Box<dyn Machine>);
    let mut stand = Simulated::new(make, NODE, 250_000, Duration::from_secs(1), false);
    let outcome = run(&mut stand, knowledge(), &plan(), &mut |progress| progress.sequences < 10).unwrap();
    assert!(outcome.violations.is_empty(), "it does not read 1000h so often: {:?}", outcome.violations);
}

/// The fault of a live device is repeated and shrunk, too.
#[test]
fn a_fault_on_a_bus_is_confirmed_and_small() {
    let model = Model::by_id("reference-301").unwrap();
    let mut bus = SimulatedBus::new(250_000);
    bus.attach(Box::new(Device::new(model, Some(NODE), Fault::SdoToggleUnchecked, 0)));
    let plan = Plan { stop_at_first: true, ..plan() };
    let outcome = campaign(&mut bus, knowledge(), &plan, &mut |progress| progress.sequences < 500).unwrap();
    let [found] = &outcome.violations[..] else { panic!("{:?}", outcome.violations) };
    assert!(found.confirmed && found.sequence.stimuli.len() <= 8, "{found:?}");
}
