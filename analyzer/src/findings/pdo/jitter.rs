use crate::findings::facts::TPDOS;
use crate::findings::rule::Rule;
use crate::findings::sink::{Report, Sink};
use crate::findings::{Context, Percent, Scene, Seen};
use crate::message::Service;
use crate::wire::error_control::State;
use crate::{NodeId, PerNode};
use canvass_macros::rule;
use canvass_traces::{Duration, Timestamp};

/// a cyclic PDO is irregular
///
/// The SDO traffic of the capture shows an event timer (180xh:5, or the timer of its device profile) of an event-driven
/// TPDO, and more than the given share of the intervals exceed it by more than the allowed jitter. Shorter intervals
/// are no jitter, because an event may send the PDO before its timer does. Delays that pdo/period reports are not
/// counted.
///
/// # Why
/// Controllers that rely on the cycle calculate wrong speeds, and cascaded control loops become unsteady.
///
/// # What to do
/// Compare with other nodes: if all their PDOs are irregular, the cause is the bus load or the recorder. If the PDOs of
/// a single node are irregular, its firmware keeps the cycle badly, or the cycle is too short for the device at this
/// bit rate.
#[rule(id = "pdo/jitter", severity = Warning, rank = Detail, services = [Nmt], also = KnownTpdos)]
struct Jitter {
    /// excess over the event timer, in percent, that counts
    #[threshold(percent = 20)]
    percent: Percent,
    /// a smaller delay is never counted
    #[threshold(us = 2000)]
    least: Duration,
    /// share of late intervals that is reported
    #[threshold(percent = 10)]
    share: Percent,
    rows: PerNode<[Cycle; TPDOS]>,
}

/// One cyclic PDO.
#[derive(Default)]
struct Cycle {
    last: Option<Timestamp>,
    timer: Duration,
    intervals: u64,
    late: u64,
    worst: Option<Box<(Duration, Seen, Seen)>>,
}

impl Cycle {
    /// Least number of intervals for a judgement.
    const ENOUGH: u64 = 20;

    fn beat(&mut self, context: &Context<'_>, timer: Duration, limit: Duration) {
        if self.timer != timer {
            *self = Self { timer, ..Self::default() };
        }
        let Some(last) = self.last.replace(context.now()) else { return };
        let interval = context.now().since(last);
        // Beyond one and a half periods a PDO is missing, not jittering.
        if interval > Duration(timer.nanos() * 3 / 2) + limit {
            return;
        }
        self.intervals += 1;
        if interval <= timer + limit {
            return;
        }
        self.late += 1;
        let off = Duration(interval.nanos() - timer.nanos());
        if self.worst.as_ref().is_none_or(|worst| off > worst.0)
            && let Some(previous) = context.previous
        {
            self.worst = Some(Box::new((off, previous.clone(), context.seen())));
        }
    }
}

impl Rule for Jitter {
    fn frame(&mut self, context: &Context<'_>, _: &mut Sink<'_>) {
        if context.decoded.service == Service::Nmt {
            if context.begins_anew() {
                self.interrupted();
            }
            return;
        }
        let Some((node, number, parameters)) = context.tpdo() else { return };
        let (Some(timer), Some(254 | 255)) = (parameters.event_timer, parameters.transmission_type) else { return };
        let Some(row) = self.rows[node].get_mut(usize::from(number) - 1) else { return };
        let operational = context.scene.bus.node(node).and_then(|node| node.state);
        let known = operational.is_some_and(|state| state.0 == State::OPERATIONAL);
        if !known || context.scene.facts.node(node).is_storing(context.now()) {
            row.last = None;
        }
        let limit = self.percent.of(timer) + self.least.max(context.scene.longest_frame());
        row.beat(context, timer, limit + context.scene.slack());
    }

    fn reconfigured(&mut self, node: NodeId, _: &Scene<'_>) {
        self.rows[node].iter_mut().for_each(|row| row.last = None);
    }

    fn interrupted(&mut self) {
        self.rows.values_mut().flatten().for_each(|row| row.last = None);
    }

    fn finish(&mut self, _: &Scene<'_>, sink: &mut Sink<'_>) {
        for (node, rows) in self.rows.iter() {
            for (number, row) in (1_u64..).zip(rows) {
                let share = Percent(row.late * 100 / row.intervals.max(1));
                let Some(worst) = row.worst.as_deref().filter(|_| share > self.share) else { continue };
                let (off, before, after) = worst;
                if row.intervals >= Cycle::ENOUGH {
                    let report = Report::at(after.time()).node(node).detail(number);
                    sink.report(report.evidence(before.evidence()).evidence(after.evidence()), || {
                        let timer = row.timer;
                        format!("{share} of TPDO {number} come late, by at most {off}; its event timer is {timer}")
                    });
                }
            }
        }
    }
}
