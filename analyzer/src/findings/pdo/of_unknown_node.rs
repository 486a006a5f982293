use crate::NodeId;
use crate::findings::facts::{Stream, StreamEvent};
use crate::findings::rule::Rule;
use crate::findings::sink::{Report, Sink};
use crate::findings::{Context, Scene, Seen, Severity};
use crate::message::{Message, PdoNumber};
use canvass_macros::rule;
use canvass_traces::{Duration, Timestamp};

/// a PDO appears of a node that sends nothing else
///
/// In the middle of the capture a PDO appears. Its CAN-ID belongs to a node that sends no boot-up, no heartbeat, no SDO
/// response and no other PDO, and the SDO traffic assigns the CAN-ID to no other node. The finding is an information. It is a
/// warning if a periodic PDO of another node with the same length ended at this moment: then this PDO has moved to another
/// CAN-ID.
///
/// # Why
/// A device may send with a wrong CAN-ID: its consumers miss the PDO, and consumers of this CAN-ID take it for their own.
///
/// # What to do
/// Find the node that stops sending at this time, and read its objects 180xh:1 and 140xh:1.
#[rule(id = "pdo/of-unknown-node", severity = Warning, rank = ProcessData, also = UnusualPdos)]
struct OfUnknownNode {
    appeared: Vec<Appeared>,
}

/// The first frame of a PDO.
struct Appeared {
    node: NodeId,
    pdo: PdoNumber,
    frame: Seen,
}

/// Maximum number of PDOs that are kept.
const MOST: usize = 32;
/// Time in which PDOs appear because the network starts.
const START: Duration = Duration::from_secs(5);

impl Appeared {
    /// Whether the PDO is the only message of the node.
    fn is_unknown(&self, scene: &Scene<'_>) -> bool {
        let facts = scene.facts.node(self.node);
        let is_own = |time| time == self.frame.time();
        let is_silent = match self.pdo {
            PdoNumber::Transmit(_) => facts.first_seen.is_some_and(is_own),
            PdoNumber::Receive(_) => facts.first_seen.is_none(),
        };
        is_silent && facts.last_boot_up.is_none() && facts.last_operational.is_none() && facts.last_download.is_none()
    }

    /// Whether a PDO of another node ended as this one appeared: it had a period, and the next frame would have been due.
    fn replaces(&self, (node, _, stream): &(NodeId, u16, &Stream), scene: &Scene<'_>) -> bool {
        let at = self.frame.time();
        let is_same_length = usize::from(stream.usual_length()) == self.frame.record.frame.data().len();
        let ended = stream.last.zip(stream.period()).filter(|(last, _)| *last <= at);
        let is_due = |(last, period): (Timestamp, Duration)| {
            // A PDO of which the capture shows only the begin has perhaps not ended the other one.
            at.since(last) <= period.times(3) && scene.now.since(at) > period.times(10)
        };
        *node != self.node && is_same_length && ended.is_some_and(is_due)
    }

    /// The PDO of another node that this one replaces; `None` if several may be it.
    fn before(&self, scene: &Scene<'_>) -> Option<(NodeId, PdoNumber)> {
        let streams = &scene.facts.streams;
        let mut replaced: Vec<(NodeId, PdoNumber)> = match self.pdo {
            PdoNumber::Transmit(_) => {
                let ended = streams.all().filter(|row| self.replaces(row, scene));
                ended.map(|(node, number, _)| (node, PdoNumber::Transmit(number))).collect()
            }
            PdoNumber::Receive(_) => {
                let ended = streams.received().filter(|row| self.replaces(row, scene));
                ended.map(|(node, number, _)| (node, PdoNumber::Receive(number))).collect()
            }
        };
        replaced.pop().filter(|_| replaced.is_empty())
    }

    fn tell(&self, scene: &Scene<'_>, sink: &mut Sink<'_>) {
        let Self { node, pdo, frame } = self;
        let moved = self.before(scene);
        let kind = u64::from(matches!(pdo, PdoNumber::Receive(_)));
        let report = Report::at(frame.time()).node(*node).detail(kind << 16 | u64::from(frame.record.frame.id().raw()));
        let report = if moved.is_some() { report } else { report.severity(Severity::Info) };
        sink.report(report.evidence(frame.evidence()), || {
            let nothing = format!("{pdo} appears, the only message of node {}", node.raw());
            let other = moved.map(|(other, old)| format!("; {old} of node {} ended just before", other.raw()));
            nothing + &other.unwrap_or_default()
        });
    }
}

impl Rule for OfUnknownNode {
    fn frame(&mut self, context: &Context<'_>, _: &mut Sink<'_>) {
        let (Some(node), &Message::Pdo(pdo)) = (context.node(), context.message()) else { return };
        let is_new = context.news().stream == StreamEvent::New;
        let is_early = context.now().since(context.scene.start) < START;
        if is_new && !is_early && self.appeared.len() < MOST {
            self.appeared.push(Appeared { node, pdo, frame: context.seen() });
        }
    }

    fn finish(&mut self, scene: &Scene<'_>, sink: &mut Sink<'_>) {
        // Where nodes show no other sign at all, one more of them is no news.
        let others = NodeId::all().map(|node| scene.facts.node(node));
        if !others.into_iter().any(|facts| facts.last_boot_up.is_some() || facts.last_operational.is_some()) {
            return;
        }
        for appeared in self.appeared.iter().filter(|appeared| appeared.is_unknown(scene)) {
            appeared.tell(scene, sink);
        }
    }
}
