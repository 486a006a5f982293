use crate::findings::rule::Rule;
use crate::findings::sink::{Report, Sink};
use crate::findings::{Context, Scene, Seen, Severity};
use crate::message::{Message, PdoNumber};
use crate::{NodeId, PerNode};
use canvass_macros::rule;
use canvass_traces::{Duration, Timestamp};

/// a request for a PDO gets no answer
///
/// A remote frame asks for a TPDO, and the TPDO does not come in time; or the next request comes first, where the node has
/// always answered much sooner. If the node has answered no request for this TPDO
/// in this capture before, it may not support requests: the severity is then info. After an NMT command or missing
/// frames the node counts as one that has answered none: a node that is not operational answers no request.
///
/// # Why
/// The consumer goes on with the last value, or takes the node for lost.
///
/// # What to do
/// If the node sends other messages, check two things: its NMT state, and bit 30 of 180xh:01. A node answers requests only
/// in operational, and only while this bit is 0.
#[rule(id = "pdo/request-unanswered", severity = Warning, rank = ProcessData, services = [Pdo, Nmt, BootUp])]
struct RequestUnanswered {
    /// timeout for an answer
    #[threshold(ms = 200)]
    wait: Duration,
    nodes: PerNode<Vec<Asked>>,
    /// Whether any request is unanswered.
    waits: bool,
}

/// A TPDO for which a remote frame has asked.
struct Asked {
    number: u16,
    /// The request, as long as it is unanswered.
    open: Option<Seen>,
    /// Number of requests that were answered.
    answers: u32,
    /// The longest time from a request to its answer.
    slowest: Duration,
}

impl Asked {
    /// Number of answers from which the time that the node takes is known.
    const KNOWN: u32 = 10;

    /// Takes the request, if the node has always answered much sooner: the next request then asks again.
    fn give_up_at(&mut self, now: Timestamp) -> Option<Seen> {
        let limit = self.slowest.times(10) + Duration::from_millis(20);
        self.open.take_if(|open| self.answers >= Self::KNOWN && now.since(open.time()) > limit)
    }

    fn answered(&mut self, now: Timestamp) {
        let Some(open) = self.open.take() else { return };
        self.answers = self.answers.saturating_add(1);
        self.slowest = self.slowest.max(now.since(open.time()));
    }

    fn tell(&self, node: NodeId, request: &Seen, sink: &mut Sink<'_>, when: &str) {
        let report = Report::at(request.time()).node(node).detail(u64::from(self.number));
        let report = if self.answers > 0 { report } else { report.severity(Severity::Info) };
        sink.report(report.evidence(request.evidence()), || format!("no {} {when}", PdoNumber::Transmit(self.number)));
    }
}

impl RequestUnanswered {
    fn asked(&mut self, node: NodeId, number: u16, context: &Context<'_>, sink: &mut Sink<'_>) {
        self.give_up(node, context.scene, sink);
        let rows = &mut self.nodes[node];
        self.waits = true;
        let Some(row) = rows.iter_mut().find(|row| row.number == number) else {
            return rows.push(Asked { number, open: Some(context.seen()), answers: 0, slowest: Duration::ZERO });
        };
        let unanswered = row.give_up_at(context.now());
        row.open = row.open.take().or_else(|| Some(context.seen()));
        if let Some(request) = unanswered.filter(|_| context.scene.facts.must_send(node, context.now())) {
            let when = format!("before the next request for it; else it comes within {}", row.slowest);
            row.tell(node, &request, sink, &when);
        }
    }

    /// Reports the requests to a node that have waited for too long.
    fn give_up(&mut self, node: NodeId, scene: &Scene<'_>, sink: &mut Sink<'_>) {
        let limit = self.wait + scene.slack();
        for row in &mut self.nodes[node] {
            let is_late = row.open.as_ref().is_some_and(|open| scene.now.since(open.time()) > limit);
            let due = row.open.take_if(|_| is_late).filter(|_| scene.facts.must_send(node, scene.now));
            if let Some(request) = due {
                row.tell(node, &request, sink, &format!("within {} of the request for it", self.wait));
            }
        }
    }

    fn forget(&mut self, node: u8) {
        let rows = self.nodes.named_mut(node).flat_map(|(_, rows)| rows.iter_mut());
        rows.for_each(|row| row.open = None);
    }
}

impl Rule for RequestUnanswered {
    fn frame(&mut self, context: &Context<'_>, sink: &mut Sink<'_>) {
        match (context.message(), context.node()) {
            (Message::Nmt(nmt), _) => self.forget(nmt.node),
            (Message::ErrorControl(_), Some(node)) => self.forget(node.raw()),
            (Message::PdoRequest(PdoNumber::Transmit(number)), Some(node)) => self.asked(node, *number, context, sink),
            (Message::Pdo(PdoNumber::Transmit(number)) | Message::Mpdo(PdoNumber::Transmit(number), _), Some(node))
                if self.waits =>
            {
                if let Some(row) = self.nodes[node].iter_mut().find(|row| row.number == *number) {
                    row.answered(context.now());
                }
            }
            _ => {}
        }
    }

    fn tick(&mut self, scene: &Scene<'_>, sink: &mut Sink<'_>) {
        if !self.waits {
            return;
        }
        NodeId::all().for_each(|node| self.give_up(node, scene, sink));
        self.waits = self.nodes.iter().any(|(_, rows)| rows.iter().any(|row| row.open.is_some()));
    }

    fn interrupted(&mut self) {
        self.forget(0);
    }
}
