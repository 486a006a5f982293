use crate::findings::facts::TPDOS;
use crate::findings::rule::Rule;
use crate::findings::sink::{Report, Sink};
use crate::findings::{Context, Percent, Scene, Seen};
use crate::{NodeId, PerNode};
use canvass_macros::rule;
use canvass_traces::{Duration, Timestamp};

/// a PDO is sent again within its inhibit time
///
/// The SDO traffic of the capture shows the inhibit time (180xh:3) of a TPDO, and two transmissions of this TPDO follow
/// each other faster.
///
/// # Why
/// The inhibit time keeps the bus free for other nodes. A device that ignores it can fill the bus when its value
/// changes.
///
/// # What to do
/// Check that the inhibit time was written while the PDO was switched off, because some devices accept it only then. If
/// it was, the device's firmware is faulty.
#[rule(id = "pdo/inhibit-time", severity = Error, rank = Detail, services = [Nmt], also = KnownTpdos)]
struct InhibitTime {
    /// an interval below this share of the inhibit time is reported
    #[threshold(percent = 90, max = 100)]
    percent: Percent,
    /// tolerance for waiting on the bus and in the recorder
    #[threshold(us = 1000)]
    tolerance: Duration,
    last: PerNode<[Option<Timestamp>; TPDOS]>,
}

impl Rule for InhibitTime {
    fn frame(&mut self, context: &Context<'_>, sink: &mut Sink<'_>) {
        if context.begins_anew() {
            return self.interrupted();
        }
        let Some((node, number, parameters)) = context.tpdo() else { return };
        // The inhibit time concerns event-driven PDOs, not synchronous or requested ones.
        if !matches!(parameters.transmission_type, None | Some(254 | 255)) {
            return;
        }
        let Some(inhibit) = parameters.inhibit else { return };
        let slot = self.last[node].get_mut(usize::from(number) - 1);
        let last = slot.and_then(|slot| slot.replace(context.now())).filter(|_| context.scene.has_times());
        let Some(last) = last else { return };
        let interval = context.now().since(last);
        // The first of two PDOs may have waited for the bus, which shortens the interval.
        let waiting = self.tolerance.max(context.scene.longest_frame().times(2));
        let tolerated = interval + waiting + context.scene.slack();
        if tolerated.nanos() >= self.percent.of(inhibit).nanos() {
            return;
        }
        let worse = inhibit.nanos().saturating_sub(interval.nanos());
        let report = Report::at(context.now()).node(node).detail(u64::from(number)).measure(worse);
        let report = report.evidence(context.previous.map(Seen::evidence)).evidence(context.evidence());
        sink.report(report, || format!("TPDO {number} after {interval}, but its inhibit time is {inhibit}"));
    }

    fn reconfigured(&mut self, node: NodeId, _: &Scene<'_>) {
        self.last[node].fill(None);
    }

    fn interrupted(&mut self) {
        self.last.reset();
    }
}
