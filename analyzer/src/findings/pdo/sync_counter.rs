use crate::findings::rule::Rule;
use crate::findings::sink::{Report, Sink};
use crate::findings::{Context, Seen};
use crate::message::Message;
use canvass_macros::rule;
use canvass_traces::{Duration, Timestamp};

/// the SYNC counter does not count
///
/// The counter in SYNC does not increase by one, and does not return to 1 after the same value as before (1019h); or it
/// is outside 1 to 240, or missing in some SYNC messages. The counter may restart after an NMT command or a pause.
///
/// # Why
/// PDOs with a SYNC start value are sent in the wrong cycle. A jump means a lost SYNC or a second producer.
///
/// # What to do
/// Check the intervals around the jump: if they are regular, the producer miscounts; if one of them is doubled, a SYNC
/// was lost; if they are short, there are two producers.
#[rule(id = "pdo/sync-counter", severity = Error, rank = Detail, services = [Sync, Nmt])]
struct SyncCounter {
    last: Option<(u8, Timestamp)>,
    /// The counter value after which 1 followed.
    overflow: Option<u8>,
}

impl Rule for SyncCounter {
    fn frame(&mut self, context: &Context<'_>, sink: &mut Sink<'_>) {
        let Message::Sync(sync) = context.message() else {
            if context.begins_anew() {
                self.last = None;
            }
            return;
        };
        let Some(counter) = sync.counter else {
            if let Some((last, _)) = self.last.take() {
                self.tell(1, context, sink, || format!("no counter after counter {last}"));
            }
            return;
        };
        let before = self.last.replace((counter, context.now()));
        if !(1..=240).contains(&counter) {
            return self.tell(2, context, sink, || format!("counter {counter}, but 1 to 240 are allowed"));
        }
        let Some((last, at)) = before else { return };
        // A restarted producer begins with 1 again; a pause this long is no cycle.
        if counter == 1 && context.now().since(at) > Duration::from_secs(1) {
            return;
        }
        match counter {
            1 if last > 1 && self.overflow.is_none() => self.overflow = Some(last),
            1 if self.overflow == Some(last) => {}
            n if Some(n) == last.checked_add(1) && self.overflow.is_none_or(|overflow| n <= overflow) => {}
            _ => self.tell(3, context, sink, || format!("counter {counter} after counter {last}")),
        }
    }

    fn interrupted(&mut self) {
        self.last = None;
    }
}

impl SyncCounter {
    fn tell(&self, detail: u64, context: &Context<'_>, sink: &mut Sink<'_>, message: impl FnOnce() -> String) {
        let report = Report::at(context.now()).detail(detail);
        let report = report.evidence(context.previous.map(Seen::evidence)).evidence(context.evidence());
        sink.report(report, message);
    }
}
