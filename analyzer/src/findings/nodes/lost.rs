use crate::findings::effect::{Effect, MONITORING, SETTLE, SOON};
use crate::findings::facts::{Orders, Outage, Sign};
use crate::findings::rule::Rule;
use crate::findings::sink::{Report, Sink};
use crate::findings::{Context, Scene, Seen};
use crate::message::{Message, Service};
use crate::wire::nmt::Command;
use crate::{NodeId, PerNode};
use canvass_macros::rule;
use canvass_traces::{Duration, Timestamp};

/// Effects: findings about nodes that miss the lost node, and about messages of the lost node before and after.
const EFFECTS: &[Effect] = &[
    Effect::never_on(&["nodes/lost", "bus/load", "bus/duplicate-node-id", "lss/left-in-configuration"]),
    Effect::on(&["nodes/consumer-time"]).of_origin().during(SOON, SOON),
    Effect::on(&["pdo/sync-missing"]).during(SOON, Duration::ZERO),
    Effect::on(&["capture/error-frames", "capture/error-passive"]).during(SETTLE, SETTLE),
    // The node's last messages may tell the reason.
    Effect::on(&["emcy/raised"]).of_same_node().during(SETTLE, SETTLE),
    Effect::on(&["emcy/raised"]).of_others().with_codes(MONITORING).during(Duration::ZERO, SOON),
    Effect::on(&["nodes/state-lost"]).of_same_node().during(SOON, SETTLE),
    Effect::on(&["nodes/state-lost"]).of_others().during(Duration::ZERO, SOON),
    Effect::on_the_rest().of_same_node().during(SOON, SETTLE),
];

/// a node drops out
///
/// A node that has sent regular heartbeats, or has answered guarding, sends no message for at least three of its
/// periods. All outages of a node are one finding, with their begin, their duration, the reaction of the master and
/// their end. Actions of the master during an outage do not explain it: a reset explains only the silence after it. The
/// rule does not count silences in which a node writes its memory or is configured by LSS, or in which all nodes are
/// silent.
///
/// # Why
/// Nodes that wait for this node or its data stop, or work with old values. All other findings of the node at that time
/// follow from the outage.
///
/// # What to do
/// A node that returns with a boot-up had no supply or was reset by its watchdog: measure its supply. A node that
/// returns without a boot-up was disconnected: check its connector, and error frames around that time. If several nodes
/// drop out together, check what they share.
#[rule(id = "nodes/lost", severity = Error, rank = Loss, also = Returning, leads_to = EFFECTS)]
struct Lost {
    nodes: PerNode<Losses>,
}

/// Number of outages of a node.
#[derive(Default)]
struct Losses {
    times: u64,
    total: Duration,
    longest: Duration,
    /// Number of outages in which the master reset the node.
    reset: u64,
    first: String,
}

/// The end of an outage.
#[derive(Clone, Copy, PartialEq, Eq)]
enum End {
    /// A boot-up caused by a reset, this long after the reset.
    Reset(Duration),
    /// A boot-up without a reset.
    BootUp,
    /// Any other frame.
    Frame,
    /// The outage lasts until the capture ends.
    Open,
}

impl Losses {
    /// Adds an outage; returns the text about all outages.
    fn add(&mut self, outage: &Outage, length: Duration, end: End, last: Option<&Seen>) -> String {
        let words = words(outage, length, end, last);
        self.times += 1;
        self.total = self.total + length;
        self.longest = self.longest.max(length);
        self.reset += u64::from(outage.orders.resets > 0);
        if self.times == 1 {
            self.first = words;
            return self.first.clone();
        }
        let Self { times, total, longest, reset, first } = self;
        let reset = match *reset {
            0 => String::new(),
            all if all == *times => ", each time reset by the master".to_owned(),
            1 => ", once reset by the master".to_owned(),
            some => format!(", {some} times reset by the master"),
        };
        format!("dropped out {times} times{reset}, at most for {longest}, for {total} together; the first time {first}")
    }
}

/// The text of one outage.
fn words(outage: &Outage, length: Duration, end: End, last: Option<&Seen>) -> String {
    let (sign, period) = match outage.sign {
        Sign::Heartbeat(period) => ("its heartbeat period is", period),
        Sign::Guarding(interval) => ("it is guarded every", interval),
    };
    let missing = length.nanos() / period.nanos().max(1);
    let last = last.map(|last| format!("; the last from it was {}", what(last))).unwrap_or_default();
    let orders = orders(outage, matches!(end, End::Reset(_)));
    let end = match end {
        End::Reset(after) => format!("; back {after} after a reset"),
        End::BootUp => "; it restarted by itself".to_owned(),
        End::Frame => "; back by itself without a boot-up".to_owned(),
        End::Open => "; not back when the capture ends".to_owned(),
    };
    format!("silent for {length} ({sign} {period}: {missing} missing){last}{orders}{end}")
}

/// The text of the master's reaction.
fn orders(outage: &Outage, helped: bool) -> String {
    let Orders { resets, first_reset, last, .. } = outage.orders;
    let after = |then: Timestamp| then.since(outage.since);
    match (resets, first_reset, last) {
        (0, _, Some((command, at))) => format!("; told to {} after {}", verb(command), after(at)),
        (1, Some(at), _) if helped => format!("; reset after {}", after(at)),
        (1, Some(at), _) => format!("; reset after {} without effect", after(at)),
        (n, Some(at), _) if helped => {
            format!("; {} of {n} resets without effect, the first after {}", n - 1, after(at))
        }
        (n, Some(at), _) => format!("; {n} resets without effect, the first after {}", after(at)),
        _ => String::new(),
    }
}

const fn verb(command: Command) -> &'static str {
    match command {
        Command::START => "start",
        Command::STOP => "stop",
        Command::ENTER_PRE_OPERATIONAL => "enter pre-operational",
        _ => "do something",
    }
}

/// The last frame of a node, in a few words.
fn what(last: &Seen) -> String {
    match (last.decoded.service, last.decoded.message) {
        (Service::Heartbeat | Service::Guarding, Message::ErrorControl(message)) => {
            format!("a {} that said {}", last.decoded.service, message.state)
        }
        (Service::Emcy, Message::Emcy(emcy)) => format!("EMCY {emcy}"),
        (service, _) => format!("a frame of {service}"),
    }
}

impl Lost {
    fn tell(
        &mut self,
        node: NodeId,
        outage: &Outage,
        next: Option<&Context<'_>>,
        scene: &Scene<'_>,
        sink: &mut Sink<'_>,
    ) {
        let length = scene.now.since(outage.since);
        // With a coarse clock, two steps may be longer than all periods.
        let (Sign::Heartbeat(period) | Sign::Guarding(period)) = outage.sign;
        if length <= period.times(3) + scene.slack() && scene.slack() > Duration::ZERO {
            return;
        }
        let restarts = next.is_some_and(|context| context.decoded.service == Service::BootUp);
        let limit = scene.facts.presence.restart_limit(node);
        let reset = outage.orders.last_reset.map(|reset| scene.now.since(reset)).filter(|after| *after <= limit);
        let end = match (next, reset) {
            (None, _) => End::Open,
            (Some(_), Some(after)) => End::Reset(after),
            (Some(_), None) if restarts => End::BootUp,
            (Some(_), None) => End::Frame,
        };
        let last = scene.facts.node(node).last_id.and_then(|id| scene.latest.get(id));
        let losses = &mut self.nodes[node];
        let message = losses.add(outage, length, end, last);
        let report = Report::at(outage.since).until(scene.now).node(node).measure(losses.times);
        let report = report.evidence(last.map(Seen::evidence)).evidence(next.map(Context::evidence));
        sink.report(report, || message);
    }
}

impl Rule for Lost {
    fn frame(&mut self, context: &Context<'_>, sink: &mut Sink<'_>) {
        let (Some(node), Some(outage)) = (context.node(), &context.news().returned) else { return };
        self.tell(node, outage, Some(context), context.scene, sink);
    }

    fn finish(&mut self, scene: &Scene<'_>, sink: &mut Sink<'_>) {
        for node in NodeId::all() {
            if let Some(outage) = scene.facts.outage(node, scene.now) {
                self.tell(node, &outage, None, scene, sink);
            }
        }
    }
}
