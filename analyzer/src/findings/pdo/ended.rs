use crate::NodeId;
use crate::findings::facts::{Cut, Parameters, Reasons, Reset, Stream, StreamEvent};
use crate::findings::rule::Rule;
use crate::findings::sink::{Report, Sink};
use crate::findings::{Context, Evidence, Percent, Scene, Seen, Severity};
use crate::message::PdoNumber;
use canvass_macros::rule;
use canvass_traces::{Duration, Timestamp};

/// a cyclic PDO does not come any more
///
/// A TPDO stays away for many of its periods while its node is operational and sends other messages, or has never
/// sent a heartbeat. The silence lasts until the capture ends, until the TPDO comes again with its period, or until it
/// begins anew: with an NMT command, a boot-up, a write to its parameters, or where frames are missing in the capture.
/// Of the silences before such events the longest of each TPDO is judged, as far as the node has sent other messages.
///
/// The period is the event timer (180xh:5) that the SDO traffic of the capture shows, and by which the TPDO has come
/// since its node was started; or it is learned: 30 regular intervals, some of them with unchanged data, so that a
/// timer has sent them and no event. A learned period is a warning only, and is learned anew after each silence of more
/// than a second and ten periods. It is not judged where SYNC, the RPDOs to the node or PDOs of other nodes are silent
/// at the same time: these are the reason then. Nor is a TPDO judged by it that came again after three silences, or
/// that ends after it came again twice: its device sends it from time to time.
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
    pauses: Vec<Pause>,
}

/// The silence of a TPDO.
#[derive(Clone, Copy)]
struct Silence {
    node: NodeId,
    number: u16,
    since: Timestamp,
    until: Timestamp,
    period: Duration,
    /// Whether the period is an event timer.
    told: bool,
    /// Whether SYNC or RPDOs explain the silence.
    explained: bool,
    end: End,
}

/// The end of a silence.
#[derive(Clone, Copy, PartialEq, Eq)]
enum End {
    /// The capture ended.
    Capture,
    /// The TPDO came again.
    Resumed,
    /// The TPDO began anew.
    Reset(Reset),
}

/// A silence after which the TPDO came again.
struct Pause {
    silence: Silence,
    /// Whether the TPDO had to come; otherwise the pause can only explain the pauses of other TPDOs.
    is_wrong: bool,
    /// Whether the TPDO has its period again.
    returned: bool,
    /// The last frame before the pause and the first after it.
    frames: [Option<Seen>; 2],
}

impl Silence {
    fn length(&self) -> Duration {
        self.until.since(self.since)
    }

    /// Largest time between the ends of two TPDOs that stop for the same reason.
    fn margin(&self) -> Duration {
        self.period.times(2) + Duration::from_secs(2)
    }

    /// Whether a TPDO of another node was silent at the same time.
    fn is_with(&self, other: &Self) -> bool {
        let near = |a: Timestamp, b: Timestamp| a.since(b).max(b.since(a)) <= self.margin();
        let ends = if (self.end, other.end) == (End::Resumed, End::Resumed) {
            near(self.until, other.until)
        } else {
            other.until.since(other.since).times(2) > self.length()
        };
        other.node != self.node && !other.told && near(self.since, other.since) && ends
    }

    /// Whether something else that was silent at the same time explains the silence.
    fn is_explained(&self, all: &[Self]) -> bool {
        self.explained || all.iter().any(|other| self.is_with(other))
    }

    /// Whether the node has sent anything since.
    fn node_lives(&self, scene: &Scene<'_>) -> bool {
        scene.facts.node(self.node).last_seen.is_some_and(|seen| seen > self.since)
    }

    /// Explains the silence by SYNC or RPDOs, if they were silent, too.
    fn with_reasons(self, reasons: &Reasons) -> Self {
        Self { explained: reasons.explain(self.since, self.until, self.margin()), ..self }
    }

    /// The event in words, with the period of the TPDO.
    fn text(&self, scene: &Scene<'_>) -> String {
        let (pdo, length, period) = (PdoNumber::Transmit(self.number), self.length(), self.period);
        let source = if self.told { "its event timer is" } else { "before it came every" };
        match self.end {
            End::Capture => {
                let also = if self.node_lives(scene) { "" } else { "; nor does the node send anything else" };
                format!("{pdo} does not come for the last {length} of the capture; {source} {period}{also}")
            }
            End::Resumed => format!("{pdo} stayed away for {length}; {source} {period}"),
            End::Reset(reset) => format!("{pdo} did not come for {length}, until {}; {source} {period}", event(reset)),
        }
    }

    fn tell(&self, frames: [Option<Evidence<'_>>; 2], scene: &Scene<'_>, sink: &mut Sink<'_>) {
        let [last, next] = frames;
        let report = Report::at(self.since).until(self.until).node(self.node).detail(u64::from(self.number));
        let report = report.measure(self.length().nanos()).evidence(last).evidence(next);
        let report = if self.told { report } else { report.severity(Severity::Warning) };
        sink.report(report, || self.text(scene));
    }
}

const fn event(reset: Reset) -> &'static str {
    match reset {
        Reset::Command => "an NMT command to the node",
        Reset::BootUp => "the node booted",
        Reset::Parameters => "its parameters were written",
        Reset::Gap => "frames are missing in the capture",
    }
}

/// The last frame before a silence, if no frame with its CAN-ID came later.
fn last_frame<'a>(silence: &Silence, stream: &Stream, scene: &Scene<'a>) -> Option<Evidence<'a>> {
    scene.latest.get(stream.can_id).filter(|seen| seen.time() == silence.since).map(Seen::evidence)
}

impl Ended {
    /// Number of pauses that are kept of each TPDO: a TPDO with more pauses is one that sends only from time to time.
    const PAUSES: u8 = 2;
    /// Number of pauses that are kept of all TPDOs together.
    const ALL_PAUSES: usize = 256;

    /// The silence of a TPDO until `until`, if it is too long.
    fn silence(
        &self,
        (node, number, stream): (NodeId, u16, &Stream),
        parameters: &Parameters,
        (until, end): (Timestamp, End),
        scene: &Scene<'_>,
    ) -> Option<Silence> {
        let since = stream.last.filter(|_| !stream.polled)?;
        let timed = matches!(parameters.transmission_type, Some(254 | 255));
        let timer = parameters.event_timer.filter(|timer| timed && stream.obeys(*timer));
        let learned = stream.period().filter(|_| stream.pauses < Self::PAUSES);
        let (period, told) = (timer.or(learned)?, timer.is_some());
        let silence = Silence { node, number, since, until, period, told, explained: false, end };
        let share = if told { self.percent } else { Percent(1_000) };
        let length = silence.length();
        (length > share.of(period) + scene.slack() && length > self.least).then_some(silence)
    }

    /// The silence of a TPDO until now.
    fn open(&self, stream: (NodeId, u16, &Stream), scene: &Scene<'_>) -> Option<Silence> {
        let (node, number, _) = stream;
        let parameters = scene.facts.tpdos.of(node, number);
        let silence = self.silence(stream, parameters, (scene.now, End::Capture), scene)?;
        // The silence of a node that sends heartbeats is reported as the loss of the node.
        let counts = silence.node_lives(scene) || scene.facts.heartbeats.of(node).period().is_none();
        (counts && scene.facts.must_send(node, scene.now))
            .then(|| silence.with_reasons(&scene.facts.streams.reasons(node)))
    }

    /// The silence of a TPDO until it began anew.
    fn cut(&self, cut: &Cut, scene: &Scene<'_>) -> Option<Silence> {
        let stream = (cut.node, cut.number, &cut.stream);
        let silence = self.silence(stream, &cut.parameters, (cut.until, End::Reset(cut.reset)), scene)?;
        Some(silence.with_reasons(&cut.reasons))
    }

    /// The TPDOs that have ended, each with its last frame.
    fn silences<'a>(&self, scene: &Scene<'a>) -> Vec<(Silence, Option<Evidence<'a>>)> {
        let streams = &scene.facts.streams;
        let open = streams.all().filter_map(|row| {
            let silence = self.open(row, scene)?;
            Some((silence, last_frame(&silence, row.2, scene)))
        });
        let cut = streams.cut().iter().filter_map(|cut| {
            let silence = self.cut(cut, scene)?;
            Some((silence, last_frame(&silence, &cut.stream, scene)))
        });
        open.chain(cut).collect()
    }

    /// Keeps a silence that ended when the TPDO came again.
    fn resumed(&mut self, context: &Context<'_>, since: Timestamp, period: Duration) {
        let Some((node, number, parameters)) = context.tpdo() else { return };
        let facts = context.scene.facts;
        let is_rare = facts.streams.get(node, number).is_some_and(|stream| stream.pauses <= Self::PAUSES);
        if !is_rare || self.pauses.len() >= Self::ALL_PAUSES {
            return;
        }
        let until = context.now();
        let silence = Silence { node, number, since, until, period, told: false, explained: false, end: End::Resumed };
        let silence = silence.with_reasons(&facts.streams.reasons(node));
        // The rule pdo/period reports a TPDO that is later than its event timer.
        let is_long = parameters.event_timer.is_none() && silence.length() > self.least;
        let is_wrong = is_long && silence.node_lives(context.scene) && facts.must_send(node, until);
        let frames = [context.previous.cloned(), Some(context.seen())];
        self.pauses.push(Pause { silence, is_wrong, returned: false, frames });
    }

    /// Notes that a TPDO has its period again after its last pause.
    fn returned(&mut self, context: &Context<'_>) {
        let Some((node, number, _)) = context.tpdo() else { return };
        let of = |pause: &&mut Pause| (pause.silence.node, pause.silence.number) == (node, number);
        if let Some(pause) = self.pauses.iter_mut().rev().find(of) {
            pause.returned = true;
        }
    }

    fn tell_pauses(&self, all: &[Silence], scene: &Scene<'_>, sink: &mut Sink<'_>) {
        let is_rare = |silence: &Silence| {
            let stream = scene.facts.streams.get(silence.node, silence.number);
            stream.is_some_and(|stream| stream.pauses <= Self::PAUSES)
        };
        for Pause { silence, is_wrong, returned, frames } in &self.pauses {
            if *is_wrong && *returned && is_rare(silence) && !silence.is_explained(all) {
                silence.tell(frames.each_ref().map(|seen| seen.as_ref().map(Seen::evidence)), scene, sink);
            }
        }
    }
}

impl Rule for Ended {
    fn frame(&mut self, context: &Context<'_>, _: &mut Sink<'_>) {
        match context.news().stream {
            StreamEvent::Resumed { since, period } => self.resumed(context, since, period),
            StreamEvent::Returned => self.returned(context),
            _ => {}
        }
    }

    fn finish(&mut self, scene: &Scene<'_>, sink: &mut Sink<'_>) {
        let ended = self.silences(scene);
        let pauses = self.pauses.iter().map(|pause| pause.silence);
        let all: Vec<Silence> = ended.iter().map(|row| row.0).chain(pauses).collect();
        self.tell_pauses(&all, scene, sink);
        for (silence, last) in ended {
            if silence.told || !silence.is_explained(&all) {
                silence.tell([last, None], scene, sink);
            }
        }
    }
}
