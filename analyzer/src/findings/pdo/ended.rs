use crate::NodeId;
use crate::findings::facts::StreamEvent;
use crate::findings::rule::Rule;
use crate::findings::sink::{Report, Sink};
use crate::findings::{Context, Percent, Scene, Seen, Severity};
use crate::message::PdoNumber;
use crate::wire::error_control::State;
use canvass_macros::rule;
use canvass_traces::{Duration, Timestamp};

/// a cyclic PDO does not come any more
///
/// A TPDO stays away for many of its periods, until the capture ends or until it comes again, while its node is
/// operational and sends other messages, or has never sent a heartbeat. The period is the event timer (180xh:5) that
/// the SDO traffic of the capture shows, or learned: 30 regular intervals, some of them with unchanged data, so that a
/// timer has sent them and no event. A learned period is a warning only, and is not judged where SYNC, the RPDOs to the
/// node or PDOs of other nodes end at the same time: these are the reason then. NMT commands, boot-ups and changes of
/// the parameters begin anew.
///
/// # Why
/// The consumer goes on with the last value, and often nobody notices: the node itself looks healthy.
///
/// # What to do
/// Read 180xh:1 of the node: bit 31 switches the PDO off. If it is on, see what the node reports (EMCY, 1001h) and what
/// was written to it just before; else its firmware has stopped the task that sends the PDO.
#[rule(id = "pdo/ended", severity = Error, rank = ProcessData, also = UnusualPdos)]
struct Ended {
    /// a silence beyond this share of the event timer is reported
    #[threshold(percent = 500)]
    percent: Percent,
    /// a shorter silence is not reported
    #[threshold(ms = 1000)]
    least: Duration,
}

/// A TPDO that has ended.
struct Silence {
    node: NodeId,
    number: u16,
    since: Timestamp,
    period: Duration,
    /// Whether the period is an event timer.
    told: bool,
}

impl Silence {
    fn length(&self, scene: &Scene<'_>) -> Duration {
        scene.now.since(self.since)
    }

    /// Whether the node has sent anything since.
    fn node_lives(&self, scene: &Scene<'_>) -> bool {
        scene.facts.node(self.node).last_seen.is_some_and(|seen| seen > self.since)
    }

    /// Whether something else that ended at the same time explains the silence.
    fn is_explained(&self, all: &[Self], scene: &Scene<'_>) -> bool {
        let margin = self.period.times(2) + Duration::from_secs(2);
        let together = |then: Timestamp| {
            let apart = then.since(self.since).max(self.since.since(then));
            apart <= margin && scene.now.since(then).times(2) > self.length(scene)
        };
        let streams = &scene.facts.streams;
        let others = all.iter().filter(|other| other.node != self.node && !other.told);
        streams.sync.is_some_and(together)
            || streams.received(self.node).is_some_and(together)
            || others.into_iter().any(|other| together(other.since))
    }
}

impl Ended {
    /// Whether the node lives, and must send its PDOs.
    fn must_send(node: NodeId, scene: &Scene<'_>) -> bool {
        let facts = scene.facts.node(node);
        let state = scene.bus.node(node).and_then(|node| node.state);
        let operational = state.is_some_and(|(state, _)| state == State::OPERATIONAL);
        operational && !facts.is_storing(scene.now) && scene.facts.outage(node, scene.now).is_none()
    }

    /// The TPDOs that have ended.
    fn silences(&self, scene: &Scene<'_>) -> Vec<Silence> {
        let silence = |(node, number, stream): (NodeId, u16, &crate::findings::facts::Stream)| {
            let since = stream.last.filter(|_| !stream.polled)?;
            let parameters = scene.facts.tpdos.of(node, number);
            let timed = matches!(parameters.transmission_type, Some(254 | 255));
            let timer = parameters.event_timer.filter(|_| timed);
            let period = timer.or_else(|| stream.period())?;
            let silence = Silence { node, number, since, period, told: timer.is_some() };
            let share = if silence.told { self.percent } else { Percent(1_000) };
            let length = silence.length(scene);
            // The silence of a node that sends heartbeats is reported as the loss of the node.
            let counts = silence.node_lives(scene) || scene.facts.heartbeats.of(node).period().is_none();
            let is_long = length > share.of(period) + scene.slack() && length > self.least;
            (is_long && counts && Self::must_send(node, scene)).then_some(silence)
        };
        scene.facts.streams.all().filter_map(silence).collect()
    }
}

impl Rule for Ended {
    fn frame(&mut self, context: &Context<'_>, sink: &mut Sink<'_>) {
        let (Some((node, number, parameters)), StreamEvent::Resumed { since, period }) =
            (context.tpdo(), context.news().stream)
        else {
            return;
        };
        // What is later than its event timer is reported by pdo/period.
        let length = context.now().since(since);
        let silence = Silence { node, number, since, period, told: false };
        let is_short = parameters.event_timer.is_some() || length <= self.least;
        if is_short || !silence.node_lives(context.scene) || !Self::must_send(node, context.scene) {
            return;
        }
        if silence.is_explained(&[], context.scene) {
            return;
        }
        let report = Report::at(since).until(context.now()).node(node).detail(u64::from(number));
        let report = report.measure(length.nanos()).severity(Severity::Warning);
        let report = report.evidence(context.previous.map(Seen::evidence)).evidence(context.evidence());
        sink.report(report, || {
            format!("{} stayed away for {length}; before it came every {period}", PdoNumber::Transmit(number))
        });
    }

    fn finish(&mut self, scene: &Scene<'_>, sink: &mut Sink<'_>) {
        let all = self.silences(scene);
        for silence in &all {
            let Silence { node, number, since, period, told } = *silence;
            if !told && silence.is_explained(&all, scene) {
                continue;
            }
            let report = Report::at(since).until(scene.now).node(node).detail(u64::from(number));
            let report = report.measure(silence.length(scene).nanos());
            let report = if told { report } else { report.severity(Severity::Warning) };
            sink.report(report, || {
                let source = if told { "its event timer is" } else { "before it came every" };
                let pdo = PdoNumber::Transmit(number);
                let length = silence.length(scene);
                let also = if silence.node_lives(scene) { "" } else { "; nor does the node send anything else" };
                format!("{pdo} does not come for the last {length} of the capture; {source} {period}{also}")
            });
        }
    }
}
