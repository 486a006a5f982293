use super::late::{self, Limits};
use crate::findings::Context;
use crate::findings::effect::{Effect, SETTLE};
use crate::findings::facts::RequestEvent;
use crate::findings::rule::Rule;
use crate::findings::sink::{Report, Sink};
use crate::message::Message;
use crate::wire::sdo::Request;
use canvass_macros::rule;
use canvass_traces::Duration;

/// Effects: reactions of client and server.
const EFFECTS: &[Effect] =
    &[Effect::on(&["sdo/aborted", "sdo/retries", "sdo/protocol-violation"]).of_same_node().spanning(SETTLE)];

/// an SDO client gives up too soon
///
/// A client aborts its request, or sends another request, before the server has had time to answer; or the answer comes
/// afterwards, within the time that sdo/late allows. The rule does not blame the server.
///
/// # Why
/// The transfer fails although the server works correctly. Its late answer is taken for the answer to another request,
/// or for the answer of a second device.
///
/// # What to do
/// Lengthen the timeout of the client: 500 ms are usual, several seconds for stores.
#[rule(id = "sdo/impatient-client", severity = Warning, rank = ProcessData, also = UnusualRequests, leads_to = EFFECTS)]
struct ImpatientClient {
    /// giving up sooner than this is impatient
    #[threshold(ms = 20)]
    patience: Duration,
    #[from(late::limits)]
    limits: Limits,
}

/// The time before which giving up counts as impatient.
pub fn patience(thresholds: &crate::findings::Thresholds) -> Duration {
    ImpatientClient::new(thresholds).patience
}

impl Rule for ImpatientClient {
    fn frame(&mut self, context: &Context<'_>, sink: &mut Sink<'_>) {
        let aborts = matches!(context.message(), Message::SdoRequest(Request::Abort(_)));
        match &context.news().request {
            RequestEvent::GivenUp(pending) if aborts => {
                let waited = context.now().since(pending.request.time());
                if waited < self.patience {
                    let report = Report::at(pending.request.time())
                        .node(context.node())
                        .detail(pending.detail())
                        .object(pending.object);
                    let report = report.evidence(pending.request.evidence()).evidence(context.evidence());
                    sink.report(report, || format!("the client gave up the request{} after {waited}", pending.about()));
                }
            }
            RequestEvent::AnsweredLate { pending, gave_up, by_client: true } => {
                let asked = pending.request.time();
                let (took, waited) = (context.now().since(asked), gave_up.since(asked));
                if took > self.limits.of(pending) + context.scene.slack() {
                    return;
                }
                let report = Report::at(asked).node(context.node()).detail(pending.detail()).object(pending.object);
                let report = if waited < self.patience { report.amend() } else { report };
                sink.report(report.evidence(pending.request.evidence()).evidence(context.evidence()), || {
                    format!(
                        "the client gave up the request{} after {waited}; the answer came after {took}",
                        pending.about()
                    )
                });
            }
            _ => {}
        }
    }
}
