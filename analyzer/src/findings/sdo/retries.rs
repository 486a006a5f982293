use crate::PerNode;
use crate::findings::facts::RequestEvent;
use crate::findings::rule::Rule;
use crate::findings::sink::{Report, Sink};
use crate::findings::{Context, Scene, Seen};
use canvass_macros::rule;

/// an SDO client repeats its request
///
/// A client repeats a request before an answer has come, to a node that sends messages in this capture.
///
/// # Why
/// The server was too slow for the client, or the request was lost. The server may answer both requests, and from then
/// on the client takes each answer for the answer to its next request.
///
/// # What to do
/// Lengthen the timeout of the client, and check the response times of the server for other objects.
#[rule(id = "sdo/retries", severity = Warning, rank = Detail, also = UnusualRequests)]
struct Retries {
    /// The first repeated request to each node, and the number of repetitions.
    first: PerNode<Option<Box<(Seen, u64)>>>,
}

impl Rule for Retries {
    fn frame(&mut self, context: &Context<'_>, _: &mut Sink<'_>) {
        let (RequestEvent::Repeated, Some(node)) = (&context.news().request, context.node()) else { return };
        self.first[node].get_or_insert_with(|| Box::new((context.seen(), 0))).1 += 1;
    }

    fn finish(&mut self, scene: &Scene<'_>, sink: &mut Sink<'_>) {
        for (node, first) in self.first.iter() {
            let Some((seen, times)) = first.as_deref().filter(|_| scene.facts.node(node).first_seen.is_some()) else {
                continue;
            };
            sink.report(Report::at(seen.time()).node(node).evidence(seen.evidence()), || {
                format!("{times} requests were repeated before an answer came")
            });
        }
    }
}
