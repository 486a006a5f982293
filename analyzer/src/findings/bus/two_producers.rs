use super::interleaving::Interleaving;
use crate::findings::effect::Effect;
use crate::findings::facts::{StreamEvent, TPDOS};
use crate::findings::rule::Rule;
use crate::findings::sink::{Report, Sink};
use crate::findings::{Context, Scene, Seen, Severity};
use crate::message::{Message, PdoNumber};
use crate::wire::sync::Sync;
use crate::{NodeId, PerNode};
use canvass_macros::rule;
use canvass_traces::Duration;

/// Two times differ if they are further apart than the period divided by this number.
const NEAR: u64 = 20;

/// Rules whose findings follow from two producers of SYNC, TIME or a TPDO.
const EFFECTS: &[Effect] = &[
    Effect::on(&["pdo/sync-counter", "pdo/sync-jitter", "pdo/sync-missing"]),
    Effect::on(&["pdo/sync-pdo-missing", "pdo/sync-window", "pdo/time-jump"]),
    Effect::on(&["pdo/length-changed"]).of_same_node(),
];

/// two nodes produce on one CAN-ID
///
/// SYNC or TIME comes at intervals that alternate between a long and a short one, again and again, or two series of
/// SYNC counters are mixed: there are two producers with the same period. A TPDO that the SDO traffic of the capture
/// shows to be cyclic comes twice in its cycle, again and again: after each SYNC, or within its event timer at
/// intervals that together are the event timer. Where nothing is known of a PDO, its period is learned: a PDO that
/// then comes twice in each period, at intervals that together are the period, has probably two senders.
///
/// # Why
/// All synchronous actions happen twice in a cycle, at changing distances. Consumers of a PDO take the values of two
/// devices for the values of one. When both producers send at the same moment, they disturb each other.
///
/// # What to do
/// Read 1005h of all nodes: bit 30 must be set in one node only. Read 180xh:1 of all nodes: each CAN-ID must occur once
/// only. A configuration tool that was left connected is a frequent second producer of SYNC.
#[rule(
    id = "bus/two-producers",
    severity = Error,
    rank = Participants,
    services = [Sync, Time, Nmt],
    also = [KnownTpdos, UnusualPdos],
    leads_to = EFFECTS
)]
struct TwoProducers {
    sync: Interleaving,
    time: Interleaving,
    counters: Counters,
    /// The TPDOs of each node, by their number from 0.
    pdos: PerNode<[Option<Pdo>; TPDOS]>,
    /// The TPDOs seen since the last SYNC: node, number from 1.
    seen: Vec<(NodeId, u16)>,
}

/// A TPDO that may have two producers.
#[derive(Clone, Copy, Default)]
struct Pdo {
    interleaving: Interleaving,
    /// Number of frames of this TPDO since the last SYNC.
    since_sync: u8,
    /// Number of consecutive cycles with two frames of this TPDO.
    twice: u8,
}

/// Two interleaved series of SYNC counters.
#[derive(Default)]
struct Counters {
    /// The last value of each series, the later one first.
    last: [Option<u8>; 2],
    changes: u32,
}

impl Counters {
    /// Number of changes between the series that prove two producers.
    const ENOUGH: u32 = 8;

    /// Adds a counter; returns whether two series are mixed.
    fn see(&mut self, sync: Sync) -> bool {
        let Some(counter) = sync.counter else { return false };
        let follows = |last: Option<u8>| last.is_some_and(|last| last.checked_add(1) == Some(counter));
        let [own, other] = self.last;
        if follows(own) || counter == 1 {
            self.last[0] = Some(counter);
        } else if follows(other) {
            self.last = [Some(counter), own];
            self.changes += 1;
        } else {
            *self = Self { last: [Some(counter), own], changes: 0 };
        }
        self.changes >= Self::ENOUGH
    }
}

impl TwoProducers {
    /// Number of consecutive cycles with a second PDO that prove two producers.
    const CYCLES: u8 = 5;

    fn sync(&mut self, sync: Sync, context: &Context<'_>, sink: &mut Sink<'_>) {
        let report = || {
            let report = Report::at(context.now());
            report.evidence(context.previous.map(Seen::evidence)).evidence(context.evidence())
        };
        if let Some((a, b)) = self.sync.beat(context.now(), context.scene.slack()) {
            sink.report(report(), || format!("SYNC comes after {a} and after {b} in turn: two producers of {}", a + b));
        } else if self.counters.see(sync) {
            sink.report(report(), || "two series of SYNC counters in turn: two producers".to_owned());
        }
        for &(node, number) in &self.seen {
            if let Some(Some(pdo)) = slot(&mut self.pdos, node, number) {
                pdo.twice = if pdo.since_sync < 2 { 0 } else { pdo.twice };
                pdo.since_sync = 0;
            }
        }
    }

    fn pdo(&mut self, node: NodeId, number: u16, context: &Context<'_>, sink: &mut Sink<'_>) {
        let parameters = context.scene.facts.tpdos.of(node, number);
        let cyclic = matches!(parameters.transmission_type, Some(1..=240));
        let timer = parameters.event_timer.filter(|_| matches!(parameters.transmission_type, Some(254 | 255)));
        if !cyclic && timer.is_none() {
            return;
        }
        let Some(slot) = slot(&mut self.pdos, node, number) else { return };
        if slot.is_none() {
            self.seen.push((node, number));
        }
        let pdo = slot.get_or_insert_default();
        let report = || {
            let report = Report::at(context.now()).node(node).detail(u64::from(number));
            report.evidence(context.previous.map(Seen::evidence)).evidence(context.evidence())
        };
        if cyclic {
            pdo.since_sync = pdo.since_sync.saturating_add(1);
            pdo.twice += u8::from(pdo.since_sync == 2 && pdo.twice < Self::CYCLES);
            if pdo.since_sync == 2 && pdo.twice >= Self::CYCLES {
                sink.report(report(), || format!("TPDO {number} comes twice after each SYNC: two devices send it"));
            }
            return;
        }
        let (Some((a, b)), Some(timer)) = (pdo.interleaving.beat(context.now(), context.scene.slack()), timer) else {
            return;
        };
        let off = (a + b).nanos().abs_diff(timer.nanos());
        if off <= timer.nanos() / NEAR + Duration::from_millis(1).nanos() {
            sink.report(report(), || {
                format!(
                    "TPDO {number} comes after {a} and after {b} in turn, its event timer is {timer}: two devices \
                     send it"
                )
            });
        }
    }

    /// Reports a PDO whose learned period is divided into the same two parts again and again.
    fn learned(node: NodeId, pdo: PdoNumber, context: &Context<'_>, sink: &mut Sink<'_>) {
        let StreamEvent::Divided { first, second } = context.news().stream else { return };
        let detail = match pdo {
            PdoNumber::Transmit(number) if context.scene.facts.tpdos.of(node, number).is_known() => return,
            PdoNumber::Transmit(number) => u64::from(number),
            PdoNumber::Receive(number) => 1 << 17 | u64::from(number),
        };
        let report = Report::at(context.now()).node(node).detail(detail).severity(Severity::Warning);
        let report = report.evidence(context.previous.map(Seen::evidence)).evidence(context.evidence());
        sink.report(report, || {
            let turns = format!("after {first} and after {second} in turn");
            format!("{pdo} came every {}, and now {turns}: two devices send it", first + second)
        });
    }

    fn restart(&mut self) {
        self.sync.restart();
        self.time.restart();
        self.counters = Counters::default();
        for (node, number) in self.seen.drain(..) {
            if let Some(slot) = slot(&mut self.pdos, node, number) {
                *slot = None;
            }
        }
    }
}

/// The entry of TPDO `number`; `None` for TPDOs beyond the first [`TPDOS`].
fn slot(pdos: &mut PerNode<[Option<Pdo>; TPDOS]>, node: NodeId, number: u16) -> Option<&mut Option<Pdo>> {
    pdos[node].get_mut(usize::from(number).checked_sub(1)?)
}

impl Rule for TwoProducers {
    fn frame(&mut self, context: &Context<'_>, sink: &mut Sink<'_>) {
        match context.message() {
            Message::Sync(sync) => self.sync(*sync, context, sink),
            Message::Time(_) => {
                let Some((a, b)) = self.time.beat(context.now(), context.scene.slack()) else { return };
                let report = Report::at(context.now()).detail(1 << 16);
                let report = report.evidence(context.previous.map(Seen::evidence)).evidence(context.evidence());
                sink.report(report, || {
                    format!("TIME comes after {a} and after {b} in turn: two producers of {}", a + b)
                });
            }
            Message::Pdo(PdoNumber::Transmit(number)) => {
                if let Some(node) = context.node() {
                    Self::learned(node, PdoNumber::Transmit(*number), context, sink);
                    self.pdo(node, *number, context, sink);
                }
            }
            Message::Pdo(pdo @ PdoNumber::Receive(_)) => {
                if let Some(node) = context.node() {
                    Self::learned(node, *pdo, context, sink);
                }
            }
            _ if context.begins_anew() => self.restart(),
            _ => {}
        }
    }

    fn reconfigured(&mut self, node: NodeId, _: &Scene<'_>) {
        self.pdos[node] = Default::default();
        self.seen.retain(|seen| seen.0 != node);
    }

    fn interrupted(&mut self) {
        self.restart();
    }
}
