use crate::findings::facts::TPDOS;
use crate::findings::rule::Rule;
use crate::findings::sink::{Report, Sink};
use crate::findings::{Context, Scene, Seen};
use crate::message::{Message, PdoNumber, Service};
use crate::wire::error_control::State;
use crate::{NodeId, PerNode};
use canvass_macros::rule;

/// a synchronous PDO does not come with its SYNC
///
/// More SYNC messages pass without a TPDO than its transmission type allows, or the TPDO repeatedly comes sooner than
/// at every n-th SYNC. The rule judges TPDOs of operational nodes that were sent before, and that the SDO traffic of
/// the capture shows as synchronous and cyclic (transmission type 1 to 240).
///
/// # Why
/// The consumer works with the value of an earlier cycle, often without noticing.
///
/// # What to do
/// If the PDO comes after the next SYNC instead, the device is too slow for this cycle, or the bus is too full. If it
/// does not come at all, check the state of the node.
#[rule(id = "pdo/sync-pdo-missing", severity = Error, rank = ProcessData, services = [Sync, Nmt], also = KnownTpdos)]
struct SyncPdoMissing {
    /// The TPDOs of each node, by their number from 0.
    pdos: PerNode<[Pdo; TPDOS]>,
    /// The synchronous cyclic TPDOs: node, number from 1.
    synchronous: Vec<(NodeId, u16)>,
}

/// The state of a TPDO.
#[derive(Clone, Copy, Default)]
struct Pdo {
    /// Number of SYNC messages since the TPDO last came; `None` before it has come at all.
    since: Option<u32>,
    /// The number n if the TPDO is due with every n-th SYNC; 0 if the TPDO is not synchronous and cyclic.
    cycle: u8,
    /// Number of consecutive times that the TPDO came too soon.
    early: u8,
}

impl SyncPdoMissing {
    /// Number of consecutive times after which a TPDO that comes too soon is reported.
    const EARLY: u8 = 3;

    fn refresh(&mut self, node: NodeId, scene: &Scene<'_>) {
        self.synchronous.retain(|row| row.0 != node);
        for (pdo, number) in self.pdos[node].iter_mut().zip(1..) {
            *pdo = Pdo::default();
            if let Some(cycle @ 1..=240) = scene.facts.tpdos.of(node, number).transmission_type {
                pdo.cycle = cycle;
                self.synchronous.push((node, number));
            }
        }
    }

    /// Checks a PDO against the SYNC messages before it: a PDO of every n-th SYNC must not come with the SYNC messages
    /// in between.
    fn pdo(&mut self, node: NodeId, number: u16, context: &Context<'_>, sink: &mut Sink<'_>) {
        let Some(pdo) = pdo_mut(&mut self.pdos, node, number) else { return };
        let passed = pdo.since.replace(0);
        let early = passed.filter(|passed| (1..u32::from(pdo.cycle)).contains(passed));
        pdo.early = early.map_or(0, |_| pdo.early.saturating_add(1));
        if let Some(passed) = early.filter(|_| pdo.early >= Self::EARLY) {
            let report = Report::at(context.now()).node(node).detail(1 << 16 | u64::from(number));
            let report = report.evidence(context.previous.map(Seen::evidence)).evidence(context.evidence());
            let cycle = pdo.cycle;
            sink.report(report, || {
                format!("TPDO {number} comes at every {passed}. SYNC, but it is due at every {cycle}.")
            });
        }
    }

    fn sync(&mut self, context: &Context<'_>, sink: &mut Sink<'_>) {
        for &(node, number) in &self.synchronous {
            let Some(pdo) = pdo_mut(&mut self.pdos, node, number) else { continue };
            let Some(passed) = &mut pdo.since else { continue };
            let state = context.scene.bus.node(node).and_then(|node| node.state);
            let storing = context.scene.facts.node(node).is_storing(context.now());
            if storing || state.is_none_or(|state| state.0 != State::OPERATIONAL) {
                *passed = 0;
                continue;
            }
            *passed += 1;
            // The PDO of this SYNC may still come.
            if *passed == u32::from(pdo.cycle) + 1 {
                let cycle = pdo.cycle;
                let report = Report::at(context.now()).node(node).detail(u64::from(number));
                sink.report(report.evidence(context.evidence()), || {
                    format!("TPDO {number} did not come with the SYNC before this one, but it is due at every {cycle}.")
                });
            }
        }
    }
}

/// The state of a TPDO; `None` for TPDOs beyond the first [`TPDOS`].
fn pdo_mut(pdos: &mut PerNode<[Pdo; TPDOS]>, node: NodeId, number: u16) -> Option<&mut Pdo> {
    pdos[node].get_mut(usize::from(number).checked_sub(1)?)
}

impl Rule for SyncPdoMissing {
    fn frame(&mut self, context: &Context<'_>, sink: &mut Sink<'_>) {
        match (context.decoded.service, context.message()) {
            (Service::Sync, Message::Sync(_)) => self.sync(context, sink),
            (Service::Nmt, _) if context.begins_anew() => self.interrupted(),
            (Service::Pdo, Message::Pdo(PdoNumber::Transmit(number))) => {
                if let Some(node) = context.node() {
                    self.pdo(node, *number, context, sink);
                }
            }
            _ => {}
        }
    }

    fn reconfigured(&mut self, node: NodeId, scene: &Scene<'_>) {
        self.refresh(node, scene);
    }

    fn interrupted(&mut self) {
        self.pdos.values_mut().flatten().for_each(|pdo| pdo.since = None);
    }
}
