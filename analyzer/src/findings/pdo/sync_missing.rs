use crate::findings::effect::{Effect, SETTLE, SOON};
use crate::findings::rhythm::Rhythm;
use crate::findings::rule::Rule;
use crate::findings::sink::{Report, Sink};
use crate::findings::{Context, Percent, Scene, Seen};
use crate::message::Message;
use canvass_macros::rule;
use canvass_traces::{Duration, Timestamp};

/// Effects: messages that depend on SYNC.
const EFFECTS: &[Effect] = &[
    Effect::on(&["pdo/sync-pdo-missing", "pdo/sync-window", "pdo/sync-counter", "pdo/sync-jitter", "pdo/ended"])
        .during(SOON, SETTLE),
    Effect::on(&["emcy/raised", "nodes/state-lost"]).during(SOON, SETTLE),
];

/// a SYNC message is missing
///
/// SYNC has kept a period, at least one SYNC message is missing, and the period continues after the gap; or SYNC does
/// not return until the capture ends. Intervals that stay longer are not reported: the period has changed, or the first
/// SYNC messages came from a queue. The rule does not count pauses around NMT commands, because masters stop SYNC for a
/// restart, and pauses after a write of 1005h or 1006h.
///
/// # Why
/// In that cycle synchronous PDOs are not sent and outputs are not updated; drives in interpolated modes stop.
///
/// # What to do
/// Check the other messages of the SYNC producer, and the bus load: SYNC has a high priority, so that a full bus alone
/// does not delay it.
#[rule(
    id = "pdo/sync-missing",
    severity = Error,
    rank = Loss,
    services = [Sync, Nmt],
    also = EndedTransfers,
    leads_to = EFFECTS
)]
struct SyncMissing {
    /// beyond this share of the period a SYNC counts as missing
    #[threshold(percent = 180)]
    percent: Percent,
    rhythm: Rhythm,
    /// Time and CAN-ID of the last SYNC, as long as more are expected.
    last: Option<(Timestamp, u16)>,
    gaps: Gaps,
}

/// Intervals in which SYNC may be missing, until the following intervals show whether the period goes on.
#[derive(Default)]
struct Gaps {
    open: Vec<Gap>,
    /// The period before the first gap.
    period: Duration,
    /// Weight of the intervals since the first gap that differ from the period.
    change: u32,
    /// Time since the SYNC before the first gap, and the number of SYNC messages in it.
    elapsed: Duration,
    messages: u64,
    /// Number of intervals that had the period since it was learned.
    kept: u32,
}

/// The share of the period after which SYNC has ended.
const ENDED: Percent = Percent(500);

/// An interval in which SYNC may be missing.
struct Gap {
    before: Option<Seen>,
    after: Seen,
    length: Duration,
}

/// What an interval between two SYNC messages shows about the gaps before it.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Shows {
    /// The period goes on: SYNC was missing.
    GoesOn,
    /// Nothing yet.
    Nothing,
    /// SYNC has another period now.
    Changed,
}

impl Gaps {
    /// Maximum number of gaps that are kept.
    const MOST: usize = 8;
    /// The weight of an interval that is longer than the period. A shorter interval weighs 1, or nothing while the producer
    /// only sends what it has missed.
    const LONGER: u32 = 8;
    /// The weight of intervals that shows a new period.
    const CHANGED: u32 = 4 * Self::LONGER;
    /// Number of intervals with the period after which the gaps at the end of the capture are reported, although no
    /// later interval shows whether the period goes on.
    const BELIEVED: u32 = 10;

    /// Begins to count at the first gap.
    const fn begin(&mut self, period: Duration, length: Duration) {
        (self.period, self.change, self.elapsed, self.messages) = (period, Self::LONGER, length, 1);
    }

    /// Whether the producer still owes SYNC messages: it has sent fewer than the period asks for since the first gap.
    fn is_owing(&self) -> bool {
        self.period.nanos().saturating_mul(self.messages) <= self.elapsed.nanos()
    }

    fn judge(&mut self, length: Duration) -> Shows {
        let period = self.period.nanos();
        self.elapsed = self.elapsed + length;
        self.messages += 1;
        if length.nanos().abs_diff(period) <= (period / 4).max(500_000) {
            return Shows::GoesOn;
        }
        self.change += if length > self.period { Self::LONGER } else { u32::from(!self.is_owing()) };
        if self.change < Self::CHANGED { Shows::Nothing } else { Shows::Changed }
    }

    fn tell(&mut self, sink: &mut Sink<'_>) {
        let period = self.period;
        for Gap { before, after, length } in self.open.drain(..) {
            let begin = before.as_ref().map_or(after.time(), Seen::time);
            let report = Report::at(begin).until(after.time()).measure(length.nanos());
            let report = report.evidence(before.as_ref().map(Seen::evidence)).evidence(after.evidence());
            sink.report(report, || format!("no SYNC for {length}, but its period is {period}"));
        }
        self.change = 0;
    }
}

impl SyncMissing {
    fn beat(&mut self, context: &Context<'_>, sink: &mut Sink<'_>) {
        let Some(interval) = self.rhythm.beat(context.now()) else { return };
        let missed = interval.misses(self.percent, context.scene.slack());
        if self.gaps.open.is_empty() {
            let Some(period) = missed else {
                self.gaps.kept += u32::from(interval.expected.is_some());
                return;
            };
            self.gaps.begin(period, interval.length);
            return self.open(interval.length, context);
        }
        match self.gaps.judge(interval.length) {
            Shows::GoesOn => self.gaps.tell(sink),
            Shows::Changed => {
                self.gaps = Gaps::default();
                self.rhythm.restart();
            }
            Shows::Nothing if interval.length > self.percent.of(self.gaps.period) => {
                self.open(interval.length, context);
            }
            Shows::Nothing => {}
        }
    }

    /// Whether SYNC has been silent for many periods.
    fn is_over(&self, now: Timestamp, scene: &Scene<'_>) -> bool {
        let Some(((last, _), period)) = self.last.zip(self.rhythm.period()) else { return false };
        now.since(last) > ENDED.of(period) + scene.slack() + Duration::from_millis(10)
    }

    #[cold]
    fn open(&mut self, length: Duration, context: &Context<'_>) {
        if self.gaps.open.len() < Gaps::MOST {
            let gap = Gap { before: context.previous.cloned(), after: context.seen(), length };
            self.gaps.open.push(gap);
        }
    }
}

impl Rule for SyncMissing {
    fn frame(&mut self, context: &Context<'_>, sink: &mut Sink<'_>) {
        if !matches!(context.message(), Message::Sync(_)) {
            if super::changes_sync(context) {
                self.rhythm.restart();
                (self.last, self.gaps) = (None, Gaps::default());
            } else if context.begins_anew() {
                // A command explains no silence that began long before it.
                if !self.is_over(context.now(), context.scene) {
                    self.last = None;
                }
                self.rhythm.pause();
            }
            return;
        }
        self.last = context.record.frame.cob_id().map(|id| (context.now(), id));
        self.beat(context, sink);
    }

    fn interrupted(&mut self) {
        self.rhythm.pause();
        (self.last, self.gaps) = (None, Gaps::default());
    }

    fn finish(&mut self, scene: &Scene<'_>, sink: &mut Sink<'_>) {
        let period = if self.gaps.open.is_empty() { self.rhythm.period() } else { Some(self.gaps.period) };
        if self.gaps.kept >= Gaps::BELIEVED {
            self.gaps.tell(sink);
        }
        let (Some((last, id)), Some(period)) = (self.last, period) else { return };
        let silence = scene.now.since(last);
        if silence <= ENDED.of(period) + scene.slack() + Duration::from_millis(10) {
            return;
        }
        let report = Report::at(last).until(scene.now).measure(silence.nanos());
        sink.report(report.evidence(scene.latest.get(id).map(Seen::evidence)), || {
            format!("no SYNC for the last {silence} of the capture, but its period is {period}")
        });
    }
}
