use crate::PerNode;
use crate::findings::facts::RequestEvent;
use crate::findings::rule::Rule;
use crate::findings::sink::{Report, Sink};
use crate::findings::{Context, Scene, Seen};
use canvass_macros::rule;

/// an SDO client repeats its request
///
/// A client repeats a request before an answer has come, to a node that has sent a message before and was not reset
/// meanwhile.
///
/// # Why
/// The server was too slow for the client, or the request was lost. The server may answer both requests, and from then
/// on the client takes each answer for the answer to its next request.
///
/// # What to do
/// Lengthen the timeout of the client, and check the response times of the server for other objects.
#[rule(id = "sdo/retries", severity = Warning, rank = Detail, services = [Sdo])]
struct Retries {
    nodes: PerNode<Option<Box<Repeated>>>,
}

/// The repeated requests to a node.
struct Repeated {
    first: Seen,
    times: u64,
    /// Whether one of the requests was answered.
    answered: bool,
}

impl Rule for Retries {
    fn frame(&mut self, context: &Context<'_>, _: &mut Sink<'_>) {
        let Some(node) = context.node() else { return };
        let repeated = &mut self.nodes[node];
        match &context.news().request {
            RequestEvent::Repeated if !context.scene.facts.node(node).is_absent() => {
                let first = || Box::new(Repeated { first: context.seen(), times: 0, answered: false });
                repeated.get_or_insert_with(first).times += 1;
            }
            RequestEvent::Answered(pending) | RequestEvent::AnsweredLate { pending, .. } if pending.times > 1 => {
                if let Some(repeated) = repeated {
                    repeated.answered = true;
                }
            }
            _ => {}
        }
    }

    fn finish(&mut self, _: &Scene<'_>, sink: &mut Sink<'_>) {
        for (node, repeated) in self.nodes.iter() {
            let Some(Repeated { first, times, answered }) = repeated.as_deref() else { continue };
            sink.report(Report::at(first.time()).node(node).evidence(first.evidence()), || {
                let requests = if *times == 1 { "1 request was".to_owned() } else { format!("{times} requests were") };
                let answer = if *answered { "before an answer came" } else { "and no answer came" };
                format!("{requests} repeated {answer}")
            });
        }
    }
}
