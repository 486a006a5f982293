use super::parameters::TPDOS;
use crate::NodeId;
use crate::findings::rule::{Also, Definition, Metadata, Rule, Threshold};
use crate::findings::sink::{Report, Sink};
use crate::findings::{Context, Scene, Seen, Severity};
use crate::message::Service;
use crate::network::Event;
use crate::wire::error_control::State;
use canvass_traces::{Duration, Timestamp};

pub const RULE: Definition = Definition {
    metadata: &METADATA,
    services: &[Service::Sdo, Service::Nmt],
    also: Also::KnownTpdos,
    make: Some(|thresholds| {
        Box::new(Period {
            percent: thresholds.get(&METADATA, "percent"),
            least: Duration::from_millis(thresholds.get(&METADATA, "least")),
            last: vec![[None; TPDOS]; 128].into(),
        })
    }),
};

static METADATA: Metadata = Metadata {
    id: "pdo/period",
    severity: Severity::Warning,
    title: "a cyclic PDO comes later than its event timer says",
    what: "The SDO traffic of the capture shows an event timer (180xh:5) of an event-driven TPDO, and in operational \
           two of these PDOs are further apart. NMT commands, resets and changes of the parameters begin anew.",
    why: "The consumer works with old values; one that monitors the PDO (RPDO event timer) sees an error.",
    advice: "Look at the bus load and at how high the PDO's CAN-ID is. If the bus is not full, the device does not keep \
             its own cycle.",
    thresholds: &[
        Threshold { name: "percent", default: 150, unit: "%", meaning: "of the event timer; later is late" },
        Threshold { name: "least", default: 5, unit: "ms", meaning: "being late by less is not reported" },
    ],
};

struct Period {
    percent: u64,
    least: Duration,
    last: Box<[[Option<Timestamp>; TPDOS]]>,
}

impl Rule for Period {
    fn frame(&mut self, context: &Context<'_>, sink: &mut Sink<'_>) {
        match context.decoded.service {
            Service::Nmt if context.begins_anew() => return self.interrupted(),
            Service::Sdo if context.decoded.event == Some(Event::TransferEnded) => {
                // Some devices are silent while they store.
                let node = context.node().map_or(0, |node| node.raw());
                if context.decoded.object.is_some_and(|object| matches!(object.index.0, 0x1010 | 0x1011)) {
                    self.last[usize::from(node)].fill(None);
                }
                return;
            }
            _ => {}
        }
        let Some((node, number, parameters)) = context.tpdo() else { return };
        let timed = matches!(parameters.transmission_type, Some(254 | 255));
        let (Some(timer), true) = (parameters.event_timer, timed) else { return };
        let operational = context.scene.bus.node(node).and_then(|node| node.state);
        let slot = self.last[usize::from(node.raw())].get_mut(usize::from(number) - 1);
        let Some(last) = slot.and_then(|slot| slot.replace(context.now())) else { return };
        let interval = context.now().since(last);
        let limit = Duration(timer.nanos() * self.percent / 100) + self.least + context.scene.slack();
        let storing = context.scene.facts.node(node).is_storing(context.now());
        if interval <= limit || storing || operational.is_none_or(|state| state.0 != State::OPERATIONAL) {
            return;
        }
        let report = Report::at(last).node(node).detail(u64::from(number)).measure(interval.nanos());
        let report = report.evidence(context.previous.map(Seen::evidence)).evidence(context.evidence());
        sink.report(report, || format!("TPDO {number} after {interval}, its event timer is {timer}"));
    }

    fn reconfigured(&mut self, node: NodeId, _: &Scene<'_>) {
        self.last[usize::from(node.raw())].fill(None);
    }

    fn interrupted(&mut self) {
        self.last.iter_mut().for_each(|row| row.fill(None));
    }
}
