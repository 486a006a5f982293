use super::pending::Step;
use crate::NodeId;
use crate::findings::rule::{Definition, Metadata, Rule};
use crate::findings::sink::{Report, Sink};
use crate::findings::{Context, Scene, Seen, Severity};
use crate::message::Service;

pub const RULE: Definition = Definition {
    metadata: &METADATA,
    services: &[Service::Sdo],
    make: Some(|_| Box::new(Retries { first: (0..128).map(|_| None).collect() })),
};

static METADATA: Metadata = Metadata {
    id: "sdo/retries",
    severity: Severity::Warning,
    title: "an SDO client repeats its request",
    what: "The same request is sent again before an answer has come, to a node that does send something in this \
           capture.",
    why: "The server was too slow for the client, or the request was lost. The server may answer both, and from then on \
          client and server are one answer apart.",
    advice: "Lengthen the time-out of the client, and see how long the server takes for other objects.",
    thresholds: &[],
};

struct Retries {
    /// The first repeated request to each node, and how many there were.
    first: Vec<Option<(Seen, u64)>>,
}

impl Rule for Retries {
    fn frame(&mut self, context: &Context<'_>, _: &mut Sink<'_>) {
        let (Step::Repeated, Some(node)) = (&context.news().request, context.node()) else { return };
        self.first[usize::from(node.raw())].get_or_insert_with(|| (context.seen(), 0)).1 += 1;
    }

    fn finish(&mut self, scene: &Scene<'_>, sink: &mut Sink<'_>) {
        for (node, first) in NodeId::all().zip(self.first.iter().skip(1)) {
            let Some((seen, times)) = first.as_ref().filter(|_| scene.facts.node(node).first_seen.is_some()) else {
                continue;
            };
            sink.report(Report::at(seen.time()).node(node).evidence(seen.evidence()), || {
                format!("{times} requests were repeated before an answer came")
            });
        }
    }
}
