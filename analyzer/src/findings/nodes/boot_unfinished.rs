use crate::findings::effect::{Effect, SETTLE};
use crate::findings::rule::Rule;
use crate::findings::sink::{Report, Sink};
use crate::findings::{Context, Scene, Seen, Severity};
use crate::message::{Message, Service};
use crate::network::sdo::{Direction, Outcome, Transfer};
use crate::object;
use crate::wire::error_control::State;
use crate::wire::nmt::{Command, Nmt};
use crate::wire::sync;
use crate::{Multiplexer, NodeId, PerNode};
use canvass_macros::rule;
use canvass_traces::{Duration, Timestamp};
use std::fmt::Write;

/// Causes: the master waits for an answer, or got a refusal.
const FOLLOWS: &[(&str, Effect)] = &[
    ("sdo/unanswered", Effect::on(&["nodes/boot-unfinished"]).of_same_node().during(SETTLE, SETTLE)),
    ("sdo/aborted", Effect::on(&["nodes/boot-unfinished"]).of_same_node().during(SETTLE, SETTLE)),
];

/// the boot of a node stands still
///
/// The NMT master has begun to boot a node after its boot-up, as CiA 302-2 describes it: it has read the device type
/// (1000h) or the identity (1018h), and may have configured the node and its error control. Then nothing more is done for
/// the node: it is not started until the capture ends, while SYNC goes on or other nodes are operational. The finding
/// names the last step, what is missing, and the nodes that have booted too and for which nothing was done. Where the
/// capture goes on with other things, a node whose boot was begun and that is still not started after ten seconds is an
/// information: its master may leave it like that.
///
/// # Why
/// The network does not come up: the node waits in pre-operational for its master, and with it all nodes after it.
///
/// # What to do
/// Compare the values read with what the master's configuration expects (1F84h to 1F88h): another device type, vendor,
/// product or revision stops the boot of this node. See in the master's log which node is mandatory (1F81h), and whether
/// the master itself starts nodes (1F80h, bit 3).
#[rule(
    id = "nodes/boot-unfinished",
    severity = Warning,
    rank = State,
    services = [Nmt, BootUp],
    also = EndedTransfers,
    follows = FOLLOWS
)]
struct BootUnfinished {
    /// shortest time without a step that counts; at least twenty times the longest time between two steps
    #[threshold(ms = 100)]
    wait: Duration,
    nodes: PerNode<Option<Box<Boot>>>,
    /// The node and the time of the last step.
    last: Option<(NodeId, Timestamp)>,
    /// The longest time between two steps.
    pace: Duration,
}

/// The steps that the NMT master has done for a node since the boot-up message of the node.
struct Boot {
    boot_up: Seen,
    /// Whether its device type was read.
    device_type: bool,
    /// The read sub-indexes of its identity, as bits.
    identity: u8,
    /// Number of objects written.
    written: u32,
    /// Whether its heartbeat or guarding was configured.
    monitored: bool,
    /// The object of the last transfer, if it was aborted.
    refused: Option<Multiplexer>,
}

impl Boot {
    fn of(boot_up: Seen) -> Box<Self> {
        let (device_type, identity, written, monitored, refused) = (false, 0, 0, false, None);
        Box::new(Self { boot_up, device_type, identity, written, monitored, refused })
    }

    /// Whether the master has begun to boot the node.
    const fn is_begun(&self) -> bool {
        self.device_type || self.identity != 0
    }

    fn step(&mut self, transfer: &Transfer) {
        let object = transfer.multiplexer;
        self.refused = Some(object).filter(|_| matches!(transfer.outcome, Outcome::Aborted(..)));
        if transfer.outcome != Outcome::Complete {
            return;
        }
        match (transfer.direction, object.index.0) {
            (Direction::Upload, object::DEVICE_TYPE) => self.device_type = true,
            (Direction::Upload, object::IDENTITY) => {
                self.identity |= 1_u8.checked_shl(object.sub.0.into()).unwrap_or(0);
            }
            (Direction::Download, index) => {
                self.written += 1;
                self.monitored |= MONITORING.contains(&index);
            }
            _ => {}
        }
    }

    /// The steps done and those missing, in words.
    fn words(&self) -> String {
        let mut text = String::from("after its boot-up");
        // Writing to a string can't fail.
        if self.device_type {
            text.push_str(", its device type (1000h) was read");
        }
        if self.identity != 0 {
            let subs = (1..5).filter(|sub| self.identity >> sub & 1 != 0).map(|sub| format!("{sub:02X}"));
            let _ = write!(text, ", its identity was read (1018h:{})", subs.collect::<Vec<_>>().join(", "));
        }
        if self.written > 0 {
            let _ = write!(text, ", {} objects were written", self.written);
        }
        if let Some(object) = self.refused {
            let _ = write!(text, ", the access to {object} was refused");
        }
        let missing = match (self.written > 0, self.monitored) {
            (false, _) => "it was neither configured nor started",
            (true, false) => "its error control was not configured, and it was not started",
            (true, true) => "it was not started",
        };
        let _ = write!(text, "; {missing}");
        text
    }
}

/// A node whose boot was begun this long ago, and that is not started, is left as it is.
const LEFT: Duration = Duration::from_secs(10);

/// The objects that configure heartbeat and guarding of a node.
const MONITORING: [u16; 3] = [object::PRODUCER_HEARTBEAT_TIME, object::GUARD_TIME, object::LIFE_TIME_FACTOR];

impl BootUnfinished {
    fn commanded(&mut self, nmt: Nmt) {
        // A node that is started has finished its boot, and a reset begins another one.
        if nmt.command == Command::START || nmt.command.is_reset() {
            self.nodes.reset_named(nmt.node);
        }
        if nmt.command.is_reset() {
            self.last = None;
        }
    }

    /// The nodes that have booted and were not started, without `node`: those for which `has_steps` is so.
    fn waiting(&self, node: NodeId, has_steps: bool, scene: &Scene<'_>) -> Vec<NodeId> {
        let waits = |boot: &Boot| boot.is_begun() == has_steps;
        let rows = self.nodes.iter().filter(|(_, boot)| boot.as_deref().is_some_and(waits));
        rows.map(|row| row.0).filter(|other| *other != node && !is_operational(*other, scene)).collect()
    }

    /// The boot of a node that was begun and has stood still since this time, and what goes on meanwhile.
    fn stands_still(
        &self,
        (node, at): (NodeId, Timestamp),
        wait: Duration,
        scene: &Scene<'_>,
    ) -> Option<(&Boot, &'static str)> {
        let boot = self.nodes[node].as_deref().filter(|boot| boot.is_begun())?;
        let sync = scene.latest.get(sync::CAN_ID).filter(|seen| seen.decoded.service == Service::Sync);
        let goes_on = match sync {
            Some(sync) if sync.time().since(at) > wait => "SYNC goes on",
            _ if NodeId::all().any(|other| other != node && is_operational(other, scene)) => {
                "other nodes are operational"
            }
            _ => return None,
        };
        let is_still = scene.now.since(at) > wait && !is_operational(node, scene);
        is_still.then_some((boot, goes_on))
    }

    fn tell(
        &self,
        (node, at): (NodeId, Timestamp),
        boot: &Boot,
        goes_on: &str,
        severity: Severity,
        scene: &Scene<'_>,
        sink: &mut Sink<'_>,
    ) {
        let last = scene.latest.get(crate::wire::sdo::RESPONSE_BASE + u16::from(node.raw()));
        let report = Report::at(at).until(scene.now).node(node).severity(severity).evidence(boot.boot_up.evidence());
        let report = report.evidence(last.filter(|seen| seen.time() == at).map(Seen::evidence));
        sink.report(report, || {
            let silence = scene.now.since(at);
            let mut text = format!("{} in the {silence} until the capture ends, while {goes_on}", boot.words());
            for (has_steps, what) in [(true, "not started either"), (false, "nothing was done for")] {
                let others = self.waiting(node, has_steps, scene);
                if !others.is_empty() {
                    let _ = write!(text, "; {what}: {}", names(&others));
                }
            }
            text
        });
    }
}

fn is_operational(node: NodeId, scene: &Scene<'_>) -> bool {
    let state = scene.bus.node(node).and_then(|known| known.state);
    state.is_some_and(|state| state.0 == State::OPERATIONAL)
}

fn names(nodes: &[NodeId]) -> String {
    const SHOWN: usize = 8;
    let shown: Vec<String> = nodes.iter().take(SHOWN).map(ToString::to_string).collect();
    let more = nodes.len().saturating_sub(SHOWN);
    let more = if more > 0 { format!(" and {more} more") } else { String::new() };
    format!("{} {}{more}", if nodes.len() == 1 { "node" } else { "nodes" }, shown.join(", "))
}

impl Rule for BootUnfinished {
    fn frame(&mut self, context: &Context<'_>, _: &mut Sink<'_>) {
        if let Message::Nmt(nmt) = *context.message() {
            return self.commanded(nmt);
        }
        let Some(node) = context.node() else { return };
        if context.decoded.service == Service::BootUp {
            self.nodes[node] = Some(Boot::of(context.seen()));
            return;
        }
        let (Some(boot), Some(channel)) = (&mut self.nodes[node], context.decoded.channel) else { return };
        if let Some(transfer) = context.scene.bus.transfer(channel) {
            boot.step(transfer);
            if let Some((_, before)) = self.last.replace((node, context.now())) {
                self.pace = self.pace.max(context.now().since(before));
            }
        }
    }

    fn interrupted(&mut self) {
        self.nodes.reset();
        self.last = None;
    }

    fn finish(&mut self, scene: &Scene<'_>, sink: &mut Sink<'_>) {
        let wait = self.wait.max(self.pace.times(20));
        let last = self.last.filter(|row| self.stands_still(*row, wait, scene).is_some());
        if let Some((row, (boot, goes_on))) = last.and_then(|row| Some((row, self.stands_still(row, wait, scene)?))) {
            self.tell(row, boot, goes_on, Severity::Warning, scene, sink);
        }
        for (node, boot) in self.nodes.iter().filter(|(node, _)| last.is_none_or(|row| row.0 != *node)) {
            let Some(at) = boot.as_deref().map(|boot| boot.boot_up.time()) else { continue };
            if let Some((boot, goes_on)) = self.stands_still((node, at), LEFT, scene) {
                self.tell((node, at), boot, goes_on, Severity::Info, scene, sink);
            }
        }
    }
}
