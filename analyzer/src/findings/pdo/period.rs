use crate::findings::facts::TPDOS;
use crate::findings::rule::Rule;
use crate::findings::sink::{Report, Sink};
use crate::findings::{Context, Percent, Scene, Seen};
use crate::message::Service;
use crate::object;
use crate::wire::error_control::State;
use crate::{NodeId, PerNode};
use canvass_macros::rule;
use canvass_traces::{Duration, Timestamp};

/// a cyclic PDO comes later than its event timer demands
///
/// The SDO traffic of the capture shows the event timer (180xh:5) of an event-driven TPDO, and the time between two
/// transmissions of it in operational is longer. The measurement starts again after NMT commands, resets and changes of
/// the parameters.
///
/// # Why
/// The consumer works with old values. A consumer that monitors the PDO (RPDO event timer) detects an error.
///
/// # What to do
/// Check the bus load and the priority of the PDO (a high CAN-ID is a low priority). If the bus is not full, the device
/// does not keep its cycle.
#[rule(
    id = "pdo/period",
    severity = Warning,
    rank = ProcessData,
    services = [Nmt],
    also = [KnownTpdos, EndedTransfers]
)]
struct Period {
    /// an interval beyond this share of the event timer is late
    #[threshold(percent = 150)]
    percent: Percent,
    /// a smaller delay is not reported
    #[threshold(ms = 5)]
    least: Duration,
    last: PerNode<[Option<Timestamp>; TPDOS]>,
}

impl Rule for Period {
    fn frame(&mut self, context: &Context<'_>, sink: &mut Sink<'_>) {
        match context.decoded.service {
            Service::Nmt if context.begins_anew() => return self.interrupted(),
            Service::Sdo => {
                // Some devices are silent while they store.
                let stored = context.decoded.object.is_some_and(|object| {
                    matches!(object.index.0, object::STORE_PARAMETERS | object::RESTORE_DEFAULT_PARAMETERS)
                });
                if let Some(node) = context.node().filter(|_| stored) {
                    self.last[node].fill(None);
                }
                return;
            }
            _ => {}
        }
        let Some((node, number, parameters)) = context.tpdo() else { return };
        let timed = matches!(parameters.transmission_type, Some(254 | 255));
        let (Some(timer), true) = (parameters.event_timer, timed) else { return };
        let operational = context.scene.bus.node(node).and_then(|node| node.state);
        let slot = self.last[node].get_mut(usize::from(number) - 1);
        let Some(last) = slot.and_then(|slot| slot.replace(context.now())) else { return };
        let interval = context.now().since(last);
        let limit = self.percent.of(timer) + self.least + context.scene.slack();
        let storing = context.scene.facts.node(node).is_storing(context.now());
        if interval <= limit || storing || operational.is_none_or(|state| state.0 != State::OPERATIONAL) {
            return;
        }
        let report = Report::at(last).node(node).detail(u64::from(number)).measure(interval.nanos());
        let report = report.evidence(context.previous.map(Seen::evidence)).evidence(context.evidence());
        sink.report(report, || format!("TPDO {number} after {interval}, but its event timer is {timer}"));
    }

    fn reconfigured(&mut self, node: NodeId, _: &Scene<'_>) {
        self.last[node].fill(None);
    }

    fn interrupted(&mut self) {
        self.last.reset();
    }
}
