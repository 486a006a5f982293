use super::exchange::{Sender, command, is_store, sender, wants_answer, words};
use crate::findings::rule::Rule;
use crate::findings::sink::{Report, Sink};
use crate::findings::{Context, Scene, Seen};
use canvass_macros::rule;
use canvass_traces::Duration;

/// an LSS or LMT request gets no answer
///
/// No slave answers a request that a slave must answer (configure, store, inquire, the last request of a switch
/// selective). Identify and Fastscan are not reported, because only matching slaves answer them; LMT switch requests
/// are not reported, because they have no answer.
///
/// # Why
/// No slave is in configuration state, or no slave has the given address. The node-ID or bit rate has not changed.
///
/// # What to do
/// Compare the four numbers of the address with the label. On many devices, LSS works in stopped and pre-operational
/// only.
#[rule(id = "lss/unanswered", severity = Warning, rank = Detail, services = [Lss, Lmt])]
struct Unanswered {
    /// timeout for an answer
    #[threshold(ms = 1000)]
    wait: Duration,
    /// timeout for the answer to a store
    #[threshold(ms = 5000)]
    store: Duration,
    open: Option<Seen>,
}

impl Unanswered {
    fn limit(&self, seen: &Seen) -> Duration {
        if is_store(&seen.decoded.message) { self.store } else { self.wait }
    }

    fn tell(seen: &Seen, why: &str, sink: &mut Sink<'_>) {
        let report = Report::at(seen.time()).detail(u64::from(command(seen))).evidence(seen.evidence());
        sink.report(report, || format!("no answer to \"{}\": {why}", words(&seen.decoded.message)));
    }
}

impl Rule for Unanswered {
    fn frame(&mut self, context: &Context<'_>, sink: &mut Sink<'_>) {
        match sender(context.message()) {
            Some(Sender::Master) => {
                if let Some(open) = self.open.take() {
                    Self::tell(&open, "the master sent its next message before an answer", sink);
                }
                self.open = wants_answer(context.message()).then(|| context.seen());
            }
            _ => self.open = None,
        }
    }

    fn tick(&mut self, scene: &Scene<'_>, sink: &mut Sink<'_>) {
        let Some(open) = &self.open else { return };
        let limit = self.limit(open);
        if scene.now.since(open.time()) > limit + scene.slack() {
            Self::tell(open, &format!("nothing came within {limit}"), sink);
            self.open = None;
        }
    }

    fn interrupted(&mut self) {
        self.open = None;
    }
}
