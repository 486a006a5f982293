use crate::findings::rhythm::{Jitter, Rhythm};
use crate::findings::rule::{Also, Definition, Metadata, Rule, Threshold};
use crate::findings::sink::{Report, Sink};
use crate::findings::{Context, Scene, Severity};
use crate::message::{Message, Service};
use canvass_traces::Duration;

pub const RULE: Definition = Definition {
    metadata: &METADATA,
    services: &[Service::Sync, Service::Nmt, Service::Sdo],
    also: Also::Nothing,
    make: Some(|thresholds| {
        Box::new(SyncJitter {
            percent: thresholds.get(&METADATA, "percent"),
            least: Duration::from_micros(thresholds.get(&METADATA, "least")),
            share: thresholds.get(&METADATA, "share"),
            rhythm: Rhythm::default(),
            jitter: Jitter::default(),
        })
    }),
};

static METADATA: Metadata = Metadata {
    id: "pdo/sync-jitter",
    severity: Severity::Warning,
    title: "SYNC is irregular",
    what: "More than a share of the SYNC messages come earlier or later than their period allows. Missing ones are not \
           counted.",
    why: "Positions that are taken at SYNC are not equally spaced in time: velocities calculated from them are noisy.",
    advice: "Let the SYNC producer send from a timer of its controller, and not from a task of an operating system.",
    thresholds: &[
        Threshold { name: "percent", default: 20, unit: "%", meaning: "of the period that an interval may be off" },
        Threshold { name: "least", default: 1000, unit: "µs", meaning: "being off by less is never counted" },
        Threshold { name: "share", default: 10, unit: "%", meaning: "of the intervals may be off" },
    ],
};

struct SyncJitter {
    percent: u64,
    least: Duration,
    share: u64,
    rhythm: Rhythm,
    jitter: Jitter,
}

impl Rule for SyncJitter {
    fn frame(&mut self, context: &Context<'_>, _: &mut Sink<'_>) {
        if !matches!(context.message(), Message::Sync(_)) {
            return if super::changes_sync(context) {
                self.rhythm.restart();
            } else if context.begins_anew() {
                self.rhythm.pause();
            };
        }
        if let Some(interval) = self.rhythm.beat(context.now()) {
            self.jitter.count(context.now(), interval, self.percent, self.least + context.scene.slack());
        }
    }

    fn interrupted(&mut self) {
        self.rhythm.pause();
    }

    fn finish(&mut self, _: &Scene<'_>, sink: &mut Sink<'_>) {
        if let Some(share) = self.jitter.share().filter(|share| *share > self.share) {
            sink.report(Report::at(self.jitter.worst_at), || {
                format!("{share} % of the SYNC messages are too early or too late, by at most {}", self.jitter.worst)
            });
        }
    }
}
