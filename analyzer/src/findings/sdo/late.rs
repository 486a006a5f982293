use crate::findings::Context;
use crate::findings::facts::Step;
use crate::findings::rule::Rule;
use crate::findings::sink::{Report, Sink};
use canvass_analyzer_macros::rule;
use canvass_traces::Duration;

/// an SDO server answers late
///
/// The answer to an SDO request comes later than usual time-outs allow. Storing and restoring parameters may take
/// longer.
///
/// # Why
/// Many clients give up after 500 ms, repeat the request, and then take the late answer for the answer to the next one.
///
/// # What to do
/// Compare with the other response times of the node in the statistics. If only some objects are late, they touch slow
/// memory: lengthen the client's time-out for them.
#[rule(id = "sdo/late", severity = Warning, services = [Sdo])]
struct Late {
    /// later is late
    #[threshold(ms = 500)]
    answer: Duration,
    /// later is late for 1010h, 1011h, 1F50h, 1F51h
    #[threshold(ms = 5000)]
    store: Duration,
}

impl Rule for Late {
    fn frame(&mut self, context: &Context<'_>, sink: &mut Sink<'_>) {
        let Step::Answered(pending) = &context.news().request else { return };
        let limit = if pending.is_store() { self.store } else { self.answer };
        let took = context.now().since(pending.since);
        if took <= limit + context.scene.slack() {
            return;
        }
        let report = Report::at(context.now()).node(context.node()).detail(pending.detail()).measure(took.nanos());
        sink.report(report.evidence(pending.request.evidence()).evidence(context.evidence()), || {
            format!("the answer{} took {took}", pending.about())
        });
    }
}
