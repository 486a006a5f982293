use crate::dictionary::names;
use crate::findings::effect::Effect;
use crate::findings::rule::Rule;
use crate::findings::seen::Evidence;
use crate::findings::sink::{Report, Sink};
use crate::findings::{Context, Scene, Seen, Severity};
use crate::message::Message;
use crate::object;
use crate::{Multiplexer, NodeId, PerNode};
use canvass_macros::rule;
use canvass_traces::Duration;

const DEVICE_TYPE: Multiplexer = Multiplexer::new(object::DEVICE_TYPE, 0);

/// Effects: nodes that miss the lost node.
const EFFECTS: &[Effect] = &[Effect::on(&["nodes/consumer-time"]).of_origin()];

/// Whether the profile lets a device of this type (1000h) start without a boot-up message, so that none is expected.
fn may_be_silent(device_type: u32) -> bool {
    names::known_profile(device_type as u16).is_some_and(|profile| profile.may_be_silent(device_type))
}

/// a node does not come back after a reset
///
/// A node that was on the bus is reset by an NMT command, and sends no message until the capture ends. A node that
/// sends other messages again, but no boot-up, is reported only if it has sent a boot-up before, because old devices
/// and the devices of some profiles send none. The rule does not report a device whose profile allows its device type
/// (1000h) to start silently, if no request reaches it after the reset; a device that returns with a node-ID that LSS
/// has assigned; and the NMT master, which does not receive its own commands to all nodes.
///
/// # Why
/// The node is no longer available: it hangs in initialisation, has changed its node-ID or bit rate, or can't send its
/// boot-up message.
///
/// # What to do
/// Look for a new node-ID on the bus. If there is none, check the device itself.
#[rule(id = "nodes/no-boot-up", severity = Error, rank = Loss, services = [Nmt], leads_to = EFFECTS)]
struct NoBootUp {
    /// timeout for the boot-up after a reset
    #[threshold(ms = 5000)]
    wait: Duration,
    /// The last reset command to each single node.
    resets: PerNode<Option<Box<Seen>>>,
    /// The last reset command to all nodes.
    reset_of_all: Option<Seen>,
}

impl NoBootUp {
    fn reset_of(&self, node: NodeId) -> Option<Evidence<'_>> {
        let own = self.resets[node].as_deref();
        let last = own.into_iter().chain(&self.reset_of_all).max_by_key(|reset| reset.time());
        last.map(Seen::evidence)
    }
}

impl NoBootUp {
    /// Whether the reset was meant for the node: the NMT master does not hear its own command to all nodes. A node
    /// whose heartbeat has ended with the command has heard it.
    fn concerns(&self, node: NodeId, sends_heartbeat: bool, scene: &Scene<'_>) -> bool {
        self.resets[node].is_some() || sends_heartbeat || scene.facts.node(node).is_slave
    }
}

impl Rule for NoBootUp {
    fn frame(&mut self, context: &Context<'_>, _: &mut Sink<'_>) {
        let Message::Nmt(nmt) = context.message() else { return };
        if nmt.command.is_reset() {
            match NodeId::new(nmt.node) {
                Some(node) => self.resets[node] = Some(Box::new(context.seen())),
                None if nmt.node == 0 => self.reset_of_all = Some(context.seen()),
                None => {}
            }
        }
    }

    fn finish(&mut self, scene: &Scene<'_>, sink: &mut Sink<'_>) {
        for node in NodeId::all() {
            let facts = scene.facts.node(node);
            let (Some(reset), Some(seen), false) = (facts.pending_reset, facts.last_seen, facts.has_moved) else {
                continue;
            };
            let device_type = scene.bus.node(node).and_then(|known| known.parameter(node, DEVICE_TYPE));
            let is_silent = device_type.is_some_and(may_be_silent);
            let period = scene.facts.heartbeats.of(node).period();
            // A node that continues without a pause is reported as disobeying the command.
            let paused = period.is_none_or(|period| facts.longest_pause > period + Duration(period.nanos() / 10));
            let waited = scene.now.since(reset) > self.wait;
            // An outage that began before the reset has a finding of its own.
            if scene.facts.outage(node, scene.now).is_some() {
                continue;
            }
            if !is_silent && waited && facts.is_silent_since_reset() && self.concerns(node, period.is_some(), scene) {
                sink.report(Report::at(reset).node(node).evidence(self.reset_of(node)), || {
                    format!("nothing more was received in the {} after its reset", scene.now.since(reset))
                });
            } else if waited && paused && facts.is_slave && facts.last_boot_up.is_some() && seen > reset + self.wait {
                let report = Report::at(reset).node(node).severity(Severity::Warning).evidence(self.reset_of(node));
                sink.report(report, || {
                    "it sends again after its reset, but no boot-up message, unlike before".to_owned()
                });
            }
        }
    }
}
