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
    Effect::on(&["pdo/sync-pdo-missing", "pdo/sync-window", "pdo/sync-counter", "pdo/sync-jitter"])
        .during(SOON, SETTLE),
    Effect::on(&["emcy/raised", "nodes/state-lost"]).during(SOON, SETTLE),
];

/// a SYNC message is missing
///
/// SYNC has kept a period, and then at least one SYNC message is missing, or SYNC does not return until the capture
/// ends. The rule does not count pauses around NMT commands, because masters stop SYNC for a restart, and pauses after
/// a write of 1005h or 1006h.
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
}

impl Rule for SyncMissing {
    fn frame(&mut self, context: &Context<'_>, sink: &mut Sink<'_>) {
        if !matches!(context.message(), Message::Sync(_)) {
            if super::changes_sync(context) {
                self.rhythm.restart();
                self.last = None;
            } else if context.begins_anew() {
                self.rhythm.pause();
                self.last = None;
            }
            return;
        }
        self.last = context.record.frame.cob_id().map(|id| (context.now(), id));
        let Some(interval) = self.rhythm.beat(context.now()) else { return };
        let Some(period) = interval.misses(self.percent, context.scene.slack()) else { return };
        let begin = context.previous.map_or(context.now(), Seen::time);
        let report = Report::at(begin).until(context.now()).measure(interval.length.nanos());
        let report = report.evidence(context.previous.map(Seen::evidence)).evidence(context.evidence());
        sink.report(report, || format!("no SYNC for {}, but its period is {period}", interval.length));
    }

    fn interrupted(&mut self) {
        self.rhythm.pause();
        self.last = None;
    }

    fn finish(&mut self, scene: &Scene<'_>, sink: &mut Sink<'_>) {
        const ENDED: Percent = Percent(500);
        let (Some((last, id)), Some(period)) = (self.last, self.rhythm.period()) else { return };
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
