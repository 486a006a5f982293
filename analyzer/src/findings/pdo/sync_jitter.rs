use crate::findings::rhythm::{Jitter, Rhythm};
use crate::findings::rule::Rule;
use crate::findings::sink::{Report, Sink};
use crate::findings::{Context, Percent, Scene};
use crate::message::Message;
use canvass_macros::rule;
use canvass_traces::Duration;

/// SYNC is irregular
///
/// More than the given share of the SYNC messages come earlier or later than their period allows. Missing SYNC messages
/// are not counted.
///
/// # Why
/// Positions that are sampled at SYNC are not equally spaced in time: velocities calculated from them are noisy.
///
/// # What to do
/// Send SYNC from a timer of the producer's controller instead of a task of an operating system.
#[rule(id = "pdo/sync-jitter", severity = Warning, rank = Detail, services = [Sync, Nmt], also = EndedTransfers)]
struct SyncJitter {
    /// deviation from the period, in percent, that counts
    #[threshold(percent = 20)]
    percent: Percent,
    /// a smaller deviation is never counted
    #[threshold(us = 1000)]
    least: Duration,
    /// share of deviating intervals that is reported
    #[threshold(percent = 10)]
    share: Percent,
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
                format!("{share} of the SYNC messages are too early or too late, by at most {}", self.jitter.worst)
            });
        }
    }
}
