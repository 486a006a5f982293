use crate::findings::rhythm::Rhythm;
use crate::findings::rule::{Also, Definition, Metadata, Rule, Threshold};
use crate::findings::sink::{Report, Sink};
use crate::findings::{Context, Seen, Severity};
use crate::message::{Message, Service};

pub const RULE: Definition = Definition {
    metadata: &METADATA,
    services: &[Service::Sync, Service::Nmt, Service::Sdo],
    also: Also::Nothing,
    make: Some(|thresholds| {
        Box::new(SyncMissing { percent: thresholds.get(&METADATA, "percent"), rhythm: Rhythm::default() })
    }),
};

static METADATA: Metadata = Metadata {
    id: "pdo/sync-missing",
    severity: Severity::Error,
    title: "a SYNC message is missing",
    what: "SYNC has kept a period, and then at least one was left out. Pauses around NMT commands are not counted, as \
           masters stop SYNC for a restart, nor is what follows when 1005h or 1006h is written.",
    why: "Synchronous PDOs are not sent and outputs are not updated in that cycle; drives in interpolated modes stop.",
    advice: "Look at what the SYNC producer was doing, and at the bus load: SYNC has a high priority, so that a full bus \
             alone does not delay it.",
    thresholds: &[Threshold { name: "percent", default: 180, unit: "%", meaning: "of the period; later is missing" }],
};

struct SyncMissing {
    percent: u64,
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
