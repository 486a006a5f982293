use crate::findings::rhythm::Rhythm;
use crate::findings::rule::Rule;
use crate::findings::sink::{Report, Sink};
use crate::findings::{Context, Percent, Seen};
use crate::message::Message;
use canvass_analyzer_macros::rule;

/// a SYNC message is missing
///
/// SYNC has kept a period, and then at least one was left out. Pauses around NMT commands are not counted, as masters
/// stop SYNC for a restart, nor is what follows when 1005h or 1006h is written.
///
/// # Why
/// Synchronous PDOs are not sent and outputs are not updated in that cycle; drives in interpolated modes stop.
///
/// # What to do
/// Look at what the SYNC producer was doing, and at the bus load: SYNC has a high priority, so that a full bus alone
/// does not delay it.
#[rule(id = "pdo/sync-missing", severity = Error, services = [Sync, Nmt, Sdo])]
struct SyncMissing {
    /// of the period; later is missing
    #[threshold(percent = 180)]
    percent: Percent,
    rhythm: Rhythm,
}

impl Rule for SyncMissing {
    fn frame(&mut self, context: &Context<'_>, sink: &mut Sink<'_>) {
        if !matches!(context.message(), Message::Sync(_)) {
            return if super::changes_sync(context) {
                self.rhythm.restart();
            } else if context.begins_anew() {
                self.rhythm.pause();
            };
        }
        let Some(interval) = self.rhythm.beat(context.now()) else { return };
        let Some(period) = interval.misses(self.percent, context.scene.slack()) else { return };
        let begin = context.previous.map_or(context.now(), Seen::time);
        let report = Report::at(begin).measure(interval.length.nanos());
        let report = report.evidence(context.previous.map(Seen::evidence)).evidence(context.evidence());
        sink.report(report, || format!("no SYNC for {}, its period is {period}", interval.length));
    }

    fn interrupted(&mut self) {
        self.rhythm.pause();
    }
}
