use crate::NodeId;
use crate::findings::facts::{Reasons, Stream, StreamEvent};
use crate::findings::rule::Rule;
use crate::findings::sink::{Report, Sink};
use crate::findings::{Context, Percent, Scene, Seen};
use crate::message::{Message, PdoNumber};
use canvass_macros::rule;
use canvass_traces::{Duration, Timestamp};

/// a cyclic PDO to a node does not come any more
///
/// An RPDO stays away for many of its periods while the node that receives it is operational. Its period is learned: 30
/// regular intervals, some of them with unchanged data, so that a timer has sent it and no event. The silence lasts
/// until the capture ends, or until the RPDO has its period again. It is not judged where SYNC or a TPDO of the node is
/// silent at the same time: then both sides have stopped.
///
/// # Why
/// The node goes on with its last set values, or goes to its safe state if it monitors the RPDO (140xh:5).
///
/// # What to do
/// Find the sender of the CAN-ID, and see its state and its other messages at that time.
#[rule(id = "pdo/received-ended", severity = Warning, rank = ProcessData, also = UnusualPdos)]
struct ReceivedEnded {
    /// a silence beyond this share of the period is reported
    #[threshold(percent = 1000)]
    percent: Percent,
    /// a shorter silence is not reported
    #[threshold(ms = 1000)]
    least: Duration,
    pauses: Vec<Pause>,
}

/// A silence after which the RPDO came again.
struct Pause {
    node: NodeId,
    number: u16,
    since: Timestamp,
    period: Duration,
    /// The last frame before the pause and the first after it.
    frames: [Option<Seen>; 2],
}

/// Maximum number of pauses that wait for the next frames.
const MOST: usize = 64;

impl ReceivedEnded {
    fn is_long(&self, silence: Duration, period: Duration, scene: &Scene<'_>) -> bool {
        silence > self.percent.of(period) + scene.slack() && silence > self.least
    }

    /// Keeps a pause until the RPDO has its period again.
    fn resumed(&mut self, pdo: (NodeId, u16), since: Timestamp, period: Duration, context: &Context<'_>) {
        let silence = context.now().since(since);
        let is_judged = self.is_long(silence, period, context.scene) && is_due(pdo.0, since, period, context.scene);
        if is_judged && self.pauses.len() < MOST {
            let frames = [context.previous.cloned(), Some(context.seen())];
            self.pauses.push(Pause { node: pdo.0, number: pdo.1, since, period, frames });
        }
    }

    fn returned(&mut self, pdo: (NodeId, u16), sink: &mut Sink<'_>) {
        for pause in self.pauses.extract_if(.., |pause| (pause.node, pause.number) == pdo) {
            let Pause { node, number, since, period, frames: [before, after] } = pause;
            let until = after.as_ref().map_or(since, Seen::time);
            let report = Report::at(since).until(until).node(node).detail(u64::from(number));
            let report =
                report.evidence(before.as_ref().map(Seen::evidence)).evidence(after.as_ref().map(Seen::evidence));
            let (pdo, length) = (PdoNumber::Receive(number), until.since(since));
            sink.report(report, || format!("{pdo} stayed away for {length}; before it came every {period}"));
        }
    }
}

/// Whether the node was there to receive the RPDO, and neither SYNC nor its own TPDOs were silent too.
fn is_due(node: NodeId, since: Timestamp, period: Duration, scene: &Scene<'_>) -> bool {
    let margin = period.times(2) + Duration::from_secs(2);
    let reasons = Reasons { sync: scene.facts.streams.reasons(node).sync, ..Reasons::default() };
    let near = |at: Timestamp| at.since(since).max(since.since(at)) <= margin;
    let is_silent = |stream: &Stream| {
        let last = stream.last.filter(|last| near(*last) && scene.now.since(*last) > margin);
        last.is_some() && stream.period().is_some() || stream.resumed_since().is_some_and(near)
    };
    let mut own = scene.facts.streams.all().filter(|row| row.0 == node);
    let with_others = own.any(|(_, _, stream)| is_silent(stream));
    scene.facts.must_send(node, scene.now) && !with_others && !reasons.explain(since, scene.now, margin)
}

impl Rule for ReceivedEnded {
    fn frame(&mut self, context: &Context<'_>, sink: &mut Sink<'_>) {
        let (Message::Pdo(PdoNumber::Receive(number)), Some(node)) = (context.message(), context.node()) else {
            return;
        };
        match context.news().stream {
            StreamEvent::Resumed { since, period } => self.resumed((node, *number), since, period, context),
            StreamEvent::Returned => self.returned((node, *number), sink),
            _ => {}
        }
    }

    fn finish(&mut self, scene: &Scene<'_>, sink: &mut Sink<'_>) {
        let open = |(node, number, stream): (NodeId, u16, &Stream)| {
            Some((node, number, stream.can_id, stream.last?, stream.period()?))
        };
        for (node, number, can_id, last, period) in scene.facts.streams.received().filter_map(open) {
            let silence = scene.now.since(last);
            if !self.is_long(silence, period, scene) || !is_due(node, last, period, scene) {
                continue;
            }
            let frame = scene.latest.get(can_id).filter(|seen| seen.time() == last).map(Seen::evidence);
            let report = Report::at(last).until(scene.now).node(node).detail(u64::from(number)).evidence(frame);
            let pdo = PdoNumber::Receive(number);
            sink.report(report, || {
                format!("{pdo} does not come for the last {silence} of the capture; before it came every {period}")
            });
        }
    }
}
