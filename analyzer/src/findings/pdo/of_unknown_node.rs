use crate::NodeId;
use crate::findings::facts::{Stream, StreamEvent};
use crate::findings::rule::Rule;
use crate::findings::sink::{Report, Sink};
use crate::findings::{Context, Scene, Seen, Severity};
use crate::message::{Message, PdoNumber};
use canvass_macros::rule;
use canvass_traces::Duration;

/// a PDO appears of a node that does nothing else
///
/// In the middle of the capture a PDO appears whose CAN-ID belongs to a node that sends no boot-up, heartbeat or answer, nor
/// another PDO; and no COB-ID in the SDO traffic of the capture explains the CAN-ID. If a PDO of another node with the same
/// length stayed away at this moment, and does not come again, the finding is a warning: it has moved to another CAN-ID.
/// Otherwise it is an information.
///
/// # Why
/// A device may send with a wrong CAN-ID: its consumers miss the PDO, and consumers of this CAN-ID take it for their own.
///
/// # What to do
/// Find the sender: see which node stops sending at this time, and read 180xh:1 and 140xh:1 of this node.
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
/// Time after the begin of the capture in which PDOs appear, as the network starts.
const START: Duration = Duration::from_secs(5);
/// Longest time between the last frame of a PDO and its first frame on another CAN-ID.
const MOVED: Duration = Duration::from_secs(5);

impl Appeared {
    /// Whether the node has shown no other sign of itself.
    fn is_unknown(&self, scene: &Scene<'_>) -> bool {
        let facts = scene.facts.node(self.node);
        let is_own = |time| time == self.frame.time();
        let is_silent = match self.pdo {
            PdoNumber::Transmit(_) => facts.first_seen.is_some_and(is_own),
            PdoNumber::Receive(_) => facts.first_seen.is_none(),
        };
        is_silent && facts.last_boot_up.is_none() && facts.last_operational.is_none() && facts.last_download.is_none()
    }

    /// The PDO of another node that ended as this one appeared.
    fn before<'a>(&self, scene: &Scene<'a>) -> Option<(NodeId, PdoNumber, &'a Stream)> {
        // A PDO of which the capture shows only the begin has perhaps not ended the other one.
        if scene.now.since(self.frame.time()) <= MOVED {
            return None;
        }
        let streams = &scene.facts.streams;
        let length = self.frame.record.frame.data().len();
        let has_moved = |stream: &Stream| {
            let last = stream.last.filter(|_| usize::from(stream.usual_length()) == length);
            last.is_some_and(|last| last <= self.frame.time() && self.frame.time().since(last) <= MOVED)
        };
        let row = |(node, number, stream), pdo: fn(u16) -> PdoNumber| (node, pdo(number), stream);
        let all: Box<dyn Iterator<Item = _>> = match self.pdo {
            PdoNumber::Transmit(_) => Box::new(streams.all().map(move |all| row(all, PdoNumber::Transmit))),
            PdoNumber::Receive(_) => Box::new(streams.received().map(move |all| row(all, PdoNumber::Receive))),
        };
        let mut moved = all.filter(|(node, _, stream)| *node != self.node && has_moved(stream));
        // If several fit, nobody knows which one it was.
        moved.next().filter(|_| moved.next().is_none())
    }

    fn tell(&self, scene: &Scene<'_>, sink: &mut Sink<'_>) {
        let Self { node, pdo, frame } = self;
        let moved = self.before(scene);
        let kind = u64::from(matches!(pdo, PdoNumber::Receive(_)));
        let report = Report::at(frame.time()).node(*node).detail(kind << 16 | u64::from(frame.record.frame.id().raw()));
        let report = if moved.is_some() { report } else { report.severity(Severity::Info) };
        sink.report(report.evidence(frame.evidence()), || {
            let nothing = format!("{pdo} appears, and nothing else of node {}", node.raw());
            let other = moved.map(|(other, old, _)| format!("; {old} of node {} ended just before", other.raw()));
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
