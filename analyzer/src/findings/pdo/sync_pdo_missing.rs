use super::parameters::TPDOS;
use crate::NodeId;
use crate::findings::rule::{Definition, Metadata, Rule};
use crate::findings::sink::{Report, Sink};
use crate::findings::{Context, Scene, Seen, Severity};
use crate::message::{Message, PdoNumber, Service};
use crate::wire::error_control::State;

pub const RULE: Definition = Definition {
    metadata: &METADATA,
    services: &[Service::Sync, Service::Pdo, Service::Nmt],
    make: Some(|_| Box::new(SyncPdoMissing { since: vec![[None; TPDOS]; 128].into(), synchronous: Vec::new() })),
};

static METADATA: Metadata = Metadata {
    id: "pdo/sync-pdo-missing",
    severity: Severity::Error,
    title: "a synchronous PDO does not come with its SYNC",
    what: "The SDO traffic of the capture shows that a TPDO is synchronous and cyclic (transmission type 1 to 240), its \
           node is operational, it has come before, and now so many SYNC messages have passed without it; or it comes sooner than at every n-th SYNC, \
           again and again.",
    why: "The consumer works with the value of an earlier cycle, often without noticing.",
    advice: "If it comes after the next SYNC instead, the device is too slow for this cycle, or the bus is too full. If \
             it does not come at all, look at the node's state.",
    thresholds: &[],
};

struct SyncPdoMissing {
    /// The SYNC messages since the PDO last came; `None` before it came at all.
    since: Box<[[Option<u32>; TPDOS]]>,
    /// The PDOs that are synchronous and cyclic: node, number from 1, SYNC messages, and how often in a row they came
    /// too soon.
    synchronous: Vec<(NodeId, u16, u8, u8)>,
}

impl SyncPdoMissing {
    /// So many in a row that come too soon are no accident.
    const EARLY: u8 = 3;

    fn refresh(&mut self, node: NodeId, scene: &Scene<'_>) {
        self.since[usize::from(node.raw())].fill(None);
        self.synchronous.retain(|row| row.0 != node);
        for number in 1..=TPDOS as u16 {
            if let Some(cycle @ 1..=240) = scene.facts.tpdos.of(node, number).transmission_type {
                self.synchronous.push((node, number, cycle, 0));
            }
        }
    }

    /// A PDO after so many SYNC messages: that of every n-th SYNC must not come at others.
    fn early(&mut self, number: u16, passed: Option<u32>, context: &Context<'_>, sink: &mut Sink<'_>) {
        let Some(node) = context.node() else { return };
        let row = self.synchronous.iter_mut().find(|row| (row.0, row.1) == (node, number));
        let Some((_, _, cycle, early)) = row else { return };
        let is_early = passed.is_some_and(|passed| (1..u32::from(*cycle)).contains(&passed));
        *early = if is_early { early.saturating_add(1) } else { 0 };
        if *early >= Self::EARLY
            && let Some(passed) = passed
        {
            let report = Report::at(context.now()).node(node).detail(1 << 16 | u64::from(number));
            let report = report.evidence(context.previous.map(Seen::evidence)).evidence(context.evidence());
            sink.report(report, || format!("TPDO {number} comes at every {passed}. SYNC, it is due at every {cycle}."));
        }
    }

    fn sync(&mut self, context: &Context<'_>, sink: &mut Sink<'_>) {
        for &(node, number, cycle, _) in &self.synchronous {
            let slot = self.since[usize::from(node.raw())].get_mut(usize::from(number) - 1);
            let Some(Some(passed)) = slot else { continue };
            let state = context.scene.bus.node(node).and_then(|node| node.state);
            let storing = context.scene.facts.node(node).is_storing(context.now());
            if storing || state.is_none_or(|state| state.0 != State::OPERATIONAL) {
                *passed = 0;
                continue;
            }
            *passed += 1;
            // The PDO of this SYNC is still to come.
            if *passed == u32::from(cycle) + 1 {
                let report = Report::at(context.now()).node(node).detail(u64::from(number));
                sink.report(report.evidence(context.evidence()), || {
                    format!("TPDO {number} did not come with the SYNC before this one, it is due at every {cycle}.")
                });
            }
        }
    }
}

impl Rule for SyncPdoMissing {
    fn frame(&mut self, context: &Context<'_>, sink: &mut Sink<'_>) {
        match (context.decoded.service, context.message()) {
            (Service::Sync, Message::Sync(_)) => self.sync(context, sink),
            (Service::Nmt, _) if context.begins_anew() => self.interrupted(),
            (Service::Pdo, Message::Pdo(PdoNumber::Transmit(number))) => {
                let row = context.node().map(|node| &mut self.since[usize::from(node.raw())]);
                if let Some(slot) = row.and_then(|row| row.get_mut(usize::from(*number).saturating_sub(1))) {
                    let passed = slot.replace(0);
                    self.early(*number, passed, context, sink);
                }
            }
            _ => {}
        }
    }

    fn reconfigured(&mut self, node: NodeId, scene: &Scene<'_>) {
        self.refresh(node, scene);
    }

    fn interrupted(&mut self) {
        self.since.iter_mut().for_each(|row| row.fill(None));
    }
}
