use crate::PerNode;
use crate::findings::rule::Rule;
use crate::findings::sink::{Report, Sink};
use crate::findings::{Context, Seen};
use crate::message::Service;
use canvass_macros::rule;
use canvass_traces::{Duration, Timestamp};

/// a node sends before its boot-up message
///
/// A node that an NMT command has reset sends another message (EMCY, heartbeat, PDO, SDO answer) before its boot-up
/// message. The rule ignores a boot-up message that comes much later, because it has another cause, and messages within
/// the grace time after the command, because they may have been queued.
///
/// # Why
/// The boot-up message reports that the node has left initialisation. A master does not evaluate messages of the node
/// before it, so they are lost; an EMCY that is lost then is not repeated.
///
/// # What to do
/// The device's firmware is faulty: it must send its boot-up message first (CiA 301, NMT slave states).
#[rule(id = "bus/before-boot-up", severity = Warning, rank = Detail, also = Resetting)]
struct BeforeBootUp {
    /// grace time for frames that were still queued
    #[threshold(ms = 100)]
    grace: Duration,
    /// a boot-up later than this does not belong to the reset
    #[threshold(ms = 10_000)]
    within: Duration,
    /// The first frame of each node since its reset.
    early: PerNode<Option<Box<Seen>>>,
}

impl Rule for BeforeBootUp {
    fn frame(&mut self, context: &Context<'_>, sink: &mut Sink<'_>) {
        let Some(node) = context.node() else { return };
        let reset = context.scene.facts.node(node).pending_reset;
        let early = &mut self.early[node];
        if context.decoded.service != Service::BootUp {
            let is_meant = context.decoded.service != Service::Guarding && context.decoded.is_from_node();
            let Some(reset) = reset.filter(|_| is_meant) else { return };
            if early.is_none() && context.now().since(reset) > self.grace {
                *early = Some(Box::new(context.seen()));
            }
            return;
        }
        let Some(early) = early.take() else { return };
        // The frame came after the last reset, and this boot-up came soon enough to belong to that reset.
        let answers = |reset: Timestamp| early.time() > reset && context.now().since(reset) <= self.within;
        if reset.is_some_and(answers) {
            let report = Report::at(early.time()).node(node).evidence(early.evidence()).evidence(context.evidence());
            sink.report(report, || {
                let ahead = context.now().since(early.time());
                format!("{} {ahead} before the boot-up message", early.decoded.service)
            });
        }
    }

    fn interrupted(&mut self) {
        self.early.reset();
    }
}
