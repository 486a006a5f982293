use crate::findings::rhythm::{Additional, Rhythm};
use crate::findings::rule::Rule;
use crate::findings::sink::{Report, Sink};
use crate::findings::{Context, Seen};
use crate::message::Message;
use canvass_macros::rule;

/// a SYNC comes beside the regular ones
///
/// A period of SYNC of at least 5 ms is divided into two unequal parts by another SYNC message, and the period before was
/// whole.
///
/// # Why
/// Synchronous actions happen once more than they should, and counters of SYNC messages run ahead.
///
/// # What to do
/// If it happens again and again, look for a second producer: bit 30 of 1005h must be set in one node only. Otherwise the
/// producer, or a gateway on the way, has sent a message twice.
#[rule(id = "pdo/sync-additional", severity = Warning, rank = ProcessData, services = [Sync, Nmt], also = EndedTransfers)]
struct SyncAdditional {
    rhythm: Rhythm,
    additional: Additional,
}

impl Rule for SyncAdditional {
    fn frame(&mut self, context: &Context<'_>, sink: &mut Sink<'_>) {
        if !matches!(context.message(), Message::Sync(_)) {
            if super::changes_sync(context) {
                self.rhythm.restart();
                self.additional.restart();
            } else if context.begins_anew() {
                self.interrupted();
            }
            return;
        }
        let divided = self.rhythm.beat(context.now()).and_then(|interval| self.additional.beat(interval));
        // Shorter parts also come from a queue of the producer.
        let Some((first, second)) = divided.filter(|(a, b)| a.nanos() + b.nanos() >= 5_000_000) else { return };
        let report = Report::at(context.now());
        let report = report.evidence(context.previous.map(Seen::evidence)).evidence(context.evidence());
        sink.report(report, || format!("SYNC after {first} and after {second}, which together are a period"));
    }

    fn interrupted(&mut self) {
        self.rhythm.pause();
        self.additional.restart();
    }
}
