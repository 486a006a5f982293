//! The fuzzer sends nothing that the user has not allowed.

use canvass_analyzer::NodeId;
use canvass_bus::SimulatedBus;
use canvass_bus::{Bus, BusError};
use canvass_device::Device;
use canvass_device::Faults;
use canvass_device::models::Model;
use canvass_fuzzer::campaign::{Plan, campaign};
use canvass_fuzzer::{Knowledge, Target, limits};
use canvass_traces::{Frame, Record, Timestamp};
use std::collections::BTreeSet;

/// A bus that keeps the sent frames.
struct Watched {
    bus: SimulatedBus,
    sent: Vec<Frame>,
}

impl Bus for Watched {
    fn now(&self) -> Timestamp {
        self.bus.now()
    }

    fn send(&mut self, frame: &Frame) -> Result<(), BusError> {
        self.sent.push(*frame);
        self.bus.send(frame)
    }

    fn receive(&mut self, deadline: Timestamp) -> Result<Option<Record>, BusError> {
        self.bus.receive(deadline)
    }

    fn bit_rate(&self) -> Option<u32> {
        self.bus.bit_rate()
    }
}

#[test]
fn a_device_on_a_bus_is_not_worn_out_renamed_or_given_company() {
    for model in ["reference-301", "kuebler-sendix-58x8", "kuebler-c100"].map(|id| Model::by_id(id).unwrap()) {
        let node = model.default_node().unwrap_or(NodeId::MIN);
        let mut bus = Watched { bus: SimulatedBus::new(250_000), sent: Vec::new() };
        bus.bus.attach(Box::new(Device::new(model, Some(node), Faults::NONE, 0)));
        let knowledge = Knowledge::new(node, Some(model.description()), Some(model.sheet()));
        let plan = Plan {
            targets: Target::All.into(),
            seed: 5,
            allow: BTreeSet::new(),
            shrink_budget: 10,
            time: canvass_fuzzer::time_limit::TimeLimit::default(),
            stop_at_first: false,
            regressions: Vec::new(),
            only_regressions: false,
            corpus: Vec::new(),
        };
        let outcome =
            campaign(&mut bus, knowledge.clone(), &plan, &mut |progress| progress.executions < 4_000).unwrap();
        assert!(outcome.executions >= 4_000 && bus.sent.len() >= 4_000);
        for frame in &bus.sent {
            assert_eq!(limits::of(frame, &knowledge, &BTreeSet::new()), None, "{frame}");
            let data = frame.data();
            assert!(!data.windows(4).any(|window| window == b"save" || window == b"load"), "{frame}");
        }
    }
}
