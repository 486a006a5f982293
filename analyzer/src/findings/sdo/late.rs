use crate::findings::effect::{Effect, SETTLE, SOON};
use crate::findings::facts::{Pending, RequestEvent};
use crate::findings::rule::Rule;
use crate::findings::sink::{Report, Sink};
use crate::findings::{Context, Thresholds};
use canvass_macros::rule;
use canvass_traces::Duration;

/// Effects: reactions of the client.
const EFFECTS: &[Effect] = &[
    Effect::on(&["sdo/retries", "sdo/protocol-violation"]).of_same_node().spanning(SETTLE),
    Effect::on(&["sdo/aborted"]).of_same_node().spanning(SOON),
];

/// an SDO server answers late
///
/// The answer to an SDO request comes later than usual timeouts allow, measured from the first transmission of the
/// request. Storing and restoring parameters may take longer. The rule sdo/too-early reports requests before the node's
/// boot-up.
///
/// # Why
/// Many clients give up after 500 ms, repeat the request, and then take the late answer for the answer to the next
/// request.
///
/// # What to do
/// Compare with the other response times of the node in the statistics. If only some objects are late, they use slow
/// memory: lengthen the client's timeout for them.
#[rule(id = "sdo/late", severity = Warning, rank = Transfer, services = [Sdo], leads_to = EFFECTS)]
struct Late {
    /// an answer after this time is late
    #[threshold(ms = 500)]
    answer: Duration,
    /// an answer for 1010h, 1011h, 1F50h or 1F51h after this time is late
    #[threshold(ms = 5000)]
    store: Duration,
}

/// Time limits for answers.
#[derive(Clone, Copy)]
pub struct Limits {
    answer: Duration,
    store: Duration,
}

impl Limits {
    /// Time limit for the answer to a request.
    pub fn of(self, pending: &Pending) -> Duration {
        if pending.is_store() { self.store } else { self.answer }
    }
}

/// Time limits for answers.
pub fn limits(thresholds: &Thresholds) -> Limits {
    let Late { answer, store } = Late::new(thresholds);
    Limits { answer, store }
}

impl Rule for Late {
    fn frame(&mut self, context: &Context<'_>, sink: &mut Sink<'_>) {
        let (pending, gave_up) = match &context.news().request {
            RequestEvent::Answered(pending) => (pending, None),
            RequestEvent::AnsweredLate { pending, gave_up, .. } => (pending, Some(*gave_up)),
            _ => return,
        };
        if context.scene.was_asked_too_early(pending) {
            return;
        }
        let limit = Limits { answer: self.answer, store: self.store }.of(pending);
        // The time counts from the first of repeated requests.
        let asked = pending.request.time();
        let took = context.now().since(asked);
        if took <= limit + context.scene.slack() {
            return;
        }
        let report = Report::at(context.now())
            .node(context.node())
            .detail(pending.detail())
            .object(pending.object)
            .measure(took.nanos());
        sink.report(report.evidence(pending.request.evidence()).evidence(context.evidence()), || {
            let gave_up = gave_up.map(|at| format!("; the client had given up after {}", at.since(asked)));
            format!("the answer{} took {took}{}", pending.about(), gave_up.unwrap_or_default())
        });
    }
}
