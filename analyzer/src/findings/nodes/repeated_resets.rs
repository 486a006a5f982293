use super::boot_up_without_command::is_explained;
use crate::findings::rule::{Also, Definition, Metadata, Rule, Threshold};
use crate::findings::sink::{Report, Sink};
use crate::findings::{Context, Severity};
use crate::message::Service;
use canvass_traces::{Duration, Timestamp};

pub const RULE: Definition = Definition {
    metadata: &METADATA,
    services: &[Service::BootUp],
    also: Also::Nothing,
    make: Some(|thresholds| {
        Box::new(RepeatedResets {
            times: thresholds.get(&METADATA, "times").max(1),
            within: Duration::from_millis(thresholds.get(&METADATA, "within")),
            nodes: vec![Restarts::default(); 128],
        })
    }),
};

static METADATA: Metadata = Metadata {
    id: "nodes/repeated-resets",
    severity: Severity::Error,
    title: "a node restarts again and again",
    what: "Several boot-ups of one node within a short time that no command explains.",
    why: "The node never gets to work. Its supply collapses under load, its watchdog fires, or it can't send on the \
          bus and restarts its controller.",
    advice: "Measure its supply at the device while it starts. If that is good, compare bit rate and termination, and \
             look for a second device with the same node-ID.",
    thresholds: &[
        Threshold { name: "times", default: 3, unit: "", meaning: "so many boot-ups" },
        Threshold { name: "within", default: 60_000, unit: "ms", meaning: "within this time" },
    ],
};

#[derive(Clone, Copy, Default)]
struct Restarts {
    begin: Option<Timestamp>,
    count: u64,
}

struct RepeatedResets {
    times: u64,
    within: Duration,
    nodes: Vec<Restarts>,
}

impl Rule for RepeatedResets {
    fn frame(&mut self, context: &Context<'_>, sink: &mut Sink<'_>) {
        let Some(node) = context.node() else { return };
        let restarts = &mut self.nodes[usize::from(node.raw())];
        if context.scene.facts.node(node).last_seen.is_none() || !context.scene.has_times() {
            return;
        }
        if is_explained(context, context.scene.facts.node(node)) {
            *restarts = Restarts::default();
            return;
        }
        let begin = *restarts.begin.get_or_insert(context.now());
        if context.now().since(begin) > self.within {
            *restarts = Restarts { begin: Some(context.now()), count: 0 };
        }
        restarts.count += 1;
        let count = restarts.count;
        if count >= self.times {
            let begin = restarts.begin.unwrap_or_default();
            sink.report(Report::at(context.now()).node(node).measure(count).evidence(context.evidence()), || {
                format!("{count} boot-ups within {} without a command", context.now().since(begin))
            });
        }
    }
}
